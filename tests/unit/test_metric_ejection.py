"""The ejection speed of throws in closed form."""

import math

import numpy as np
import pytest

from plumbline.harness.metric import NotMeasurable
from plumbline.harness.metrics.overlaps import ejection_speed
from plumbline.harness.scene import Body, Scene
from plumbline.harness.trajectory import Trajectory

G = 9.81
STAGE = Scene(bodies=(Body(name="ground", motion="static"), Body(name="a", p_WB=(0.0, 0.0, 0.3))))


def runs(speed: float) -> tuple[Trajectory, Trajectory]:
    """A body that leaves its place of rest upwards at `speed` [m/s], after it came up from below, and the truth of rest."""
    time = np.linspace(0.0, 1.0, 10_001)
    truth = Trajectory.of(time, 2)
    truth.p_WB[:, 1, 2] = 0.4
    run = Trajectory.of(time, 2)
    flight = np.maximum(time - 0.1, 0.0)
    run.p_WB[:, 1, 2] = np.where(time < 0.1, 0.3 + time, 0.4 + np.maximum(speed * flight - G * flight**2 / 2, 0.0))
    return run, truth


@pytest.mark.parametrize("speed", [0.0, 0.5, 3.0])
def test_the_speed_is_that_of_the_throw(speed: float) -> None:
    # Between two samples an apex is missed by at most g (0.05 ms)^2/2 = 1.2e-8 m, which 0.5 m/s turns into 2.4e-7 m/s.
    assert ejection_speed(STAGE, *runs(speed)) == pytest.approx(speed, abs=3e-7)


def test_what_comes_up_to_its_place_from_below_is_not_thrown() -> None:
    run, truth = runs(0.0)
    run.v_WB[:, 1, 2] = 1.0  # whatever an engine says of the push-out
    assert ejection_speed(STAGE, run, truth) == pytest.approx(0.0, abs=1e-7)


@pytest.mark.parametrize("bad", [math.nan, math.inf])
def test_what_is_not_finite_is_never_swallowed(bad: float) -> None:
    run, truth = runs(1.0)
    run.p_WB[5, 1, 2] = bad
    assert math.isnan(ejection_speed(STAGE, run, truth))


def test_missing_truth_and_gravity_are_not_measurable() -> None:
    run, truth = runs(1.0)
    with pytest.raises(NotMeasurable):
        ejection_speed(STAGE, run)
    with pytest.raises(NotMeasurable, match="gravity"):
        ejection_speed(Scene(bodies=STAGE.bodies, gravity=(0.0, 0.0, 0.0)), run, truth)
