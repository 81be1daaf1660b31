"""Flips and precession: a clean answer measures nothing, a planted fault by as much as was planted."""

import numpy as np
import pytest

from plumbline.cases import flight_projectile, spin_heavy_top, spin_intermediate_axis, spin_symmetric_top
from plumbline.harness.metric import NotMeasurable
from plumbline.harness.metrics.periods import flip_count_error, flip_period_error, nutation_amplitude, precession_rate_error
from plumbline.harness.trajectory import Floats, Trajectory

FLIPS, TOP = spin_intermediate_axis.CASE, spin_heavy_top.CASE


def _at(case: object, time: Floats) -> Trajectory:
    truth = case.truth_at(time, case.parameters)  # type: ignore[attr-defined]
    assert isinstance(truth, Trajectory)
    return truth


def _as(time: Floats, answer: Trajectory) -> Trajectory:
    """The same states, said to be those at other times."""
    return Trajectory(time, answer.p_WB, answer.q_WB, answer.v_WB, answer.w_WB, dt=answer.dt)


def test_the_truth_has_no_flip_too_many_and_none_too_late() -> None:
    truth = _at(FLIPS, np.linspace(0.0, 20.0, 1201))
    assert flip_count_error(FLIPS.scene(FLIPS.parameters), truth, truth) == 0
    assert flip_period_error(FLIPS.scene(FLIPS.parameters), truth, truth) == 0


def test_a_motion_ten_percent_too_slow_flips_ten_percent_too_late() -> None:
    time = np.linspace(0.0, 40.0, 2401)
    truth, slow = _at(FLIPS, time), _as(time, _at(FLIPS, time / 1.1))
    # Straight lines between samples of 1/60 s, against a period of some seconds.
    assert flip_period_error(FLIPS.scene(FLIPS.parameters), slow, truth) == pytest.approx(0.1, abs=1e-4)
    assert flip_count_error(FLIPS.scene(FLIPS.parameters), _as(time, _at(FLIPS, time / 2)), truth) >= 3


def test_a_body_that_never_flips_is_infinitely_late() -> None:
    time = np.linspace(0.0, 20.0, 1201)
    truth = _at(FLIPS, time)
    steady = Trajectory.of(time, 1)
    steady.w_WB[:, 0, 1] = 1.5
    assert flip_period_error(FLIPS.scene(FLIPS.parameters), steady, truth) == np.inf
    assert flip_count_error(FLIPS.scene(FLIPS.parameters), steady, truth) > 1
    steady.w_WB[7] = np.nan
    assert np.isnan(flip_period_error(FLIPS.scene(FLIPS.parameters), steady, truth))
    assert np.isnan(flip_count_error(FLIPS.scene(FLIPS.parameters), steady, truth))


def test_precession_is_measured_by_as_much_as_it_is_off() -> None:
    time = np.linspace(0.0, 2.0, 481)
    truth = _at(TOP, time)
    assert precession_rate_error(TOP.scene(TOP.parameters), truth, truth) == 0
    assert nutation_amplitude(TOP.scene(TOP.parameters), truth, truth) == 0
    assert precession_rate_error(TOP.scene(TOP.parameters), _as(time, _at(TOP, time * 1.05)), truth) == pytest.approx(
        0.05, rel=1e-9
    )
    fallen = spin_heavy_top.CASE.truth_at(time, {"tilt": 31.0, "spin": 200.0})
    assert isinstance(fallen, Trajectory)
    assert nutation_amplitude(TOP.scene(TOP.parameters), fallen, truth) == pytest.approx(np.radians(1.0), rel=1e-9)
    fallen.q_WB[3] = np.nan
    assert np.isnan(nutation_amplitude(TOP.scene(TOP.parameters), fallen, truth))
    assert np.isnan(precession_rate_error(TOP.scene(TOP.parameters), fallen, truth))


def test_bodies_without_the_axis_in_question_are_not_measured() -> None:
    time = np.linspace(0.0, 1.0, 61)
    ball, symmetric = flight_projectile.CASE, spin_symmetric_top.CASE
    with pytest.raises(NotMeasurable, match="middle axis"):
        flip_count_error(symmetric.scene(symmetric.parameters), _at(symmetric, time), _at(symmetric, time))
    with pytest.raises(NotMeasurable, match="axis of symmetry"):
        precession_rate_error(FLIPS.scene(FLIPS.parameters), _at(FLIPS, time), _at(FLIPS, time))
    with pytest.raises(NotMeasurable, match="no truth"):
        precession_rate_error(ball.scene(ball.parameters), _at(ball, time), None)
