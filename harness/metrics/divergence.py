"""Divergence: zero while every number of every state is finite, infinite otherwise."""

import numpy as np

from harness.metric import Metric, NotMeasurable
from harness.scene import Scene
from harness.trajectory import Trajectory


def _divergence(_scene: Scene, actual: Trajectory, _expected: Trajectory | None) -> float:
    if len(actual) == 0:
        raise NotMeasurable("no sample lies in the time that is judged")
    return 0.0 if actual.finite else float(np.inf)


METRIC = DIVERGENCE = Metric(
    name="divergence",
    unit="1",
    source="definition: 0 if all states are finite, else infinite",
    measure=_divergence,
    verdict="a number is not finite",
)
