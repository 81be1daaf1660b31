"""What the adapter of Bullet chooses by the scene: constraints for fast tops, sub-steps, iterations, held feet, whose forces it
reports."""

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from plumbline.adapters.bullet import ADAPTER
from plumbline.harness.adapter import Settings, SettingsError
from plumbline.harness.scene import WORLD, Ball, Body, Scene, principal_inertia
from plumbline.harness.study import plugins
from plumbline.harness.trajectory import Contacts, State
from tests.conformance.put import Answer, put

pytest.importorskip("pybullet", reason="pybullet publishes wheels for Python 3.10 and 3.11 only")

G = 9.81
CASES = plugins.cases()
DEFAULT, TUNED = ADAPTER.tracks["default"], ADAPTER.tracks["tuned"]


def with_options(settings: Settings, **options: Any) -> Settings:
    return replace(settings, options={**settings.options, **options})


def answer(case: str, settings: Settings, **parameters: float) -> Answer:
    return put(CASES[case], ADAPTER, settings, parameters=parameters)


def spinning(spin: float, across: float = 0.0) -> Scene:
    """A body of 1 kg, a ball of 0.01 kg m2, above a ball joint, that spins about the line to it [rad/s], and across it."""
    body = Body(
        name="top",
        inertia=principal_inertia(0.01, 0.01, 0.01),
        p_WB=(0.0, 0.0, 0.1),
        v_WB=(0.0, -0.1 * across, 0.0),
        w_WB=(across, 0.0, spin),
    )
    return Scene(bodies=(body,), joints=(Ball(name="tip", parent=WORLD, child="top", anchor_W=(0.0, 0.0, 0.0)),))


def links(scene: Scene, settings: Settings) -> int:
    """How many bodies are links of multibodies."""
    simulation: Any = ADAPTER.build(scene, settings)
    try:
        return sum(len(places) for places in simulation._made.linked.values())
    finally:
        simulation.close()


def test_a_ball_joint_is_a_constraint_from_the_spin_on_that_gravity_cannot_overturn() -> None:
    # I w = sqrt(4 (I + m l^2) m g l): sqrt(4 * 0.02 * 0.981)/0.01 = 28.01 rad/s.
    least = math.sqrt(4 * 0.02 * G * 0.1) / 0.01
    assert links(spinning(0.99 * least), TUNED) == 1
    assert links(spinning(1.01 * least), TUNED) == 0
    assert links(spinning(-1.01 * least), TUNED) == 0
    # What turns across more than it spins is a pendulum.
    assert links(spinning(40.0, across=41.0), TUNED) == 1
    assert links(spinning(1000.0), DEFAULT) == 1
    assert links(spinning(0.0), with_options(TUNED, joints="constraints")) == 0


def test_a_held_body_that_is_damped_is_refused_and_not_left_undamped() -> None:
    scene = spinning(100.0)
    damped = replace(scene, bodies=(replace(scene.bodies[0], linear_damping=1.0),))
    with pytest.raises(Exception, match="damping of body 'top'"):
        ADAPTER.build(damped, TUNED)


@pytest.mark.parametrize("spin", [100.0, 800.0, 5000.0])
def test_tuned_carries_a_fast_top_to_the_end_of_its_axis(spin: float) -> None:
    # First order: 6 m/s times the 1/960 s that a held top is stepped by; a tenth of the scale, 10 mm, would be lost.
    assert answer("spin_heavy_top", TUNED, spin=spin)["position_error_max"] < 6.0 / 960


def test_steps_longer_than_the_vendors_are_cut_and_no_others() -> None:
    scene = Scene(bodies=(Body(name="body"),))

    def substeps(settings: Settings) -> int | None:
        simulation = ADAPTER.build(scene, settings)
        try:
            return simulation.resolved.substeps
        finally:
            simulation.close()

    for dt, due in ((1 / 15, 16), (1 / 60, 4), (0.01, 3), (1 / 240, 1), (1e-3, 1)):
        assert substeps(TUNED.with_dt(dt)) == due
        assert substeps(DEFAULT.with_dt(dt)) == 1
    assert substeps(replace(TUNED.with_dt(1 / 15), substeps=2)) == 2
    assert substeps(with_options(DEFAULT, longest_step=0.5e-3).with_dt(1e-3)) == 2
    with pytest.raises(SettingsError, match="longest_step"):
        substeps(with_options(TUNED, longest_step=0.0))


@pytest.mark.parametrize(("ratio", "due"), [(1, 200), (333, 200), (500, 300), (1000, 600), (2000, 1200), (1e6, 1200)])
def test_iterations_go_by_the_ratio_of_the_masses_unless_they_are_told(ratio: float, due: int) -> None:
    scene = CASES["stack_mass_ratio"].scene(CASES["stack_mass_ratio"].at(ratio=ratio))

    def iterations(told: Scene, settings: Settings) -> int | None:
        simulation = ADAPTER.build(told, settings)
        try:
            return simulation.resolved.iterations
        finally:
            simulation.close()

    assert iterations(scene, TUNED) == due
    assert iterations(scene, replace(TUNED, iterations=77)) == 77
    assert iterations(scene, DEFAULT) == 50
    # Without weight nothing lies on anything.
    assert iterations(replace(scene, gravity=(0.0, 0.0, 0.0)), TUNED) == 200


