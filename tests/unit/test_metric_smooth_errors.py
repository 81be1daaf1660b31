"""Errors against a truth: each sees what is planted in its own quantity, and nothing else."""

from dataclasses import replace

import numpy as np
import pytest

from plumbline.harness.metric import Metric, NotMeasurable
from plumbline.harness.metrics import errors
from plumbline.harness.scene import Body, Scene
from plumbline.harness.trajectory import Floats, Trajectory
from plumbline.harness.trajectory.kinematics import product

SCENE = Scene(bodies=(Body(name="a"), Body(name="b"), Body(name="rock", motion="static")))
METRICS = {
    "p_WB": (errors.position_error_max, errors.position_error_rms, errors.position_error_final),
    "v_WB": (errors.velocity_error_max, errors.velocity_error_rms, errors.velocity_error_final),
    "w_WB": (
        errors.angular_velocity_error_max,
        errors.angular_velocity_error_rms,
        errors.angular_velocity_error_final,
    ),
    "q_WB": (errors.attitude_error_max, errors.attitude_error_rms, errors.attitude_error_final),
}
ALL = [metric for metrics in METRICS.values() for metric in metrics]


def _motion() -> Trajectory:
    """Smooth motion of three bodies over 11 samples."""
    made = Trajectory.of(np.linspace(0, 1, 11), 3)
    phase = made.time[:, None, None] + np.arange(9).reshape(1, 3, 3)
    made.p_WB[:], made.v_WB[:], made.w_WB[:] = np.sin(phase), np.cos(phase), np.sin(2 * phase)
    made.q_WB[:] = np.stack([np.cos(phase[..., 0]), np.sin(phase[..., 0]), 0 * phase[..., 0], 0 * phase[..., 0]], axis=-1)
    return made


def _with(array: str, value: Floats) -> Trajectory:
    return replace(_motion(), **{array: value})


@pytest.mark.parametrize("metric", ALL, ids=lambda m: m.name)
def test_the_truth_itself_has_no_error(metric: Metric) -> None:
    # Rounding of one quaternion product under an arctangent.
    assert metric(SCENE, _motion(), _motion()) < 1e-15


@pytest.mark.parametrize("array", ["p_WB", "v_WB", "w_WB"])
def test_an_offset_of_one_body_at_one_instant_is_measured_to_the_digit(array: str) -> None:
    value = getattr(_motion(), array).copy()
    value[4, 1] += (3.0, 0.0, 4.0)
    maximum, rms, final = (metric(SCENE, _with(array, value), _motion()) for metric in METRICS[array])
    assert maximum == pytest.approx(5.0, rel=1e-14)
    assert rms == pytest.approx(5.0 / np.sqrt(22), rel=1e-14)
    assert final == 0.0
    others = [m for name, metrics in METRICS.items() if name != array for m in metrics]
    assert all(metric(SCENE, _with(array, value), _motion()) < 1e-15 for metric in others)


@pytest.mark.parametrize("angle", [1e-7, 0.3, 3.0])
def test_a_turn_by_an_angle_is_measured_as_that_angle_whatever_the_sign_of_the_quaternion(angle: float) -> None:
    q = _motion().q_WB.copy()
    q[-1, 0] = -product(q[-1, 0], np.array([np.cos(angle / 2), 0.0, np.sin(angle / 2) * 0.6, np.sin(angle / 2) * 0.8]))
    assert errors.attitude_error_max(SCENE, _with("q_WB", q), _motion()) == pytest.approx(angle, abs=1e-15)
    assert errors.attitude_error_final(SCENE, _with("q_WB", q), _motion()) == pytest.approx(angle, abs=1e-15)


def test_a_static_body_does_not_dilute_the_error() -> None:
    p = _motion().p_WB.copy()
    p[:, 2] += 100.0
    assert errors.position_error_max(SCENE, _with("p_WB", p), _motion()) == 0.0


@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf])
@pytest.mark.parametrize("array", list(METRICS))
def test_one_bad_number_makes_every_reduction_non_finite(array: str, bad: float) -> None:
    value = getattr(_motion(), array).copy()
    value[3, 0, 1] = bad
    with np.errstate(invalid="ignore"):
        found = [metric(SCENE, _with(array, value), _motion()) for metric in METRICS[array]]
    assert not np.isfinite(found).any()
    assert errors.divergence(SCENE, _with(array, value)) == np.inf


def test_a_zero_quaternion_is_no_attitude() -> None:
    q = _motion().q_WB.copy()
    q[2, 0] = 0.0
    assert np.isnan(errors.attitude_error_max(SCENE, _with("q_WB", q), _motion()))


def test_finite_states_do_not_diverge() -> None:
    assert errors.divergence(SCENE, _motion()) == 0.0


@pytest.mark.parametrize("metric", ALL, ids=lambda m: m.name)
def test_without_a_truth_at_the_same_times_nothing_is_measured(metric: Metric) -> None:
    with pytest.raises(NotMeasurable, match="no truth"):
        metric(SCENE, _motion())
    with pytest.raises(NotMeasurable, match="different times"):
        metric(SCENE, _motion(), replace(_motion(), time=_motion().time + 0.01))
    with pytest.raises(NotMeasurable, match="shape"):
        metric(SCENE, _motion(), _motion().between(0.0, 0.5))


@pytest.mark.parametrize("metric", [*ALL, errors.divergence], ids=lambda m: m.name)
def test_an_empty_window_is_not_measurable(metric: Metric) -> None:
    nothing = _motion().between(5.0, 6.0)
    with pytest.raises(NotMeasurable, match="no sample"):
        metric(SCENE, nothing, nothing)
