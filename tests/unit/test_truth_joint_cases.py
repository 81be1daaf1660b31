"""Truths of the jointed cases against independent integrations of the equations of motion."""

import numpy as np
import pytest
from scipy.integrate import quad, solve_ivp

from plumbline.cases import joint_conical_pendulum, joint_fourbar, joint_limits, joint_spring
from plumbline.harness.case import Case
from plumbline.harness.scene import EARTH_GRAVITY, box_inertia
from plumbline.harness.trajectory import Floats, Trajectory
from plumbline.harness.truths.first_order import first_order_motions, true_motion

G = -EARTH_GRAVITY[2]


def _truth(case: Case, time: Floats, **parameters: object) -> Trajectory:
    truth = case.truth_at(time, {**case.parameters, **parameters})
    assert isinstance(truth, Trajectory)
    return truth


@pytest.mark.parametrize("ratio", [0.0, 0.1, 0.999999, 1.0, 1.000001, 2.0, 50.0])
def test_the_damped_oscillator_solves_its_equation(ratio: float) -> None:
    time = np.linspace(0.0, 5.0, 41)
    truth = _truth(joint_spring.CASE, time, ratios=(ratio,))

    def change(_t: float, y: Floats) -> Floats:
        return np.array([y[1], -(joint_spring.RATE**2) * y[0] - 2 * ratio * joint_spring.RATE * y[1]])

    found = solve_ivp(change, (0, 5), [joint_spring.STRETCH, 0.0], "DOP853", time, rtol=1e-12, atol=1e-14).y.T
    # Near the critical ratio the closed form divides by a difference of 1e-3 in the rates, which costs it three digits.
    np.testing.assert_allclose(truth.p_WB[:, 0, 0], found[:, 0], atol=1e-10)
    np.testing.assert_allclose(truth.v_WB[:, 0, 0], found[:, 1], atol=1e-9)


@pytest.mark.parametrize("tilt", [5.0, 30.0, 80.0])
def test_the_conical_pendulum_solves_the_equation_of_the_spherical_one(tilt: float) -> None:
    time, length = np.linspace(0.0, 4.0, 33), joint_conical_pendulum.LENGTH
    truth = _truth(joint_conical_pendulum.CASE, time, tilt=tilt)

    def change(_t: float, y: Floats) -> Floats:
        # Newton's law with the tension along the rod, from |p| = l twice differentiated.
        p, v = y[:3], y[3:]
        weight = np.array(EARTH_GRAVITY)
        return np.concatenate([v, weight - p * (p @ weight + v @ v) / length**2])

    start = [*truth.p_WB[0, 0], *truth.v_WB[0, 0]]
    found = solve_ivp(change, (0, 4), start, "DOP853", time, rtol=1e-12, atol=1e-13).y.T
    np.testing.assert_allclose(truth.p_WB[:, 0], found[:, :3], atol=1e-8)
    np.testing.assert_allclose(truth.v_WB[:, 0], found[:, 3:], atol=1e-8)


@pytest.mark.parametrize("amplitude", [60.0, 120.0])
def test_the_parallelogram_solves_lagranges_equation_of_its_crank(amplitude: float) -> None:
    time = np.linspace(0.0, 4.0, 33)
    truth = _truth(joint_fourbar.CASE, time, amplitude=amplitude)
    crank, mass = joint_fourbar.CRANK, joint_fourbar.MASS
    # T = (2 (I + m r^2/4) + m r^2) w^2/2, V = -(2 m r/2 + m r) g cos(theta), written out once more from the parts.
    inertia = 2 * (box_inertia(mass, joint_fourbar.HALF_CRANK)[1][1] + mass * (crank / 2) ** 2) + mass * crank**2

    def change(_t: float, y: Floats) -> Floats:
        return np.array([y[1], -2 * mass * crank * G * np.sin(y[0]) / inertia])

    found = solve_ivp(change, (0, 4), [np.radians(amplitude), 0.0], "DOP853", time, rtol=1e-12, atol=1e-13).y.T
    coupler = crank * np.stack([np.sin(found[:, 0]), 0 * time, -np.cos(found[:, 0])], axis=1)
    np.testing.assert_allclose(truth.p_WB[:, 2], coupler, atol=1e-8)
    np.testing.assert_allclose(truth.w_WB[:, 0, 1], -found[:, 1], atol=1e-8)
    np.testing.assert_allclose(np.linalg.norm(truth.p_WB[:, 0] - [-0.5, 0, 0], axis=1), crank / 2, atol=1e-12)
    np.testing.assert_array_equal(truth.q_WB[:, 2], np.broadcast_to([1.0, 0, 0, 0], (len(time), 4)))


def test_the_rod_reaches_its_stop_when_quadrature_says() -> None:
    for amplitude, stop in ((80.0, 20.0), (170.0, -30.0), (30.0, 29.0)):
        top, end = np.radians([amplitude, stop])

        # dt = dtheta/w with w^2 = 2 w0^2 (cos(theta) - cos(top)); theta = top - s^2 takes out the root at the start.
        def slowness(s: float, top: float = top) -> float:
            theta = top - s * s
            fall = 2 * np.sin((top + theta) / 2) * np.sin(s * s / 2)
            return (
                2 * s / (joint_limits.RATE * np.sqrt(2 * fall)) if s > 0 else 2 / (joint_limits.RATE * np.sqrt(2 * np.sin(top)))
            )

        expected, _ = quad(slowness, 0.0, float(np.sqrt(top - end)), epsabs=1e-12, epsrel=1e-12, limit=200)
        assert joint_limits.striking_time(joint_limits.P(amplitude, stop)) == pytest.approx(expected, rel=1e-9)


def test_the_stopped_rod_rests_on_its_stop() -> None:
    end = joint_limits.striking_time(joint_limits.P())
    truth = _truth(joint_limits.CASE, np.array([0.0, end - 1e-9, end + 1e-9, 3.0]))
    np.testing.assert_allclose(truth.p_WB[1, 0], truth.p_WB[2, 0], atol=1e-7)
    assert np.linalg.norm(truth.v_WB[1, 0]) > 1
    assert not truth.v_WB[2:].any()


def test_the_four_first_order_methods_are_those_that_one_steps_by_hand() -> None:
    """x'' = -x - x'/2 by each method at a small step, against the defective equations at the same step."""

    def acceleration(x: Floats, v: Floats) -> Floats:
        return -x - v / 2

    small, times = 1e-4, np.array([0.0, 1.0])
    true = true_motion(acceleration, [1.0], [0.0], times, 1e-12)[-1]
    predicted = [motion[-1] - true for motion in first_order_motions(acceleration, [1.0], [0.0], times, small)]
    stepped = []
    implicit = np.linalg.inv(np.eye(2) - small * np.array([[0.0, 1.0], [-1.0, -0.5]]))
    for forces in ("start", "end"):
        for moving in ("new", "old"):
            y = np.array([1.0, 0.0])
            for _ in range(round(1 / small)):
                ahead = implicit @ y
                a = -y[0] - y[1] / 2 if forces == "start" else (ahead[1] - y[1]) / small
                v = y[1] + small * a
                y = np.array([y[0] + small * (v if moving == "new" else y[1]), v])
            stepped.append(y - true)
    # Each method follows one of the four; what is left is of second order in the step.
    for error in stepped:
        assert min(np.abs(error - one).max() for one in predicted) < 2 * small**2 * 10
    assert max(np.abs(error).max() for error in stepped) > 100 * small**2
