"""Jitter metrics on motions made by hand."""

import math
from dataclasses import replace

import numpy as np
import pytest

from plumbline.harness.metric import NotMeasurable
from plumbline.harness.metrics.jitter import height_spread, rest_drift, rms_second_difference, rms_speed, rms_spin
from plumbline.harness.scene import Body, Scene
from plumbline.harness.trajectory import Trajectory

METRICS = (rms_speed, rms_spin, rms_second_difference, height_spread, rest_drift)

STAGE = Scene(bodies=(Body(name="ground", motion="static"), Body(name="a"), Body(name="b")))
DT = 0.01


def rest(samples: int = 201) -> Trajectory:
    return replace(Trajectory.of(np.arange(samples) * DT, 3), dt=DT)


@pytest.mark.parametrize("metric", METRICS)
def test_rest_has_no_jitter(metric: object) -> None:
    assert callable(metric)
    assert metric(STAGE, rest()) == 0.0


def test_fixed_bodies_do_not_count() -> None:
    run = rest()
    run.v_WB[:, 0] = 1.0
    assert rms_speed(STAGE, run) == 0.0


def test_root_mean_squares_take_all_axes_and_the_worst_body() -> None:
    run = rest()
    run.v_WB[:, 1] = (0.3, 0.0, 0.4)
    run.v_WB[::2, 2] = (0.0, 0.1, 0.0)
    run.w_WB[:, 2] = (0.0, 2.0, 0.0)
    assert rms_speed(STAGE, run) == pytest.approx(0.5)
    assert rms_spin(STAGE, run) == pytest.approx(2.0)


def test_an_alternating_height_shows_four_amplitudes_in_the_second_difference() -> None:
    run = rest()
    run.p_WB[:, 1, 2] = 1e-4 * (-1.0) ** np.arange(len(run))
    assert rms_second_difference(STAGE, run) == pytest.approx(4e-4)
    assert height_spread(STAGE, run) == pytest.approx(2e-4)


def test_a_uniform_drift_has_no_second_difference() -> None:
    run = rest()
    run.p_WB[:, 1, 0] = 0.1 * run.time
    assert rms_second_difference(STAGE, run) == pytest.approx(0.0, abs=1e-15)
    assert rest_drift(STAGE, run) == pytest.approx(0.2)


def test_samples_further_apart_than_a_step_cannot_show_a_second_difference() -> None:
    with pytest.raises(NotMeasurable, match="every step"):
        rms_second_difference(STAGE, replace(rest(), dt=DT / 4))


def test_one_spike_in_two_hundred_leaves_the_percentiles_alone() -> None:
    run = rest()
    run.p_WB[50, 1, 2] = 1.0
    assert height_spread(STAGE, run) == 0.0
    run.p_WB[50:60, 1, 2] = 1.0
    assert height_spread(STAGE, run) == 1.0


@pytest.mark.parametrize("metric", METRICS)
@pytest.mark.parametrize("bad", [math.nan, math.inf])
def test_what_is_not_finite_is_never_swallowed(metric: object, bad: float) -> None:
    run = rest()
    run.w_WB[7, 1, 1] = bad
    assert callable(metric)
    assert math.isnan(metric(STAGE, run))


@pytest.mark.parametrize("metric", METRICS)
def test_an_empty_window_is_not_measurable(metric: object) -> None:
    assert callable(metric)
    with pytest.raises(NotMeasurable, match="sample"):
        metric(STAGE, rest().between(99.0, 100.0))
