"""Penetration: how deep bodies stand in one another, as the engine's own contacts say."""

import math

import numpy as np

from harness.metric import Metric, NotMeasurable
from harness.scene import Scene
from harness.trajectory import Trajectory

__all__ = ["METRIC", "PENETRATION"]


def _measure(scene: Scene, actual: Trajectory, expected: Trajectory | None) -> float:
    if actual.contacts is None:
        raise NotMeasurable("no contacts were recorded")
    if len(actual) == 0:
        raise NotMeasurable("no samples")
    gaps = np.concatenate([c.gap for c in actual.contacts])
    if not actual.finite or not np.isfinite(gaps).all():
        return math.nan
    return max(0.0, -float(gaps.min())) if len(gaps) else 0.0


PENETRATION = Metric(
    name="penetration",
    unit="m",
    source="impenetrability: greatest depth (negative gap) of any point of contact, 0 where nothing overlaps",
    measure=_measure,
)

METRIC = PENETRATION
