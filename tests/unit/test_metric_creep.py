"""The creep metric on ways made by hand."""

import math

import numpy as np
import pytest

from plumbline.harness.metric import NotMeasurable
from plumbline.harness.metrics.slide import creep_speed
from plumbline.harness.scene import Body, Scene
from plumbline.harness.trajectory import Trajectory

STAGE = Scene(bodies=(Body(name="held"), Body(name="held_too"), Body(name="slides"), Body(name="ground", motion="static")))
TIME = np.linspace(1.0, 3.0, 41)


def truth() -> Trajectory:
    trajectory = Trajectory.of(TIME, 4)
    trajectory.p_WB[:, 2, 0] = TIME**2
    return trajectory


def test_bodies_that_stay_do_not_creep_however_others_slide() -> None:
    assert creep_speed(STAGE, truth(), truth()) == 0.0


def test_the_fastest_held_body_counts_whichever_way_it_creeps() -> None:
    actual = truth()
    actual.p_WB[:, 0, 1] = -0.001 * TIME
    actual.p_WB[:, 1, 2] = -0.004 * TIME
    assert creep_speed(STAGE, actual, truth()) == pytest.approx(0.004)


def test_what_is_not_finite_is_never_swallowed() -> None:
    actual = truth()
    actual.v_WB[3, 0, 0] = math.inf
    assert math.isnan(creep_speed(STAGE, actual, truth()))


def test_without_held_bodies_or_a_truth_there_is_no_creep_to_measure() -> None:
    sliding = Trajectory.of(TIME, 4)
    sliding.p_WB[:, :, 0] = TIME[:, None]
    with pytest.raises(NotMeasurable, match="holds no body"):
        creep_speed(STAGE, sliding, sliding)
    with pytest.raises(NotMeasurable, match="no truth"):
        creep_speed(STAGE, truth(), None)
    with pytest.raises(NotMeasurable, match="samples, expected at least"):
        creep_speed(STAGE, Trajectory.of(TIME[:1], 4), truth())
