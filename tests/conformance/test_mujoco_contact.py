"""Contact in MuJoCo: soft constraints, the law of each pair, rebounds, friction and its time constants."""

import math
from dataclasses import replace

import numpy as np
import pytest

from plumbline.adapters.mujoco import ADAPTER
from plumbline.adapters.mujoco.options import Options
from plumbline.adapters.mujoco.surfaces import contact_law
from plumbline.harness.adapter import Settings, Unsupported
from plumbline.harness.scene import (
    Body,
    Box,
    Cylinder,
    Effect,
    Fixed,
    PlacedShape,
    Scene,
    Sphere,
    Surface,
    axis_angle,
)
from plumbline.harness.trajectory import Floats
from tests.conformance.mujoco_scenes import (
    BOTH,
    DEFAULT,
    TUNED,
    G,
    built,
    ground_body,
    hinge_at,
    on_ground,
    shaped_body,
    stack,
    state_of,
)


@BOTH
def test_a_box_at_rest_presses_with_its_weight(settings: Settings) -> None:
    scene = stack(1)
    simulation = built(scene, settings)
    simulation.step(1500)
    contacts = simulation.contacts()
    assert len(contacts) == 4
    np.testing.assert_array_equal(contacts.body_A, 0)
    np.testing.assert_allclose(contacts.normal_W, [(0, 0, 1)] * 4, atol=1e-9)
    # At rest the sum is the weight up to what still moves: solver tolerance 1e-8 and the last of the settling.
    np.testing.assert_allclose(contacts.force_W.sum(axis=0), (0, 0, G), atol=1e-4)


def test_friction_is_isotropic_on_tuned_and_a_pyramid_on_default() -> None:
    v0, mu = 2.0, 0.4
    far = v0**2 / (2 * mu * G)
    stopped = {}
    for name, settings in (("default", DEFAULT), ("tuned", TUNED)):
        side = v0 / math.sqrt(2)
        scene = on_ground(shaped_body("box", Box(half_extents=(0.1, 0.1, 0.1)), (0.0, 0.0, 0.1), v=(side, side, 0.0)), mu=mu)
        simulation = built(scene, settings)
        simulation.step(1200)
        stopped[name] = float(np.linalg.norm(state_of(simulation, scene).p_WB[1, :2])) / far
    assert stopped["tuned"] == pytest.approx(1.0, abs=0.005)
    # Towards an edge the pyramid holds with mu/sqrt(2).
    assert stopped["default"] == pytest.approx(math.sqrt(2), rel=0.01)


def test_every_pair_has_its_own_law_through_priorities_or_explicit_pairs() -> None:
    half = Box(half_extents=(0.1, 0.1, 0.1))
    law = {("ground", "a"): 0.2, ("ground", "b"): 0.7, ("a", "b"): 0.0, ("a", "a"): 0.5}
    bodies = (
        ground_body(),
        *(shaped_body(f"{m}{k}", half, (3.0 * k, 0.0, 0.1), m, v=(2.0, 0.0, 0.0)) for k, m in enumerate("aab")),
    )
    surfaces = tuple(Surface(between=pair, static_friction=mu, kinetic_friction=mu) for pair, mu in law.items())
    scene = Scene(bodies=bodies, surfaces=surfaces)
    simulation = built(scene, TUNED)
    simulation.step(200)
    v = state_of(simulation, scene).v_WB[1:]
    mu = np.array([0.2, 0.2, 0.7])
    # Friction's impulse is mu times the normal one, m (g t + v_z), in every step, whatever the soft contact does upwards.
    np.testing.assert_allclose(2.0 - v[:, 0], mu * (G * 0.2 + v[:, 2]), rtol=1e-3)


def test_materials_that_are_apart_and_bodies_that_are_joined_do_not_touch() -> None:
    ball = Sphere(radius=0.1)
    scene = Scene(
        bodies=(
            shaped_body("a", ball, (0.0, 0.0, 0.0), "a"),
            shaped_body("b", ball, (0.1, 0.0, 0.0), "b"),
            shaped_body("c", ball, (0.0, 0.15, 0.0), "a"),
        ),
        apart=(("a", "b"),),
        surfaces=(Surface(between=("a", "a")),),
    )
    simulation = built(scene)
    assert [(int(a), int(b)) for a, b in zip(simulation.contacts().body_A, simulation.contacts().body_B, strict=True)] == [
        (0, 2)
    ]
    joint = Fixed(name="j", parent="a", child="c")
    assert len(built(replace(scene, joints=(joint,))).contacts()) == 0
    hinge = hinge_at("j", "a", "c", (0, 0, 0), collide=True)
    assert len(built(replace(scene, joints=(hinge,))).contacts()) == 1


