"""The double pendulum's reference against Newton and Euler's equations with constraint forces, in Cartesian coordinates."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from plumbline.cases.joint_double_pendulum import CASE
from plumbline.harness.case import Converged
from plumbline.harness.metrics.conservation import energy_drift_max
from plumbline.harness.metrics.joints import joint_gap_max
from plumbline.harness.trajectory import Floats
from plumbline.harness.truths.pendulum import INERTIA, LENGTH, MASS, D


def _newton_euler(_t: float, y: Floats) -> Floats:
    """x, z and angle of two rods; hinge forces from the constraints differentiated twice (no Lagrangian enters)."""
    q, v = y[:6], y[6:]
    (s1, c1), (s2, c2) = ((np.sin(a), np.cos(a)) for a in (q[2], q[5]))
    jacobian = np.array(
        [
            [1, 0, -D * c1, 0, 0, 0],
            [0, 1, -D * s1, 0, 0, 0],
            [-1, 0, -D * c1, 1, 0, -D * c2],
            [0, -1, -D * s1, 0, 1, -D * s2],
        ]
    )
    w1, w2 = v[2] ** 2, v[5] ** 2
    rest = np.array([-D * s1 * w1, D * c1 * w1, -D * s1 * w1 - D * s2 * w2, D * c1 * w1 + D * c2 * w2])
    matrix = np.zeros((10, 10))
    np.fill_diagonal(matrix[:6, :6], [MASS, MASS, INERTIA] * 2)
    matrix[:6, 6:], matrix[6:, :6] = -jacobian.T, jacobian
    load = np.concatenate([[0, -9.81 * MASS, 0, 0, -9.81 * MASS, 0], rest])
    return np.concatenate([v, np.linalg.solve(matrix, load)[:6]])


@pytest.mark.parametrize(
    ("upper", "lower"), [(20.0, 30.0), *(pytest.param(*far, marks=pytest.mark.slow) for far in ((-40.0, 60.0), (120.0, 80.0)))]
)
def test_the_reference_solves_newtons_and_eulers_equations(upper: float, lower: float) -> None:
    time = np.linspace(0.0, 2.0, 41)
    truth = CASE.truth_at(time, {"upper": upper, "lower": lower})
    assert isinstance(truth, Converged)
    a, b = np.radians([upper, lower])
    start = [D * np.sin(a), -D * np.cos(a), a, LENGTH * np.sin(a) + D * np.sin(b), -LENGTH * np.cos(a) - D * np.cos(b), b]
    found = solve_ivp(_newton_euler, (0, 2.0), start + [0.0] * 6, "DOP853", time, rtol=1e-12, atol=1e-13).y.T
    # 1e-12 a step over some hundred steps; the large release multiplies it about a thousandfold in 2 s.
    for body in range(2):
        np.testing.assert_allclose(truth.trajectory.p_WB[:, body, 0], found[:, 3 * body], atol=1e-8)
        np.testing.assert_allclose(truth.trajectory.p_WB[:, body, 2], found[:, 3 * body + 1], atol=1e-8)
        np.testing.assert_allclose(truth.trajectory.v_WB[:, body, 0], found[:, 6 + 3 * body], atol=1e-7)
        np.testing.assert_allclose(truth.trajectory.v_WB[:, body, 2], found[:, 7 + 3 * body], atol=1e-7)
        np.testing.assert_allclose(truth.trajectory.w_WB[:, body, 1], -found[:, 8 + 3 * body], atol=1e-7)


def test_the_default_reference_carries_an_error_bar_far_below_its_checks() -> None:
    truth = CASE.truth_at(np.linspace(0.0, CASE.duration, 301), CASE.parameters)
    assert isinstance(truth, Converged)
    assert 0.0 < truth.position_error < 1e-8
    assert 0.0 < truth.velocity_error < 1e-7
    bound = min(c.bound(min(CASE.ladder), CASE.parameters) for c in CASE.checks if c.metric.name == "position_error_max")
    assert truth.position_error < 1e-4 * bound


def test_the_reference_keeps_its_energy_and_its_hinges() -> None:
    truth = CASE.truth_at(np.linspace(0.0, CASE.duration, 301), CASE.parameters)
    assert isinstance(truth, Converged)
    scene = CASE.scene(CASE.parameters)
    # A relative tolerance of 1e-13 over some hundred steps.
    assert energy_drift_max(scene, truth.trajectory, truth.trajectory) < 1e-10
    assert joint_gap_max(scene, truth.trajectory) < 1e-14


def test_a_chaotic_release_says_so_in_its_error_bar() -> None:
    time = np.linspace(0.0, CASE.duration, 101)
    calm, wild = (CASE.truth_at(time, {"upper": u, "lower": u}) for u in (20.0, 150.0))
    assert isinstance(calm, Converged)
    assert isinstance(wild, Converged)
    assert wild.position_error > 10 * calm.position_error
