"""Truths of the spinning and the damped cases against independent integrations of the equations of motion."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from plumbline.cases import flight_damped, spin_heavy_top, spin_intermediate_axis, spin_symmetric_top
from plumbline.harness.case import Case
from plumbline.harness.scene import EARTH_GRAVITY
from plumbline.harness.trajectory import Floats, Trajectory
from plumbline.harness.trajectory.kinematics import angle_between, rotate, rotate_back


def _truth(case: Case, time: Floats, **parameters: object) -> Trajectory:
    truth = case.truth_at(time, {**case.parameters, **parameters})
    assert isinstance(truth, Trajectory)
    return truth


def _turning(
    inertia: Floats, q: Floats, w_B: Floats, time: Floats, arm_B: Floats | None = None, weight: float = 0.0
) -> tuple[Floats, Floats]:
    """q_WB and w_B of a body that turns about a fixed point, with its weight at arm_B from it, by DOP853."""
    (A, B, C), (x, y, z) = inertia.tolist(), (0.0, 0.0, 0.0) if arm_B is None else arm_B.tolist()

    def change(_t: float, state: Floats) -> list[float]:
        s, i, j, k, a, b, c = state.tolist()  # in numbers: on arrays of three this takes ten times as long
        # The force in the body's axes: minus the weight along the last row of the rotation.
        f, g, h = (-weight * one for one in (2 * (i * k - s * j), 2 * (j * k + s * i), 1 - 2 * (i * i + j * j)))
        return [
            -(i * a + j * b + k * c) / 2,
            (s * a + j * c - k * b) / 2,
            (s * b + k * a - i * c) / 2,
            (s * c + i * b - j * a) / 2,
            (y * h - z * g - (C - B) * b * c) / A,
            (z * f - x * h - (A - C) * c * a) / B,
            (x * g - y * f - (B - A) * a * b) / C,
        ]

    found = solve_ivp(change, (0, time[-1]), [*q, *w_B], "DOP853", time, rtol=1e-12, atol=1e-13).y.T
    return found[:, :4], found[:, 4:]


@pytest.mark.parametrize("along", [0.4, 1.6])
@pytest.mark.parametrize("spin", [(0.6, 0.0, 1.0), (-0.3, 0.8, -2.0), (0.0, 0.0, 1.5), (1.0, 0.0, 0.0)])
def test_the_symmetric_top_solves_eulers_equations(along: float, spin: tuple[float, float, float]) -> None:
    time = np.linspace(0.0, 6.0, 31)
    truth = _truth(spin_symmetric_top.CASE, time, along=along, spin=spin)
    q_WB, w_B = _turning(np.array([1.0, 1.0, along]), np.array([1.0, 0, 0, 0]), np.array(spin), time)
    # DOP853 at 1e-12 a step over some hundred steps.
    assert angle_between(q_WB, truth.q_WB[:, 0]).max() < 1e-9
    np.testing.assert_allclose(truth.w_WB[:, 0], rotate(q_WB, w_B), atol=1e-9)


@pytest.mark.parametrize(
    ("tilt", "spin"),
    [*(pytest.param(*fast, marks=pytest.mark.slow) for fast in ((30.0, 200.0), (120.0, 300.0))), (60.0, 150.0)],
)
def test_the_heavy_top_solves_eulers_equations_about_its_tip(tilt: float, spin: float) -> None:
    time = np.linspace(0.0, 1.0, 21)
    truth = _truth(spin_heavy_top.CASE, time, tilt=tilt, spin=spin)
    inertia = np.array([spin_heavy_top.ACROSS, spin_heavy_top.ACROSS, spin_heavy_top.ALONG])
    start = rotate_back(truth.q_WB[0, 0], truth.w_WB[0, 0])
    arm, weight = np.array([0.0, 0.0, spin_heavy_top.LENGTH]), spin_heavy_top.MASS * spin_heavy_top.G
    q_WB, w_B = _turning(inertia, truth.q_WB[0, 0], start, time, arm, weight)
    # 200 rad turned; 1e-12 a step over a thousand steps, grown by the nutation's own stiffness.
    assert angle_between(q_WB, truth.q_WB[:, 0]).max() < 1e-7
    np.testing.assert_allclose(truth.w_WB[:, 0], rotate(q_WB, w_B), atol=1e-6)
    np.testing.assert_allclose(truth.p_WB[:, 0], rotate(q_WB, np.broadcast_to(arm, (len(time), 3))), atol=1e-8)


def test_the_steady_precession_is_the_published_figure() -> None:
    assert spin_heavy_top.precession(spin_heavy_top.P()) == pytest.approx(0.991645, abs=5e-7)
    assert spin_heavy_top.ALONG * 200 / (spin_heavy_top.ACROSS * np.cos(np.pi / 6)) - spin_heavy_top.precession(
        spin_heavy_top.P()
    ) == pytest.approx(91.3844, abs=5e-5)


def test_too_slow_a_top_has_no_steady_precession() -> None:
    with pytest.raises(ValueError, match="spin 1 rad/s, expected at least"):
        spin_heavy_top.precession(spin_heavy_top.P(30.0, 1))


@pytest.mark.parametrize("damping", [0.0, 0.5, 2.0])
def test_the_damped_fall_solves_newtons_law(damping: float) -> None:
    time = np.linspace(0.0, 3.0, 31)
    truth = _truth(flight_damped.CASE, time, linear_damping=damping, angular_damping=damping)
    velocity, spin = np.array(flight_damped.VELOCITY), np.array(flight_damped.SPIN)

    def change(_t: float, y: Floats) -> Floats:
        return np.concatenate([y[3:6], np.array(EARTH_GRAVITY) - damping * y[3:6], y[9:], -damping * y[7:]])

    found = solve_ivp(change, (0, 3), [0, 0, 0, *velocity, 0, *spin], "DOP853", time, rtol=1e-12, atol=1e-13).y.T
    np.testing.assert_allclose(truth.p_WB[:, 0], found[:, :3], atol=1e-10)
    np.testing.assert_allclose(truth.v_WB[:, 0], found[:, 3:6], atol=1e-10)
    np.testing.assert_allclose(truth.w_WB[:, 0], found[:, 7:], atol=1e-10)
    turned = np.stack([np.cos(found[:, 6] / 2), 0 * time, 0 * time, np.sin(found[:, 6] / 2)], axis=1)
    assert angle_between(turned, truth.q_WB[:, 0]).max() < 1e-9


@pytest.mark.parametrize("spin", [(0.1, 1.5, 0.6), (0.6, 1.5, 0.1)])
def test_the_time_between_flips_is_that_of_the_integrated_motion(spin: tuple[float, float, float]) -> None:
    P = spin_intermediate_axis.P
    moments = np.array(P().moments)
    time = np.linspace(0.0, 30.0, 30001)
    _, w_B = _turning(moments, np.array([1.0, 0, 0, 0]), np.array(spin), time)
    before = np.flatnonzero(w_B[:-1, 1] * w_B[1:, 1] < 0)
    instants = time[before] + 1e-3 * w_B[before, 1] / (w_B[before, 1] - w_B[before + 1, 1])
    w = np.array(spin)
    period = spin_intermediate_axis.flip_period(float(np.sum((moments * w) ** 2)), float(np.sum(moments * w**2)), P().moments)
    # Straight lines between samples of 1 ms: w'' dt^2/8 over w', far below 1e-6 s.
    np.testing.assert_allclose(np.diff(instants), period, atol=1e-6)
