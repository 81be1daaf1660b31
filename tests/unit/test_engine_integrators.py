"""Integrators of free bodies: what each conserves, its sub-steps and effects, and where it refuses."""

import itertools
import math

import numpy as np
import pytest

from plumbline import engine
from plumbline.adapters.reference import ADAPTER
from plumbline.engine.build.solids import principal_frame
from plumbline.engine.integrate.composition import KAHAN_LI_8, SUZUKI_4
from plumbline.engine.options import FREE_INTEGRATORS, INTEGRATORS
from plumbline.harness.adapter import Settings, SettingsError, Unsupported
from plumbline.harness.scene import Body, Distance, PlacedShape, Plane, Scene, Sphere, Surface, principal_inertia
from tests.free_tops import KICKED, MOMENTS, SPIN, angle_between, matrix, options_of, run, top

OF_TREES = ("implicit_midpoint", "dormand_prince")
"""Those that know trees of joints as well."""
ABOVE, CENTRE = (0.0, 0.0, 2.0), (0.0, 0.0, 1.0)
"""Anchors of a distance, which no integrator of trees knows."""


def _energy_errors(integrator: str, dt: float, steps: int, pieces: int) -> np.ndarray:
    """Relative errors of the kinetic energy of the free top, (pieces,)."""
    world = engine.World([top()], gravity=(0, 0, 0), options=options_of(integrator, dt))
    start, errors = 0.5 * MOMENTS @ np.array(SPIN) ** 2, []
    for _ in range(pieces):
        world.step(steps // pieces)
        w_B = matrix(world.state()[0, 3:7]).T @ world.state()[0, 10:]
        errors.append(0.5 * MOMENTS @ w_B**2 / start - 1)
    return np.asarray(np.abs(errors))


@pytest.mark.parametrize("integrator", KICKED)
def test_the_energy_error_stays_bounded_over_a_hundred_thousand_steps(integrator: str) -> None:
    """A symplectic or conserving method's error oscillates: the last tenth is no worse than the first, at a step of 0.1 s.

    The thousand samples of a tenth miss the crest of an oscillation by less than 5 %. Round-off may be biased by half a unit in
    the last place in each of 1e5 steps: 1e5 * 1.1e-16 / 2 = 5.5e-12.
    """
    errors = _energy_errors(integrator, 0.1, 100_000, 10_000)
    print(f"{integrator}: largest energy error {errors.max():.1e}, last {errors[-1]:.1e}")
    assert errors[-1000:].max() <= 1.05 * errors[:1000].max() + 5.5e-12


def test_explicit_euler_gains_energy_without_bound() -> None:
    """The control of the test above: its gain is h^2/2 times a square in each step, so ten times the steps give over five."""
    errors = _energy_errors("explicit_euler", 1 / 240, 10_000, 10)
    assert np.all(np.diff(errors) > 0)
    assert errors[-1] > 5 * errors[0]


def test_implicit_midpoint_keeps_energy_and_momentum_at_any_step() -> None:
    """At six steps a turn both are kept to round-off, 100 steps of some 40 roundings: 4e-13; Runge-Kutta is off by far more."""
    off = {}
    for integrator in ("implicit_midpoint", "rk4"):
        end = run(top(), options_of(integrator, 0.5), 50.0)
        turn = matrix(end[3:7])
        w_B = turn.T @ end[10:]
        energy = MOMENTS @ w_B**2 / (MOMENTS @ np.array(SPIN) ** 2) - 1
        momentum = np.linalg.norm(turn @ (MOMENTS * w_B) - MOMENTS * SPIN) / np.linalg.norm(MOMENTS * SPIN)
        off[integrator] = abs(energy), momentum
    assert max(off["implicit_midpoint"]) <= 4e-13
    assert off["rk4"][0] > 1e-4


@pytest.mark.parametrize("integrator", KICKED)
def test_a_step_back_undoes_a_step(integrator: str) -> None:
    """Symmetric methods: with reversed velocities 100 steps return to the start, but for 200 steps of 40 roundings: 1e-12."""
    out = engine.World([top()], gravity=(0, 0, 0), options=options_of(integrator, 0.1))
    out.step(100)
    out.state()[0, 7:] *= -1
    out.step(100)
    assert out.state()[0, 10:] == pytest.approx(-np.array(SPIN), abs=1e-12)
    assert angle_between(out.state()[0, 3:7], np.array([1.0, 0.0, 0.0, 0.0])) < 1e-12


@pytest.mark.parametrize("integrator", FREE_INTEGRATORS)
def test_substeps_divide_the_step(integrator: str) -> None:
    """Four sub-steps of a step are four steps of a quarter, to the rounding of dt / 4: none for a power of two."""
    body = top(angular_damping=0.5)
    one = run(body, options_of(integrator, 1 / 64, substeps=4), 1.0, (0.0, 0.0, -9.81))
    other = run(body, options_of(integrator, 1 / 256), 1.0, (0.0, 0.0, -9.81))
    assert one.tolist() == other.tolist()


@pytest.mark.parametrize("integrator", FREE_INTEGRATORS)
def test_without_the_gyroscopic_effect_the_spin_is_constant(integrator: str) -> None:
    """w' = 0: turning w into the body and back rounds 240 times by some 1e-15.

    The methods with kicks turn exactly. The others turn about the axis of w too, as q' = q w / 2 has no other direction.
    """
    end = run(top(), options_of(integrator, 1 / 240, gyroscopic=False), 1.0)
    assert end[10:] == pytest.approx(SPIN, abs=2.4e-13)
    if integrator in KICKED:
        angle, axis = np.linalg.norm(SPIN), np.array(SPIN) / np.linalg.norm(SPIN)
        assert angle_between(end[3:7], np.array([math.cos(angle / 2), *(math.sin(angle / 2) * axis)])) < 2.4e-13


@pytest.mark.parametrize("integrator", FREE_INTEGRATORS)
def test_a_kinematic_body_keeps_its_velocities_and_a_static_one_its_place(integrator: str) -> None:
    """p = v t and the angle w t to round-off, whatever the loads."""
    moving = engine.Body(name="a", motion="kinematic", v_WB=(1.0, 0.0, 0.0), w_WB=(0.0, 0.0, 2.0))
    still = engine.Body(name="b", motion="static", p_WB=(5.0, 0.0, 0.0))
    world = engine.World([moving, still], options=options_of(integrator, 1 / 240))
    world.set_load(np.ones((2, 3)), np.ones((2, 3)))
    world.step(240)
    assert world.state()[0, :3] == pytest.approx([1.0, 0.0, 0.0], abs=1e-12)
    assert 2 * math.atan2(world.state()[0, 6], world.state()[0, 3]) == pytest.approx(2.0, abs=1e-12)
    assert world.state()[1].tolist() == [5.0, 0, 0, 1, 0, 0, 0, 0, 0, 0, 0, 0, 0]


@pytest.mark.parametrize("diagonal", [*itertools.permutations((1.0, 2.0, 3.0)), (2.0, 2.0, 2.0), (2.0, 2.0, 3.0)])
def test_principal_axes_of_a_diagonal_inertia_are_the_bodys(diagonal: tuple[float, float, float]) -> None:
    """Ascending moments; the turned inertia comes back to the rounding of sums of squares of halves and roots: 1e-15."""
    moments, q = principal_frame(np.diag(diagonal))
    assert moments.tolist() == sorted(diagonal)
    assert matrix(q) @ np.diag(moments) @ matrix(q).T == pytest.approx(np.diag(diagonal), abs=4e-15)


def test_principal_axes_of_a_full_inertia_rebuild_it() -> None:
    """R diag(moments) R^T = I for 200 random tensors, to 1e-14 of their size."""
    rng = np.random.default_rng(3)
    for _ in range(200):
        turn = np.linalg.qr(rng.normal(size=(3, 3)))[0]
        inertia = turn @ np.diag(rng.uniform(1.0, 3.0, 3)) @ turn.T
        moments, q = principal_frame((inertia + inertia.T) / 2)
        assert np.all(np.diff(moments) >= 0)
        assert matrix(q) @ np.diag(moments) @ matrix(q).T == pytest.approx(inertia, abs=3e-14)


@pytest.mark.parametrize("weights", [SUZUKI_4, KAHAN_LI_8], ids=["suzuki", "kahan_li"])
def test_compositions_are_symmetric_and_of_sum_one(weights: np.ndarray) -> None:
    """Sum g = 1 and, for order four, sum g^3 = 0 (Hairer, Lubich, Wanner, section II.4), up to the rounding of 17 terms."""
    assert weights.tolist() == weights[::-1].tolist()
    assert [weights.sum(), (weights**3).sum()] == pytest.approx([1.0, 0.0], abs=2e-15)


def test_adaptive_steps_land_on_dt_and_repeat_bit_for_bit() -> None:
    """v = g t and the number of dt done are those of fixed steps; a restored world takes the same steps again."""
    world = engine.World([top()], gravity=(0, 0, -9.81), options=options_of("dormand_prince", 0.7, step_tolerance=1e-10))
    world.step(3)
    assert world.state()[0, 9] == pytest.approx(-9.81 * 2.1, abs=1e-13)
    assert world.state()[0, 2] == pytest.approx(-0.5 * 9.81 * 2.1**2, abs=1e-13)
    saved = world.save()
    world.step(5)
    first = world.state().tobytes()
    world.restore(saved)
    for _ in range(5):
        world.step()
    assert world.state().tobytes() == first


def test_adaptive_bodies_do_not_disturb_each_other() -> None:
    """Each body has a step of its own: beside a top that spins thirty times faster the slow one moves bit for bit as alone."""
    options = options_of("dormand_prince", 0.5, step_tolerance=1e-9)
    alone = engine.World([top(name="slow")], options=options)
    both = engine.World([top(name="fast", w_WB=(20.0, 30.0, 10.0)), top(name="slow")], options=options)
    for world in (alone, both):
        world.step(4)
    assert both.state()[1].tolist() == alone.state()[0].tolist()


def test_a_step_that_cannot_be_solved_is_named() -> None:
    """1e9 rad/s for a second is more turns than the adaptive method may step through: its loop ends and says so."""
    world = engine.World([top(w_WB=(1e9, 2e9, 1e9))], options=options_of("dormand_prince", 1.0, step_tolerance=1e-12))
    with pytest.raises(engine.Diverged, match=r"dormand_prince.*no solution"):
        world.step()


@pytest.mark.parametrize(
    ("options", "match"),
    [
        ({"integrator": "euler"}, "integrator 'euler'"),
        ({"integrator": "rk4", "step_tolerance": 1e-9}, "does not adapt"),
        ({"integrator": "dormand_prince", "step_tolerance": 1e-16}, "expected 1e-14"),
        ({"integrator": "dormand_prince", "step_tolerance": math.nan}, "expected 1e-14"),
    ],
)
def test_bad_options_are_named(options: dict[str, object], match: str) -> None:
    with pytest.raises(ValueError, match=match):
        engine.Options(**options)  # type: ignore[arg-type]


@pytest.mark.parametrize("integrator", FREE_INTEGRATORS)
def test_joints_and_contacts_are_refused_at_build(integrator: str) -> None:
    options = engine.Options(integrator=integrator)
    ball = engine.Body(name="ball", shapes=[engine.Placed(engine.Sphere(0.1))], p_WB=(0, 0, 1))
    ground = engine.Body(name="ground", motion="static", shapes=[engine.Placed(engine.Plane())])
    tied = engine.Distance(name="j", parent=engine.WORLD, child="ball", anchor_W=ABOVE, child_anchor_W=CENTRE)
    with pytest.raises(engine.NotSupported, match=f"'{integrator}' with contacts"):
        engine.World([ground, ball], options=options)
    with pytest.raises(engine.NotSupported, match=f"'{integrator}' with joints"):
        engine.World([ball], [tied], options=options)
    hung = engine.Ball(name="j", parent=engine.WORLD, child="ball", anchor_W=(0, 0, 2))
    if integrator in OF_TREES:
        assert engine.World([ball], [hung], options=options).in_joint_coordinates
    else:
        with pytest.raises(engine.NotSupported, match=f"'{integrator}' with joints"):
            engine.World([ball], [hung], options=options)
    free = engine.Options(integrator=integrator, contacts=False)
    assert engine.World([ground, ball], options=free).stages == ("integrator",)


@pytest.mark.parametrize("integrator", INTEGRATORS)
def test_the_adapter_offers_and_names_each_integrator(integrator: str) -> None:
    assert integrator in ADAPTER.knobs["integrator"]
    scene = Scene(bodies=(Body(name="top", mass=1.0, inertia=principal_inertia(*MOMENTS), w_WB=SPIN),))
    simulation = ADAPTER.build(scene, Settings(integrator=integrator))
    assert simulation.resolved.integrator == integrator
    assert simulation.resolved.options.get("step_tolerance") == (1e-12 if integrator == "dormand_prince" else None)
    simulation.close()


@pytest.mark.parametrize("integrator", FREE_INTEGRATORS)
def test_the_adapter_says_unsupported_where_constraints_act(integrator: str) -> None:
    ball = Body(
        name="ball",
        mass=1.0,
        inertia=principal_inertia(0.1, 0.1, 0.1),
        collision=(PlacedShape(shape=Sphere(radius=0.1)),),
        p_WB=(0, 0, 1),
    )
    ground = Body(name="ground", motion="static", collision=(PlacedShape(shape=Plane()),))
    for scene in (
        Scene(bodies=(ground, ball), surfaces=(Surface(between=("default", "default")),)),
        Scene(
            bodies=(ball,), joints=(Distance(name="j", parent="world", child="ball", anchor_W=ABOVE, child_anchor_W=CENTRE),)
        ),
    ):
        with pytest.raises(Unsupported, match=integrator):
            ADAPTER.build(scene, Settings(integrator=integrator))
    with pytest.raises(SettingsError, match="step_tolerance"):
        ADAPTER.build(scene, Settings(integrator="rk4", options={"step_tolerance": 1e-9}))
