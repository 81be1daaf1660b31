"""World spread: do equal worlds that are stepped together have the same future?"""

import numpy as np

from harness.metric import Metric, NotMeasurable
from harness.scene import Scene
from harness.trajectory import Trajectory


def _measure(scene: Scene, actual: Trajectory, expected: Trajectory | None) -> float:
    if "worlds/spread" not in actual.streams:
        raise NotMeasurable("the worlds were not compared")
    return float(np.max(actual.streams["worlds/spread"], initial=0.0))


WORLD_SPREAD = Metric(
    name="world_spread",
    unit="1",
    source="definition: largest difference of any number of a world's state at the end from the first world's, in SI units",
    measure=_measure,
)

METRIC = WORLD_SPREAD
