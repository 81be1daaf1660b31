"""Springs between points of two bodies on the engines that have none: stable at any stiffness, and the scene's equilibrium."""

from dataclasses import replace

import numpy as np
import pytest

from plumbline.harness.adapter import Adapter, Unsupported
from plumbline.harness.adapter.distance_springs import DistanceSprings
from plumbline.harness.adapter.features import features_of
from plumbline.harness.conformance.engine import Engine, state_of
from plumbline.harness.scene import WORLD, Body, Distance, Limits, Revolute, Scene, Spring, Vector3, principal_inertia
from plumbline.harness.trajectory import State
from tests.conformance.engines import adapter

DT = 1 / 240
TOP, BELOW = (0.0, 0.0, 1.0), (0.0, 0.0, 0.0)
LINE = Distance(name="line", parent=WORLD, child="bob", anchor_W=TOP, child_anchor_W=BELOW, spring=Spring(rest=1.0))
BOB = Body(name="bob", mass=2.0, inertia=principal_inertia(0.1, 0.1, 0.1))


@pytest.fixture(params=["bullet", "dart"])
def engine(request: pytest.FixtureRequest) -> Adapter:
    """Each engine whose adapter makes these springs."""
    return adapter(request.param)


def hung(stiffness: float, damping: float, **body: Vector3) -> Scene:
    """A bob of 2 kg on a spring of rest 1 m, let go where the spring is slack."""
    line = replace(LINE, spring=Spring(stiffness=stiffness, damping=damping, rest=1.0))
    return Scene(bodies=(replace(BOB, **body),), joints=(line,))


@pytest.mark.parametrize(("stiffness", "damping"), [(1e7, 0.0), (1e10, 1e5), (200.0, 1e8)])
def test_what_hangs_on_a_spring_however_stiff_comes_to_rest_or_creeps_down(
    engine: Adapter, stiffness: float, damping: float
) -> None:
    scene = hung(stiffness, damping)
    run = Engine(engine, engine.tracks["tuned"]).record(scene, 1.0, dt=DT)
    z, sag = run.p_WB[:, 0, 2], 2.0 * 9.81 / stiffness
    # Force of the start: h^2 k/m is 87 to 9e4 and h c/m up to 2e5, where 4 and 2 are the bounds of stability.
    assert np.isfinite(z).all()
    # It overshoots by about 1/(1 + 87) of the sag, which the first step leaves to be taken back.
    assert (np.abs(z) <= 1.05 * sag).all()
    if damping < 1e6:
        # The linearly implicit rule leaves a share of at most 2/sqrt(87) of a swing at each step.
        assert z[-1] == pytest.approx(-sag, rel=1e-6)
    else:
        # c z' = -m g: a creep of g m/c = 2e-7 m/s.
        assert z[-1] == pytest.approx(-2.0 * 9.81 / damping * 1.0, rel=0.01)


def test_what_a_hinge_holds_rests_on_a_stiff_spring_where_the_moments_balance(engine: Adapter) -> None:
    """A bar of 1 m on a hinge, held level at its tip: its forces are worked out with the mobility of a free bar."""
    bar = Body(name="bar", mass=3.0, inertia=principal_inertia(0.01, 0.25, 0.25), p_WB=(0.5, 0.0, 0.0))
    pin = Revolute(name="pin", parent=WORLD, child="bar", anchor_W=(0.0, 0.0, 0.0), axis_W=(0.0, 1.0, 0.0))
    stiffness = 1e6
    line = replace(
        LINE,
        child="bar",
        anchor_W=(1.0, 0.0, 1.0),
        child_anchor_W=(1.0, 0.0, 0.0),
        spring=Spring(stiffness=stiffness, rest=1.0),
    )
    scene = Scene(bodies=(bar,), joints=(pin, line))
    run = Engine(engine, engine.tracks["tuned"]).record(scene, 1.0, dt=DT)
    # m g/2 at the tip stretches the spring; the centre goes half as far down. Beyond it the bar turns by sag squared.
    sag = 3.0 * 9.81 / 2 / stiffness
    assert run.p_WB[-1, 0, 2] == pytest.approx(-sag / 2, rel=1e-3)
    assert abs(run.w_WB[-1, 0, 1]) < 1e-9


