"""World spread: what was recorded, and nothing where nothing was."""

import math
from dataclasses import replace

import numpy as np
import pytest

from plumbline.harness.metric import NotMeasurable
from plumbline.harness.metrics.equivalence import world_spread
from plumbline.harness.scene import Body, Scene
from plumbline.harness.trajectory import Trajectory

STAGE = Scene(bodies=(Body(name="a"),))


def run(spread: float) -> Trajectory:
    return replace(Trajectory.of(np.zeros(1), 1), streams={"worlds/time": np.zeros(1), "worlds/spread": np.array([spread])})


def test_worlds_that_part_are_seen_and_equal_ones_are_not_flagged() -> None:
    assert world_spread(STAGE, run(0.0)) == 0.0
    assert world_spread(STAGE, run(1e-12)) == 1e-12
    assert math.isnan(world_spread(STAGE, run(math.nan)))


def test_worlds_that_nobody_compared_are_not_measurable() -> None:
    with pytest.raises(NotMeasurable, match="not compared"):
        world_spread(STAGE, Trajectory.of(np.zeros(1), 1))