@BOTH
@pytest.mark.parametrize("e", [0.5, 0.8])
def test_the_mean_rebound_over_the_phases_of_the_step_is_the_restitution(settings: Settings, e: float) -> None:
    rebounds = []
    for phase in range(8):
        scene = on_ground(shaped_body("ball", Sphere(radius=0.1), (0.0, 0.0, 1.1 + 4.4e-3 * phase / 8)), e=e)
        simulation = built(scene, settings)
        down = 0.0
        for _ in range(700):
            simulation.step()
            now = state_of(simulation, scene)
            down = min(down, now.v_WB[1, 2])
            if down < -1 and now.v_WB[1, 2] > 0 and now.p_WB[1, 2] > 0.1:
                break
        rebounds.append(now.v_WB[1, 2] / -down)
    # Calibrated without gravity, which takes g N dt = .1 of 4.4 m/s over the impact, half of it before the deepest point.
    assert np.mean(rebounds) == pytest.approx(e, abs=0.012)
    assert np.ptp(rebounds) < 0.09


def test_without_restitution_a_free_body_leaves_with_what_a_contact_that_cannot_pull_gives_back() -> None:
    """x = -v t exp(-w t) is pushed until w t = 2, when its speed is exp(-2) v; 200 steps to 1/w leave half a per cent of it."""
    rebounds = []
    for phase in range(4):
        ball = replace(shaped_body("ball", Sphere(radius=0.1), (0.0, 0.0, 0.101 + 5e-5 * phase)), v_WB=(0.0, 0.0, -2.0))
        scene = replace(on_ground(ball), gravity=(0.0, 0.0, 0.0))
        simulation = built(scene, DEFAULT, dt=1e-4)
        simulation.step(2000)
        rebounds.append(state_of(simulation, scene).v_WB[1, 2] / 2)
    assert np.mean(rebounds) == pytest.approx(math.exp(-2), rel=0.01)


def test_no_restitution_is_no_rebound_and_too_little_is_refused() -> None:
    for settings in (DEFAULT, TUNED):
        scene = on_ground(shaped_body("ball", Sphere(radius=0.1), (0.0, 0.0, 0.6)))
        simulation = built(scene, settings)
        high = []
        for _ in range(150):
            simulation.step(10)
            high.append(state_of(simulation, scene).v_WB[1, 2])
        # It climbs out of the soft contact more slowly than its depth (30 mm) over its time constant (20 ms) and a third.
        assert max(high) < 0.5
        assert state_of(simulation, scene).p_WB[1, 2] == pytest.approx(0.1, abs=1e-3)
    with pytest.raises(Unsupported, match=r"restitution 0\.01"):
        built(on_ground(shaped_body("ball", Sphere(radius=0.1), (0.0, 0.0, 0.6)), e=0.01))


def test_friction_in_a_rebound_is_mu_times_the_normal_impulse() -> None:
    for settings in (DEFAULT, TUNED):
        scene = replace(
            on_ground(shaped_body("ball", Sphere(radius=0.1), (0.0, 0.0, 0.3), v=(5.0, 0.0, -3.0)), mu=0.2, e=0.8),
            gravity=(0.0, 0.0, 0.0),
        )
        simulation = built(scene, settings)
        simulation.step(300)
        v = state_of(simulation, scene).v_WB[1]
        assert 5.0 - v[0] == pytest.approx(0.2 * (3.0 + v[2]), rel=1e-6)
        assert simulation.resolved.options["cone"] == "elliptic"
    with pytest.raises(Unsupported, match="pyramid"):
        built(scene, Settings(options={"cone": "pyramidal"}))


PHASES = (np.arange(8) + 0.5) / 8
"""Of the step, at which a ball meets the ground."""
REBOUNDING = Effect.CONTACT | Effect.FRICTION | Effect.RESTITUTION


def _bent(slip: float, mu: float, restitution: float, friction_constant: float) -> float:
    """The mean rebound over e, less 1, of a ball at 1 m/s and a slip [m/s], in MuJoCo's own words throughout."""
    mj, law = pytest.importorskip("mujoco"), contact_law(_surface(mu, restitution), REBOUNDING, Options(), 1e-3, "euler")
    left = []
    for phase in PHASES:
        spec = mj.MjSpec()
        spec.option.timestep, spec.option.gravity, spec.option.cone = 1e-3, (0.0, 0.0, 0.0), mj.mjtCone.mjCONE_ELLIPTIC
        ball = spec.worldbody.add_body(pos=(0.0, 0.0, 0.105 + phase * 1e-3))
        ball.add_freejoint()
        ball.add_geom(name="ball", type=mj.mjtGeom.mjGEOM_SPHERE, size=(0.1, 0.0, 0.0), mass=1.0)
        spec.worldbody.add_geom(name="floor", type=mj.mjtGeom.mjGEOM_PLANE, size=(0.0, 0.0, 1.0))
        pair = spec.add_pair(geomname1="floor", geomname2="ball")
        pair.condim, pair.friction, pair.solref, pair.solimp = 3, (mu, mu, 0.0, 0.0, 0.0), law.solref, law.solimp
        pair.solreffriction = (friction_constant, 1.0)
        model = spec.compile()
        data = mj.MjData(model)
        data.qvel[:3] = slip, 0.0, -1.0
        mj.mj_step(model, data, 120)
        left.append(float(data.qvel[2]))
    return float(np.mean(left)) / restitution - 1


