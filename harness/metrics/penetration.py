"""Penetration: how deep bodies stand in one another, from their poses and shapes; and, apart, as the engine's contacts say.

An engine's contacts may be told for the pose before the step, be cut short, or hold margins and slops; poses cannot.
"""

import math

import numpy as np

from plumbline.harness.metric import NotMeasurable, Run, metric
from plumbline.harness.trajectory.depths import pair_depths


@metric("m", verdict="two bodies share space, by where they are and what shapes they have")
def penetration(run: Run) -> float:
    """impenetrability: the shortest way that would part two bodies (Ericson, Real-Time Collision Detection, section 4.4), from
    their poses and shapes, greatest of all pairs and samples; 0 where nothing overlaps"""
    if len(run.actual) == 0:
        raise NotMeasurable("no samples")
    if not any(run.scene.collides(a, b) for i, a in enumerate(run.scene.bodies) for b in run.scene.bodies[:i]):
        raise NotMeasurable("no two bodies can touch")
    deepest = 0.0
    for a, b, deep in pair_depths(run.scene, run.actual):
        if deep is None:
            raise NotMeasurable(f"no exact depth is known of '{run.scene.bodies[a].name}' in '{run.scene.bodies[b].name}'")
        deepest = max(deepest, float(np.max(deep)))
    return deepest


@metric("m", verdict="the engine lists a point of contact with a negative gap")
def reported_penetration(run: Run) -> float:
    """definition: greatest depth (negative gap) of any point of contact that the engine reports, 0 where none is deep"""
    if run.actual.contacts is None:
        raise NotMeasurable("no contacts were recorded")
    if len(run.actual) == 0:
        raise NotMeasurable("no samples")
    gaps = np.concatenate([c.gap for c in run.actual.contacts])
    if not np.isfinite(gaps).all():
        return math.nan
    return max(0.0, -float(gaps.min())) if len(gaps) else 0.0
