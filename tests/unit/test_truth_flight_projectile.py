"""The parabola against an independent integration of Newton's equation."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

from plumbline.cases.flight_projectile import CASE
from plumbline.harness.adapter import Settings
from plumbline.harness.trajectory import Trajectory

speeds = st.floats(-50, 50)


@settings(max_examples=20, deadline=None)
@given(speeds, speeds, speeds)
def test_the_parabola_solves_newtons_equation(x: float, y: float, z: float) -> None:
    time = np.linspace(0.0, CASE.duration, 13)
    found = solve_ivp(
        lambda _t, s: [*s[3:], 0.0, 0.0, -9.81], (0, CASE.duration), [0, 0, 0, x, y, z], "DOP853", time, rtol=1e-12, atol=1e-12
    ).y.T
    truth = CASE.truth_at(time, {"velocity": (x, y, z)})
    assert isinstance(truth, Trajectory)
    # The polynomial is within the method's order, so that only rounding at 120 m is left.
    np.testing.assert_allclose(truth.p_WB[:, 0], found[:, :3], atol=1e-11)
    np.testing.assert_allclose(truth.v_WB[:, 0], found[:, 3:], atol=1e-11)


def _semi_implicit(dt: float, damping: float = 0.0) -> Trajectory:
    time = np.arange(round(CASE.duration / dt) + 1) * dt
    answer = Trajectory(*(getattr(Trajectory.of(time, 1), n) for n in ("time", "p_WB", "q_WB", "v_WB", "w_WB")), dt=dt)
    answer.v_WB[0, 0] = CASE.parameters["velocity"]
    for k in range(len(time) - 1):
        answer.v_WB[k + 1, 0] = (answer.v_WB[k, 0] + dt * np.array([0, 0, -9.81])) * (1 - damping * dt)
        answer.p_WB[k + 1, 0] = answer.p_WB[k, 0] + dt * answer.v_WB[k + 1, 0]
    return answer


@pytest.mark.parametrize("dt", CASE.ladder)
def test_semi_implicit_euler_passes_and_hidden_damping_fails_at_every_step_of_the_ladder(dt: float) -> None:
    scene = CASE.scene(CASE.parameters)
    for damping in (0.0, 0.04):
        answer = _semi_implicit(Settings(dt=dt).dt, damping)
        truth = CASE.truth_at(answer.time, CASE.parameters)
        assert isinstance(truth, Trajectory)
        passed = {c.metric.name: c.passes(c.metric(scene, answer, truth), dt, CASE.parameters) for c in CASE.checks}
        assert all(passed.values()) == (damping == 0.0), passed
        assert passed["position_error_max"] == passed["velocity_error_max"] == (damping == 0.0)


def test_semi_implicit_euler_errs_by_exactly_g_dt_t_over_2() -> None:
    answer = _semi_implicit(1 / 240)
    truth = CASE.truth_at(answer.time, CASE.parameters)
    assert isinstance(truth, Trajectory)
    error = truth.p_WB[:, 0, 2] - answer.p_WB[:, 0, 2]
    np.testing.assert_allclose(error, 9.81 / 240 * answer.time / 2, atol=1e-12)
