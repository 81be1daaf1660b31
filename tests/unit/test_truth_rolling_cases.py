"""Truths of the rolling cases against independent integrations and balances of energy."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from plumbline.cases import (
    friction_backspin,
    friction_roll_incline,
    friction_rolling_resistance,
    friction_slip_to_roll,
    friction_turntable,
)
from plumbline.harness.case import Case
from plumbline.harness.trajectory import Floats, State, Trajectory
from plumbline.harness.trajectory.kinematics import angle_between
from plumbline.harness.truths.friction import grip_time, rolling

MODULES = (
    friction_backspin,
    friction_roll_incline,
    friction_rolling_resistance,
    friction_slip_to_roll,
    friction_turntable,
)
CASES = [module.CASE for module in MODULES]
G = 9.81


@pytest.mark.parametrize("case", CASES, ids=lambda case: case.name)
def test_a_truth_starts_in_the_state_of_the_scene_and_goes_on_at_its_own_speed(case: Case) -> None:
    start, time = State.initial(case.scene(case.parameters)), np.linspace(0.0, case.duration, 4001)
    truth = case.truth_at(time, case.parameters)
    assert isinstance(truth, Trajectory)
    for name in ("p_WB", "q_WB", "v_WB", "w_WB"):
        np.testing.assert_allclose(getattr(truth, name)[0], getattr(start, name), atol=1e-12)
    # The way is the integral of the velocity: trapezoids err by a'' dt^3/12 but for a step at each kink, v' dt^2.
    step = time[1]
    way = np.cumsum((truth.v_WB[1:] + truth.v_WB[:-1]) / 2 * step, axis=0)
    np.testing.assert_allclose(truth.p_WB[1:] - truth.p_WB[0], way, atol=3 * G * step**2)


@pytest.mark.parametrize("factor", [0.4, 1.0])
@pytest.mark.parametrize(
    ("speed", "rim", "friction", "pull"),
    [
        (5.0, 0.0, 0.3, 0.0),
        (2.0, -6.0, 0.3, 0.0),
        (0.0, 0.0, 0.3, 2.0),
        (0.0, 0.0, 0.05, 4.0),
        (-1.0, 3.0, 0.2, 0.5),
        (1, 4, 0.1, 0),
    ],
)
def test_rolling_is_the_limit_of_small_steps_of_coulombs_law(
    factor: float, speed: float, rim: float, friction: float, pull: float
) -> None:
    step, v, w, x, turned = 1e-5, speed, rim, 0.0, 0.0
    cone = friction * G * step
    for _ in range(100_000):
        free = v + step * pull - w
        # The impulse that ends the slip within the step, cut off at the cone.
        impulse = min(max(-free / (1 + 1 / factor), -cone), cone)
        v, w = v + step * pull + impulse, w - impulse / factor
        x, turned = x + step * v, turned + step * w
    found = [float(one[0]) for one in rolling(np.array([1.0]), speed, rim, friction, factor, pull, G)]
    # Semi-implicit steps err by half a step of the acceleration and a step of it at the kink.
    np.testing.assert_allclose(found, [x, v, turned, w], atol=3 * step * (abs(pull) + 2 * friction * G / factor))


def test_the_textbooks_figures() -> None:
    assert grip_time(5.0, 0.0, 0.3, 0.4, 0.0, G) == pytest.approx(2 * 5 / (7 * 0.3 * G))
    way, v, _, _ = rolling(np.array([grip_time(5.0, 0.0, 0.3, 0.4, 0.0, G)]), 5.0, 0.0, 0.3, 0.4, 0.0, G)
    assert way[0] == pytest.approx(12 * 25 / (49 * 0.3 * G))
    assert v[0] == pytest.approx(25 / 7)
    _, v, _, _ = rolling(np.array([10.0]), 2.0, -6.0, 0.3, 0.4, 0.0, G)
    assert v[0] == pytest.approx((5 * 2.0 + 2 * 0.1 * -60) / 7)


def test_a_grip_that_does_not_hold_is_refused() -> None:
    with pytest.raises(ValueError, match="lets the body slip again"):
        rolling(np.array([3.0]), 0.0, 1.0, 0.05, 1.0, 4.0, G)


def test_resistance_takes_the_energy_of_rolling_over_the_way() -> None:
    case = friction_rolling_resistance.CASE
    truth = case.truth_at(np.array([0.0, case.duration]), case.parameters)
    assert isinstance(truth, Trajectory)
    for i, c in enumerate(friction_rolling_resistance.COEFFICIENTS, start=1):
        way = truth.p_WB[1, i, 0]
        assert c * G * way / friction_rolling_resistance.RADIUS == pytest.approx(1.4 * friction_rolling_resistance.SPEED**2 / 2)


def test_the_ball_on_the_table_solves_newtons_and_eulers_laws_without_slip() -> None:
    case, r = friction_turntable.CASE, friction_turntable.RADIUS
    time, table = np.linspace(0.0, 4.0, 33), np.array([0.0, 0.0, friction_turntable.RATE])
    truth = case.truth_at(time, case.parameters)
    assert isinstance(truth, Trajectory)

    def change(_t: float, y: Floats) -> Floats:
        v = y[3:6]
        # Differentiating v - r w x z = W z x p gives the friction f per mass: f (1 + 5/2) = W z x v.
        f = np.cross(table, v) / 3.5
        return np.concatenate([v, f, np.cross([0.0, 0.0, -r], f) / (0.4 * r**2)])

    start = [*truth.p_WB[0, 1], *truth.v_WB[0, 1], *truth.w_WB[0, 1]]
    found = solve_ivp(change, (0, 4), start, "DOP853", time, rtol=1e-12, atol=1e-13).y.T
    np.testing.assert_allclose(truth.p_WB[:, 1], found[:, :3], atol=1e-9)
    np.testing.assert_allclose(truth.v_WB[:, 1], found[:, 3:6], atol=1e-9)
    np.testing.assert_allclose(truth.w_WB[:, 1], found[:, 6:], atol=1e-8)
    slip = truth.v_WB[:, 1] - r * np.cross(truth.w_WB[:, 1], [0, 0, 1]) - np.cross(table, truth.p_WB[:, 1])
    np.testing.assert_allclose(slip, 0.0, atol=1e-12)
    turned = case.truth_at(np.array([0.0, 1.0]), case.parameters)
    assert isinstance(turned, Trajectory)
    assert angle_between(turned.q_WB[0, 0], turned.q_WB[1, 0]) == pytest.approx(friction_turntable.RATE)