@pytest.mark.parametrize("ratio", [500, 800, 1250, pytest.param(2000, marks=pytest.mark.slow)])
def test_a_light_box_bears_one_of_any_such_ratio(ratio: float) -> None:
    assert not answer("stack_mass_ratio", TUNED, ratio=ratio).broken


def test_tuned_holds_a_tower_of_sixteen_at_a_15th() -> None:
    # A second of the case's five: what sinks has sunk by then, and what falls is on its way.
    found = put(replace(CASES["stack_tower"], duration=1.0), ADAPTER, TUNED.with_dt(1 / 15), parameters={"n": 16})
    # 16 sub-steps are the vendor's own step, and its error: each box sees its support k steps late.
    dt, n = 1 / 240, 16
    assert found["stack_height_error"] < G * dt**2 * n * (n + 1) / 2 / ((2 * n - 1) * 0.1)


@pytest.mark.parametrize("substeps", [1, 4])
@pytest.mark.parametrize("case", ["friction_backspin", "impact_bounce", "friction_slip_to_roll"])
def test_reported_forces_are_what_changes_the_momentum_whatever_the_sub_steps(case: str, substeps: int) -> None:
    # Forces and velocities of one solve: what rounding and the tolerance of 200 iterations leave.
    assert answer(case, replace(TUNED.with_dt(1 / 60), substeps=substeps))["momentum_residual"] < 1e-6


def test_a_body_at_rest_is_borne_by_its_weight_at_any_number_of_sub_steps() -> None:
    case = CASES["rest_penetration"]
    scene = case.scene(case.at(shape="sphere"))
    for substeps in (1, 3):
        simulation = ADAPTER.build(scene, replace(TUNED, substeps=substeps))
        try:
            asked: list[Contacts] = []
            for _ in range(240):
                asked.append(simulation.contacts())
                simulation.step()
            force = simulation.contacts().force_W.sum(axis=0)
        finally:
            simulation.close()
        assert np.abs(force) == pytest.approx([0.0, 0.0, G], abs=1e-6)


def test_an_orbit_under_outer_forces_keeps_its_energy_with_sub_steps() -> None:
    # A tenth of the case's hundred revolutions: its energy comes back after each of them, or leaves with each.
    case = replace(CASES["orbit_kepler"], duration=10.0)
    found, plain = (put(case, ADAPTER, replace(TUNED, substeps=count)) for count in (4, 1))
    assert not found.broken
    # The force is held over the step; told at the wrong instant of it, it would feed the orbit by its own size.
    assert found["orbit_energy_drift_max"] < 1.1 * plain["orbit_energy_drift_max"]


@pytest.mark.parametrize("case", [pytest.param("stand_quadruped", marks=pytest.mark.slow), "stand_humanoid"])
@pytest.mark.parametrize("rate", [60, *(pytest.param(rate, marks=pytest.mark.slow) for rate in (120, 240))])
def test_machines_stand_on_the_scenes_own_drives_in_one_step(case: str, rate: int) -> None:
    assert not answer(case, replace(TUNED.with_dt(1 / rate), substeps=1)).broken


@pytest.mark.parametrize("stiffness", [*(pytest.param(k, marks=pytest.mark.slow) for k in (400.0, 8000.0)), 80000.0])
def test_a_quadruped_stands_on_drives_of_any_stiffness(stiffness: float) -> None:
    assert not answer("stand_quadruped", replace(TUNED, substeps=1), stiffness=stiffness).broken


def test_the_engines_own_motors_are_rigid_and_said_to_be_another_law() -> None:
    case = CASES["stand_quadruped"]
    scene = case.scene(case.parameters)
    rigid = with_options(TUNED, drives="motor")
    simulation = ADAPTER.build(scene, rigid)
    try:
        assert any("deviation: drives" in notice.text for notice in simulation.warnings())
    finally:
        simulation.close()
    # Each joint goes to its target, which lies torque/stiffness beyond the pose that the drive's own law would hold.
    gives = max(abs(joint.drive.target - joint.position) for joint in scene.joints if getattr(joint, "drive", None))
    found = put(replace(case, duration=1.0), ADAPTER, rigid.with_dt(1 / 240))
    assert found["standing_height"] > 0.9
    assert found["pose_error_max"] == pytest.approx(gives, rel=0.2)


def test_where_points_are_let_go_is_each_world_s_own_though_bullet_has_one_gap_for_all() -> None:
    """A block that slides down a plane: the gap at which its points are let go decides which of them rub."""
    case = plugins.case("friction_roll_incline")
    scene = case.scene(case.parameters)
    settings = with_options(ADAPTER.tracks["default"].with_dt(1 / 240))

    def place(simulation: Any) -> np.ndarray:
        state = State.empty(len(scene.bodies))
        simulation.state(state)
        return state.p_WB.copy()

    alone = ADAPTER.build(scene, settings)
    alone.step(120)
    expected = place(alone)
    alone.close()
    plain, other = ADAPTER.build(scene, settings), ADAPTER.build(scene, with_options(settings, contact_breaking=0.001))
    for _ in range(120):
        plain.step()
        other.step()
    assert np.array_equal(place(plain), expected)
    assert not np.array_equal(place(other), expected)
    other.close()
    plain.close()
