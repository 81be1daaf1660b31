"""The pendulum's elliptic functions against an independent integration, published period ratios and mpmath."""

import mpmath
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import solve_ivp
from scipy.special import ellipk

from plumbline.cases.joint_pendulum import CASE, RADIUS, _small_rate
from plumbline.harness.trajectory import Trajectory


@settings(max_examples=15, deadline=None)
@given(st.floats(1.0, 175.0), st.sampled_from(["rod", "point"]), st.floats(0.3, 3.0), st.floats(0.1, 10.0))
def test_the_closed_form_solves_the_equation_of_a_physical_pendulum(
    amplitude: float, kind: str, length: float, mass: float
) -> None:
    parameters = {"amplitude": amplitude, "kind": kind, "length": length, "mass": mass}
    d = length / 2 if kind == "rod" else length
    own = (RADIUS**2 + (length / 2) ** 2) / 3 if kind == "rod" else 0.4 * RADIUS**2
    time = np.linspace(0.0, 6.0, 61)
    found = solve_ivp(
        lambda _t, y: [y[1], -9.81 * d / (own + d * d) * np.sin(y[0])],
        (0, 6.0),
        [np.radians(amplitude), 0.0],
        "DOP853",
        time,
        rtol=1e-12,
        atol=1e-13,
    ).y
    truth = CASE.truth_at(time, parameters)
    assert isinstance(truth, Trajectory)
    theta, rate = found
    # DOP853 at 1e-12 a step over a few hundred steps; near the top errors grow, at most 100-fold up to 175 degrees.
    np.testing.assert_allclose(truth.p_WB[:, 0, 0], d * np.sin(theta), atol=1e-8)
    np.testing.assert_allclose(truth.p_WB[:, 0, 2], -d * np.cos(theta), atol=1e-8)
    np.testing.assert_allclose(truth.w_WB[:, 0, 1], -rate, atol=1e-7)
    np.testing.assert_allclose(truth.v_WB[:, 0, 0], d * rate * np.cos(theta), atol=1e-7)
    np.testing.assert_allclose(truth.v_WB[:, 0, 2], d * rate * np.sin(theta), atol=1e-7)


def period(degrees: float) -> float:
    """4 K(sin(theta0/2))/w0 [s]."""
    return float(4.0 * ellipk(np.sin(np.radians(degrees) / 2) ** 2) / _small_rate(CASE.parameters)[0])


@pytest.mark.parametrize(("degrees", "ratio"), [(10, 1.00191), (90, 1.18034), (179, 3.90107)])
def test_the_period_grows_with_amplitude_as_published(degrees: float, ratio: float) -> None:
    # Published to six figures.
    assert period(degrees) / period(1e-6) == pytest.approx(ratio, abs=5e-6)


@pytest.mark.parametrize("degrees", [5.0, 30.0, 120.0, 179.0])
def test_the_period_equals_its_integral_in_mpmath(degrees: float) -> None:
    with mpmath.workdps(30):
        k = mpmath.sin(mpmath.radians(degrees) / 2)
        quarter = mpmath.quad(lambda x: 1 / mpmath.sqrt(1 - (k * mpmath.sin(x)) ** 2), [0, mpmath.pi / 4, mpmath.pi / 2])
        inertia = mpmath.mpf(1) / 3 * (mpmath.mpf(RADIUS) ** 2 + mpmath.mpf("0.25")) + mpmath.mpf("0.25")
        expected = 4 * quarter * mpmath.sqrt(inertia / (mpmath.mpf("9.81") / 2))
    # SciPy's K near k = 1 loses digits of 1 - k^2.
    assert period(degrees) == pytest.approx(float(expected), rel=1e-11)


def test_the_scene_starts_where_the_truth_starts() -> None:
    for amplitude, kind in ((30.0, "rod"), (150.0, "point")):
        body = CASE.scene(CASE.at(amplitude=amplitude, kind=kind)).bodies[0]
        truth = CASE.truth_at(np.zeros(1), {"amplitude": amplitude, "kind": kind})
        assert isinstance(truth, Trajectory)
        np.testing.assert_allclose(truth.p_WB[0, 0], body.p_WB, atol=1e-14)
        np.testing.assert_allclose(truth.q_WB[0, 0], body.q_WB, atol=1e-14)
        assert np.abs(truth.v_WB).max() < 1e-14


def _leapfrog(dt: float, damping: float) -> Trajectory:
    """Semi-implicit Euler in the angle."""
    time = np.arange(round(CASE.duration / dt) + 1) * dt
    base = Trajectory.of(time, 1)
    answer = Trajectory(base.time, base.p_WB, base.q_WB, base.v_WB, base.w_WB, dt=dt)
    inertia, theta, rate = (RADIUS**2 + 0.25) / 3 + 0.25, np.radians(CASE.parameters["amplitude"]), 0.0
    for k in range(len(time)):
        answer.p_WB[k, 0] = 0.5 * np.sin(theta), 0.0, -0.5 * np.cos(theta)
        answer.q_WB[k, 0] = np.cos(theta / 2), 0.0, -np.sin(theta / 2), 0.0
        answer.w_WB[k, 0, 1] = -rate
        answer.v_WB[k, 0] = 0.5 * rate * np.cos(theta), 0.0, 0.5 * rate * np.sin(theta)
        rate = (rate - dt * 9.81 * 0.5 / inertia * np.sin(theta)) * (1 - damping * dt)
        theta = theta + dt * rate
    return answer


@pytest.mark.parametrize("dt", [1 / 60, 1 / 240, 1 / 960])
def test_semi_implicit_euler_passes_and_hidden_damping_fails(dt: float) -> None:
    scene = CASE.scene(CASE.parameters)
    for damping in (0.0, 0.04):
        answer = _leapfrog(dt, damping)
        truth = CASE.truth_at(answer.time, CASE.parameters)
        assert isinstance(truth, Trajectory)
        passed = {c.metric.name: c.passes(c.metric(scene, answer, truth), dt, CASE.parameters) for c in CASE.checks}
        assert all(passed.values()) == (damping == 0.0), passed
        assert passed["energy_drift_max"] == (damping == 0.0)
