"""Elliptic rates and the attitude by quadrature against an independent integration of Euler's equations."""

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

from plumbline.cases.spin_asymmetric_top import CASE
from plumbline.harness.trajectory import Floats, Trajectory
from plumbline.harness.trajectory.kinematics import angle_between, cross, rotate
from plumbline.harness.truths.free_rotation import body_rates


def _integrated(moments: tuple[float, float, float], spin: tuple[float, float, float], time: Floats) -> tuple[Floats, Floats]:
    """q_WB and w_B by DOP853 on q' = q (0, w_B)/2 and I w' = -w x I w."""
    inertia = np.array(moments)

    def change(_t: float, y: Floats) -> Floats:
        s, u, w = y[0], y[1:4], y[4:]
        return np.concatenate([[-u @ w / 2], (s * w + cross(u, w)) / 2, -cross(w, inertia * w) / inertia])

    found = solve_ivp(change, (0, time[-1]), [1, 0, 0, 0, *spin], "DOP853", time, rtol=1e-12, atol=1e-13).y.T
    return found[:, :4], found[:, 4:]


def _compare(moments: tuple[float, float, float], spin: tuple[float, float, float]) -> None:
    time = np.linspace(0.0, 5.0, 41)
    q_WB, w_B = _integrated(moments, spin, time)
    truth = CASE.truth_at(time, {"moments": moments, "spin": spin})
    assert isinstance(truth, Trajectory)
    # DOP853 at 1e-12 a step over some hundred steps, times the motion's own growth of errors.
    np.testing.assert_allclose(body_rates(time, moments, spin), w_B, atol=1e-8)
    assert angle_between(q_WB, truth.q_WB[:, 0]).max() < 1e-8
    np.testing.assert_allclose(truth.w_WB[:, 0], rotate(q_WB, w_B), atol=1e-8)


def test_a_spin_next_to_an_axis_loses_no_digits() -> None:
    moments, time = (1.0, 1.23828125, 1.73828125), np.linspace(0.0, 5.0, 41)
    for spin in ((0.0, 0.0, 0.4621762955259947), (1e-9, 0.0, 0.46), (-0.3, 1e-9, 1e-10)):
        _, w_B = _integrated(moments, spin, time)
        # Rates that small are kept in relation to themselves.
        np.testing.assert_allclose(body_rates(time, moments, spin), w_B, rtol=1e-8, atol=1e-16)


@pytest.mark.parametrize(
    "spin", [(0.5, 0.7, 1.2), (1.5, 0.3, -0.2), (-1.5, -0.3, 0.4), (-0.5, 0.7, -1.2), (0.4, -0.9, 1.3), (0, 0, 2), (-2, 0, 0)]
)
def test_both_regimes_and_all_signs_solve_eulers_equations(spin: tuple[float, float, float]) -> None:
    _compare((1.0, 2.0, 3.0), spin)


@settings(max_examples=20, deadline=None)
@given(st.tuples(st.floats(-2, 2), st.floats(-2, 2), st.floats(-2, 2)), st.floats(1.2, 2.5), st.floats(0.1, 0.9))
def test_any_spin_off_the_separatrix_solves_eulers_equations(
    spin: tuple[float, float, float], middle: float, share: float
) -> None:
    moments = (1.0, middle, middle + share)
    w, i = np.array(spin), np.array(moments)
    square, twice_energy = float(np.sum((i * w) ** 2)), float(np.sum(i * w**2))
    assume(square > 0.05)
    # Near the separatrix an error grows exponentially and the two solutions may part.
    assume(abs(square - twice_energy * middle) > 0.05 * square)
    _compare(moments, spin)


def test_the_separatrix_is_refused_by_name() -> None:
    with pytest.raises(ValueError, match="separatrix"):
        body_rates(np.zeros(1), (1.0, 2.0, 3.0), (0.0, 1.0, 0.0))


def _explicit(dt: float, gyroscopic: bool) -> Trajectory:
    """The textbook's first-order method: explicit torque, attitude by the new rates."""
    time = np.arange(round(CASE.duration / dt) + 1) * dt
    answer = Trajectory.of(time, 1)
    inertia, w, q = np.array(CASE.parameters["moments"]), np.array(CASE.parameters["spin"]), np.array([1.0, 0, 0, 0])
    for k in range(len(time)):
        answer.q_WB[k, 0], answer.w_WB[k, 0] = q, rotate(q, w)
        w = w - dt * cross(w, inertia * w) / inertia * gyroscopic
        half = np.linalg.norm(w) * dt / 2
        s, u = np.cos(half), np.sin(half) * w / np.linalg.norm(w)
        q = np.concatenate([[q[0] * s - q[1:] @ u], q[0] * u + s * q[1:] + cross(q[1:], u)])
    return answer


@pytest.mark.parametrize("dt", [1 / 60, pytest.param(1 / 480, marks=pytest.mark.slow)])
def test_the_first_order_method_passes_and_a_dropped_gyroscopic_term_fails(dt: float) -> None:
    scene = CASE.scene(CASE.parameters)
    for gyroscopic in (True, False):
        answer = _explicit(dt, gyroscopic)
        truth = CASE.truth_at(answer.time, CASE.parameters)
        assert isinstance(truth, Trajectory)
        passed = [c.passes(c.metric(scene, answer, truth), dt, CASE.parameters) for c in CASE.checks]
        assert all(passed) == gyroscopic
