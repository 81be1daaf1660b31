"""Penetration: how deep bodies stand in one another, from their poses and shapes; and, apart, as the engine's contacts say.

An engine's contacts may be told for the pose before the step, be cut short, or hold margins and slops; poses cannot.
"""

import math

import numpy as np

from harness.metric import Metric, NotMeasurable
from harness.scene import Scene
from harness.trajectory import Trajectory
from harness.trajectory.depths import pair_depths


def _measure(scene: Scene, actual: Trajectory, expected: Trajectory | None) -> float:
    if len(actual) == 0:
        raise NotMeasurable("no samples")
    if not actual.finite:
        return math.nan
    if not any(scene.collides(a, b) for i, a in enumerate(scene.bodies) for b in scene.bodies[:i]):
        raise NotMeasurable("no two bodies can touch")
    deepest = 0.0
    for a, b, deep in pair_depths(scene, actual):
        if deep is None:
            raise NotMeasurable(f"no exact depth is known of '{scene.bodies[a].name}' in '{scene.bodies[b].name}'")
        deepest = max(deepest, float(np.max(deep)))
    return deepest


def _reported(scene: Scene, actual: Trajectory, expected: Trajectory | None) -> float:
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
    source="impenetrability: the shortest way that would part two bodies (Ericson, Real-Time Collision Detection, section "
    "4.4), from their poses and shapes, greatest of all pairs and samples; 0 where nothing overlaps",
    measure=_measure,
    verdict="two bodies share space, by where they are and what shapes they have",
)
REPORTED_PENETRATION = Metric(
    name="reported_penetration",
    unit="m",
    source="definition: greatest depth (negative gap) of any point of contact that the engine reports, 0 where none is deep",
    measure=_reported,
    verdict="the engine lists a point of contact with a negative gap",
)

METRIC = (PENETRATION, REPORTED_PENETRATION)
