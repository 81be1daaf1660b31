"""Truths of the cases of dry friction against small steps of Coulomb's law."""

import math

import numpy as np
import pytest

from plumbline.cases import friction_creep, friction_spinning, friction_static_kinetic, friction_wall_pinch
from plumbline.harness.case import Case
from plumbline.harness.trajectory import State, Trajectory

CASES = [module.CASE for module in (friction_creep, friction_spinning, friction_static_kinetic, friction_wall_pinch)]
G = 9.81


@pytest.mark.parametrize("case", CASES, ids=lambda case: case.name)
def test_a_truth_starts_in_the_state_of_the_scene(case: Case) -> None:
    truth = case.truth_at(np.zeros(1), case.parameters)
    assert isinstance(truth, Trajectory)
    start = State.initial(case.scene(case.parameters))
    for name in ("p_WB", "q_WB", "v_WB", "w_WB"):
        np.testing.assert_allclose(getattr(truth, name)[0], getattr(start, name), atol=1e-12)


@pytest.mark.parametrize(
    ("static", "kinetic", "drawn"), [(0.6, 0.4, 0.2), (0.9, 0.1, 0.5), pytest.param(0.5, 0.49, 0.05, marks=pytest.mark.slow)]
)
def test_stick_and_slip_is_the_limit_of_small_steps(static: float, kinetic: float, drawn: float) -> None:
    module = friction_static_kinetic
    step, x, v, stuck = 1e-5, 0.0, 0.0, True
    found = []
    for k in range(400_000):
        pull = module.P().stiffness * (drawn * k * step - x) / module.MASS
        if stuck and abs(pull) > static * G:
            stuck = False
        if not stuck:
            v += step * (pull - kinetic * G)
            if v <= 0.0:
                v, stuck = 0.0, True
            x += step * v
        if k % 20_000 == 19_999:
            found.append((x, v))
    time = np.arange(1, 21) * 20_000 * step
    truth = module.CASE.truth_at(time, {**module.CASE.parameters, "static": static, "kinetic": kinetic, "drawn": drawn})
    assert isinstance(truth, Trajectory)
    # A step's delay at each change, times the largest speed or acceleration.
    np.testing.assert_allclose(truth.p_WB[:, 1, 0], [one for one, _ in found], atol=20 * step * 2)
    np.testing.assert_allclose(truth.v_WB[:, 1, 0], [one for _, one in found], atol=20 * step * 10)


def test_the_period_of_stick_and_slip_is_that_of_the_docstring() -> None:
    module = friction_static_kinetic
    time = np.linspace(0.0, 12.0, 120_001)
    truth = module.CASE.truth_at(time, module.CASE.parameters)
    assert isinstance(truth, Trajectory)
    v = truth.v_WB[:, 1, 0]
    begins = time[1:][(v[:-1] <= 1e-9) & (v[1:] > 1e-9)]
    own = module.P()
    w = math.sqrt(own.stiffness / module.MASS)
    stretch = (own.static - own.kinetic) * G / w**2
    slip = 2 / w * (math.pi - math.atan(stretch * w / own.drawn))
    assert np.diff(begins) == pytest.approx(2 * stretch / own.drawn + slip, abs=2e-4)


def test_four_feet_take_the_spin_that_their_moment_takes() -> None:
    module = friction_spinning
    own = module.P()
    stops = own.spin / module.deceleration(own.friction)
    assert stops < module.DURATION - 0.1
    truth = module.CASE.truth_at(np.array([stops / 2, stops, module.DURATION]), module.CASE.parameters)
    assert isinstance(truth, Trajectory)
    np.testing.assert_allclose(truth.w_WB[:, 1, 2], [own.spin / 2, 0.0, 0.0], atol=1e-12)
    # The work of the feet over their way is the energy of the spin.
    angle = 2 * math.atan2(truth.q_WB[1, 1, 3], truth.q_WB[1, 1, 0]) % (2 * math.pi)
    turned = own.spin * stops / 2
    assert angle == pytest.approx(turned % (2 * math.pi), abs=1e-9)
    work = own.friction * module.MASS * G * module.OUT * turned
    assert work == pytest.approx(module.INERTIA[2][2] * own.spin**2 / 2)
    scene = module.CASE.scene(module.CASE.parameters)
    feet = [placed.p_BS for placed in scene.body("stool").collision]
    assert sorted(math.hypot(x, y) for x, y, _ in feet) == pytest.approx([module.OUT] * 4)


def test_what_friction_cannot_hold_has_no_truth_of_rest() -> None:
    with pytest.raises(ValueError, match="the box slides"):
        friction_creep.CASE.truth_at(np.zeros(1), {"angle": 40.0, "friction": 0.5, "mass": 1.0})


def test_a_pinched_box_falls_with_what_friction_leaves_of_its_weight() -> None:
    case = friction_wall_pinch.CASE
    truth = case.truth_at(np.array([0.5]), case.parameters)
    assert isinstance(truth, Trajectory)
    for i, mu in enumerate(friction_wall_pinch.FRICTIONS, start=1):
        expected = 0.0 if mu * friction_wall_pinch.PUSH >= 1 else -(G - mu * friction_wall_pinch.PUSH * G) * 0.125
        assert truth.p_WB[0, i, 2] == pytest.approx(expected, abs=1e-12)