def test_a_spring_that_the_step_resolves_keeps_its_energy(engine: Adapter) -> None:
    scene = replace(hung(40.0, 0.0, v_WB=(0.3, 0.0, 0.5)), gravity=(0.0, 0.0, 0.0))
    run = Engine(engine, engine.tracks["tuned"]).record(scene, 4.0, dt=DT)
    length = np.linalg.norm(run.p_WB[:, 0] - TOP, axis=1)
    energy = np.sum(run.v_WB[:, 0] ** 2, axis=1) + 20.0 * (length - 1.0) ** 2
    # Symplectic Euler: the energy swings by about w h / 2 = .01 of itself and does not drift.
    assert energy[-240:].mean() == pytest.approx(energy[:240].mean(), rel=0.01)
    assert np.ptp(energy) < 0.05 * energy.mean()


def test_two_bodies_on_three_springs_move_as_on_an_engine_that_has_them(engine: Adapter) -> None:
    other = Body(
        name="other", mass=1.0, inertia=principal_inertia(0.02, 0.03, 0.04), p_WB=(0.6, 0.0, 0.0), w_WB=(1.0, 2.0, 0.0)
    )
    spring = Spring(stiffness=50.0, damping=0.5, rest=0.5)
    between = Distance(
        name="between", parent="bob", child="other", anchor_W=(0.1, 0.1, 0.0), child_anchor_W=(0.5, 0.0, 0.1), spring=spring
    )
    second = replace(between, name="second", anchor_W=(-0.1, 0.0, 0.1), child_anchor_W=(0.7, 0.1, 0.0))
    scene = Scene(bodies=(BOB, other), joints=(replace(LINE, spring=replace(spring, rest=0.9)), between, second))
    assert {"distance_spring"} == set(features_of(scene).names)
    mujoco = adapter("mujoco")
    ends = []
    for one in (engine, mujoco):
        with Engine(one, replace(one.tracks["default" if one is mujoco else "tuned"].with_dt(5e-4))).built(
            scene, dt=None
        ) as simulation:
            simulation.step(600)
            ends.append(state_of(simulation, scene))
    # Both are semi-implicit Euler of the same forces but for MuJoCo's implicit damper: h c/m = 5e-4 of 2 m/s.
    np.testing.assert_allclose(ends[0].p_WB, ends[1].p_WB, atol=1e-3)
    np.testing.assert_allclose(ends[0].v_WB, ends[1].v_WB, atol=1e-2)


@pytest.mark.parametrize("extra", [{"limits": Limits(upper=1.5), "spring": Spring(stiffness=1.0)}, {}])
def test_a_distance_that_is_kept_or_bounded_is_refused_by_name(engine: Adapter, extra: dict[str, object]) -> None:
    rope = Distance(name="rope", parent=WORLD, child="bob", anchor_W=TOP, child_anchor_W=BELOW, **extra)  # type: ignore[arg-type]
    with pytest.raises(Unsupported, match="joint 'rope'"):
        engine.build(Scene(bodies=(BOB,), joints=(rope,)), engine.tracks["tuned"])


def test_the_forces_on_two_bodies_are_opposite_and_have_no_moment_about_any_point() -> None:
    other = Body(name="other", p_WB=(0.6, 0.3, 0.0), v_WB=(0.0, 1.0, 0.0), w_WB=(1.0, 2.0, 0.0))
    line = Distance(
        name="l", parent="bob", child="other", anchor_W=(0.1, 0.1, 0.0), child_anchor_W=(0.5, 0.0, 0.1),
        spring=Spring(stiffness=50.0, damping=3.0, rest=0.2),
    )  # fmt: skip
    scene = Scene(bodies=(BOB, other), joints=(line,))
    for h in (1e-3, 1.0):
        springs = DistanceSprings.of(scene, scene.joints, h)
        assert springs is not None
        assert springs.implicit == (h == 1.0)
        state = State.initial(scene)
        force, torque = springs.forces(state)
        np.testing.assert_allclose(force.sum(axis=0), 0.0, atol=1e-12)
        np.testing.assert_allclose((torque + np.cross(state.p_WB, force)).sum(axis=0), 0.0, atol=1e-12)
    way = np.array([0.4, -0.1, 0.1])
    length, speed = float(np.linalg.norm(way)), np.array([0.0, 1.0, 0.0]) + np.cross((1.0, 2.0, 0.0), (-0.1, -0.3, 0.1))
    expected = 50.0 * (0.2 - length) - 3.0 * float(speed @ way) / length
    by_the_start = DistanceSprings.of(scene, scene.joints, 1e-3)
    assert by_the_start is not None
    np.testing.assert_allclose(by_the_start.forces(State.initial(scene))[0][1], expected * way / length, rtol=1e-12)