def _surface(mu: float, e: float) -> Surface:
    return Surface(between=("ground", "block"), static_friction=mu, kinetic_friction=mu, restitution=e)


@pytest.mark.parametrize(
    ("e", "slips", "low", "high"),
    [(0.8, (0.3, 1.0), -0.05, 0.05), (0.8, (2.0, 3.0), -0.2, 0.13), (0.5, (1.0, 3.0), -0.2, 0.13), (0.3, (3.0,), 0.4, 0.43)],
)
def test_a_slip_bends_the_rebound_by_what_is_declared_and_it_is_the_engine_that_does_it(
    e: float, slips: tuple[float, ...], low: float, high: float
) -> None:
    """The figures are those of *Deviations*; a ball without friction keeps the rebound to the scatter of eight phases, 1 %."""
    for slip in slips:
        assert low <= _bent(slip, 0.3, e, 0.01) <= high
        assert abs(_bent(slip, 1e-9, e, 0.01)) < 0.01
        left = []
        for phase in PHASES:
            ball = shaped_body("ball", Sphere(radius=0.1), (0.0, 0.0, 0.105 + phase * 1e-3), v=(slip, 0.0, -1.0))
            scene = replace(on_ground(ball, mu=0.3, e=e), gravity=(0.0, 0.0, 0.0))
            simulation = built(scene, TUNED)
            simulation.step(120)
            left.append(state_of(simulation, scene).v_WB[1, 2])
        # The same phases of the step, and the solver's tolerance of 1e-10 against the vendor's of 1e-8.
        assert float(np.mean(left)) / e - 1 == pytest.approx(_bent(slip, 0.3, e, 0.01), abs=1e-4)


def test_friction_as_slow_as_the_impact_bends_the_rebound_less_than_half_as_fast_a_one() -> None:
    """At e = .8 and mu = .3 a slip of twice the approach: -12 % against -23 %, in MuJoCo's own words."""
    assert abs(_bent(2.0, 0.3, 0.8, 0.01)) < 0.6 * abs(_bent(2.0, 0.3, 0.8, 0.005))
    scene = on_ground(shaped_body("ball", Sphere(radius=0.1), (0.0, 0.0, 0.3)), mu=0.3, e=0.8)
    assert list(built(scene, TUNED)._m.pair_solreffriction[0]) == pytest.approx([0.01, 1.0])


@BOTH
def test_a_kinematic_table_turns_on_under_load_and_drags_what_lies_on_it(settings: Settings) -> None:
    table = Body(
        name="table", motion="kinematic", material="ground", v_WB=(0.1, 0.0, 0.0), w_WB=(0.0, 0.0, 2.0),
        collision=(PlacedShape(shape=Cylinder(radius=2.0, half_length=0.1)),),
    )  # fmt: skip
    scene = Scene(
        bodies=(table, shaped_body("ball", Sphere(radius=0.1), (0.5, 0.0, 0.2))),
        surfaces=(Surface(between=("ground", "block"), static_friction=0.5, kinetic_friction=0.5),),
    )
    simulation = built(scene, settings)
    simulation.step(2000)
    end = state_of(simulation, scene)
    # The ball's weight moves it by g t/1e12.
    np.testing.assert_allclose(end.p_WB[0], (0.2, 0.0, 0.0), atol=1e-9)
    np.testing.assert_allclose(end.w_WB[0], (0.0, 0.0, 2.0), atol=1e-10)
    np.testing.assert_allclose(end.q_WB[0], axis_angle((0.0, 0.0, 1.0), 4.0), atol=1e-9)
    np.testing.assert_allclose(simulation.contacts().force_W[0, 2], G, rtol=1e-6)
    assert np.linalg.norm(end.v_WB[1, :2]) > 0.1


