"""Sliding metrics on ways made by hand."""

import math
from dataclasses import replace

import numpy as np
import pytest

from plumbline.harness.metric import NotMeasurable
from plumbline.harness.metrics.slide import centre_rise, stop_distance_error, stop_time_error
from plumbline.harness.scene import Body, Scene
from plumbline.harness.trajectory import Trajectory

STAGE = Scene(
    bodies=(Body(name="a"), Body(name="b", p_WB=(1.0, 0.0, 0.0)), Body(name="wall", motion="static")), gravity=(0, 0, 0)
)


def run(stop: float = 1.0, azimuth: float = 0.0, interval: float = 1 / 60) -> Trajectory:
    """Both bodies slow evenly from 3 m/s to rest at `stop` [s]."""
    time = np.arange(round(2 / interval) + 1) * interval
    sliding = np.minimum(time, stop)
    trajectory = replace(Trajectory.of(time, 3), dt=interval)
    for place, start in enumerate((0.0, 1.0)):
        for axis, part in enumerate((math.cos(azimuth), math.sin(azimuth))):
            trajectory.p_WB[:, place, axis] = part * 3 * (sliding - sliding**2 / (2 * stop))
            trajectory.v_WB[:, place, axis] = part * 3 * (1 - sliding / stop)
        trajectory.p_WB[:, place, 0] += start
    return trajectory


@pytest.mark.parametrize("azimuth", [0.0, 1.0, 4.0])
@pytest.mark.parametrize("stop", [0.8, 1.0, 1.3])
def test_way_and_time_are_relative_to_the_truth_in_any_direction(stop: float, azimuth: float) -> None:
    # The way is v0 stop/2 and a tenth of the speed is left at 0.9 stop: both errors are |stop - 1|.
    actual, truth = run(stop, azimuth), run(1.0, azimuth)
    assert stop_distance_error(STAGE, actual, truth) == pytest.approx(abs(stop - 1), abs=1e-12)
    assert stop_time_error(STAGE, actual, truth) == pytest.approx(abs(stop - 1), abs=1e-12)


def test_the_worst_body_counts() -> None:
    actual = run()
    actual.p_WB[:, 1] = run(0.5).p_WB[:, 1]
    assert stop_distance_error(STAGE, actual, run()) == pytest.approx(0.5)


def test_a_body_that_never_slows_has_an_infinite_time_error() -> None:
    actual = run()
    actual.v_WB[:, 0] = (3.0, 0.0, 0.0)
    assert stop_time_error(STAGE, actual, run()) == math.inf


def test_a_hop_is_a_rise_and_sinking_is_none() -> None:
    actual = run()
    assert centre_rise(STAGE, actual) == 0.0
    actual.p_WB[7, 1, 2] = 0.003
    assert centre_rise(STAGE, actual) == pytest.approx(0.003)
    actual.p_WB[1:, :, 2] = -0.01
    assert centre_rise(STAGE, actual) == 0.0


@pytest.mark.parametrize("metric", [stop_distance_error, stop_time_error, centre_rise])
def test_what_is_not_finite_is_never_swallowed(metric: object) -> None:
    actual = run()
    actual.p_WB[5, 0, 2] = math.nan
    assert callable(metric)
    assert math.isnan(metric(STAGE, actual, run()))


def test_without_a_truth_there_is_nothing_to_compare() -> None:
    with pytest.raises(NotMeasurable, match="no truth"):
        stop_distance_error(STAGE, run(), None)
    still = Trajectory.of(run().time, 3)
    still.p_WB[:, 1, 0] = 1.0
    with pytest.raises(NotMeasurable, match="moves no body"):
        stop_distance_error(STAGE, run(), still)
    with pytest.raises(NotMeasurable, match="stops no body"):
        stop_time_error(STAGE, run(), still)