def test_time_constants_are_what_resolved_says_and_bounded_only_by_a_bound_that_is_set() -> None:
    """A ball that falls on steps of 1/60 s: the engine's own way with a constant of two steps, and with what is asked."""
    ball = on_ground(shaped_body("ball", Sphere(radius=0.1), (0.0, 0.0, 0.3)))

    def landed(options: dict[str, object], dt: float) -> tuple[float, float]:
        simulation = built(ball, Settings(options=options), dt)
        simulation.step(round(0.4 / dt))
        return simulation.resolved.options["contact_time_constant"], float(state_of(simulation, ball).p_WB[1, 2])

    asked, sunk = landed({"contact_steps": 20.0}, 1 / 240)
    assert asked == pytest.approx(20 / 240)
    bounded, shallow = landed({"contact_steps": 20.0, "slowest": 0.02}, 1 / 240)
    assert bounded == pytest.approx(0.02)
    assert shallow > sunk
    # mjDSBL_REFSAFE: at 1/60 s both ask for less than two steps, and get two.
    vendor, two = landed({}, 1 / 60), landed({"contact_steps": 2.0}, 1 / 60)
    assert vendor == two
    assert vendor[0] == pytest.approx(2 / 60)
    assert built(ball, TUNED, 1 / 240).resolved.options["contact_time_constant"] == pytest.approx(0.02)


def test_friction_takes_its_own_time_constant_and_a_pyramid_has_none() -> None:
    """A cube slides at 5 cm/s: with a constant tc, b = 2/tc slows it by 2 v/tc where that is below mu g."""
    scene, dt = on_ground(shaped_body("cube", Box(half_extents=(0.1, 0.1, 0.1)), (0.0, 0.0, 0.1)), mu=0.5), 1e-3
    for steps, constant, slowed in ((30.0, 0.03, 3.333), (40.0, 0.04, 2.5), (80.0, 0.08, 1.25)):
        options = {**TUNED.options, "friction_steps": steps, "slowest": 1.0}
        simulation = built(scene, replace(TUNED, options=options), dt)
        assert simulation.resolved.options["friction_time_constant"] == pytest.approx(constant)
        simulation.step(1000)
        simulation._d.qvel[0] = 0.05
        simulation.step()
        # Exact but for the share of .999 that the impedance leaves to the reference.
        assert (0.05 - state_of(simulation, scene).v_WB[1, 0]) / dt == pytest.approx(slowed, rel=2e-3)
    options = {**TUNED.options, "friction_steps": 2.0, "cone": "pyramidal"}
    pyramid = built(scene, replace(TUNED, options=options), dt).resolved.options
    assert pyramid["friction_time_constant"] == pyramid["contact_time_constant"] == pytest.approx(0.02)


def test_the_next_value_of_every_knob_of_contact_tells_at_the_usual_step() -> None:
    """A search turns each knob once, to its next value, and leaves alone what then changes nothing, bit for bit."""
    box = shaped_body("box", Box(half_extents=(0.1, 0.1, 0.1)), (0.0, 0.0, 0.11), v=(0.5, 0.0, 0.0))
    scene = on_ground(box, mu=0.5)

    def end(settings: Settings) -> Floats:
        simulation = ADAPTER.build(scene, settings.with_dt(1 / 240))
        simulation.step(60)
        return state_of(simulation, scene).p_WB

    own = end(TUNED)
    knobs = ("contact_steps", "contact_damping_ratio", "contact_impedance", "friction_steps", "slowest", "impratio", "cone")
    for knob in knobs:
        values = ADAPTER.knobs[f"options.{knob}"]
        now = TUNED.options.get(knob)
        following = values[values.index(now) + 1] if now in values[:-1] else values[0]
        assert not np.array_equal(end(replace(TUNED, options={**TUNED.options, knob: following})), own), knob


def test_what_resolved_says_is_what_acts() -> None:
    """At the usual step the bound `slowest` says how slow friction is: other `friction_steps` change no word and no motion."""
    cube = on_ground(shaped_body("cube", Box(half_extents=(0.1, 0.1, 0.1)), (0.0, 0.0, 0.11), v=(0.5, 0.0, 0.0)), mu=0.5)
    told = [built(cube, replace(TUNED, options={**TUNED.options, "friction_steps": n}), 1 / 240).resolved for n in (20.0, 40.0)]
    assert told[0] == told[1]
    assert built(cube, TUNED, 1 / 240).resolved.options["rebound_friction_steps"] is None


def test_friction_of_a_rebound_is_as_slow_as_the_impact_or_as_it_is_told() -> None:
    scene = on_ground(shaped_body("ball", Sphere(radius=0.1), (0.0, 0.0, 0.3)), mu=0.3, e=0.8)
    for told, constant in (({}, 10e-3), ({"rebound_steps": 40}, 40e-3), ({"rebound_steps": 40, "friction_steps": 60.0}, 60e-3)):
        simulation = built(scene, replace(TUNED, options={**TUNED.options, **told}))
        assert list(simulation._m.pair_solreffriction[0]) == pytest.approx([constant, 1.0])
        assert simulation.resolved.options["rebound_friction_steps"] == pytest.approx(constant / 1e-3)
