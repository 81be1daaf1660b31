"""Support force: do the fixed bodies carry the weight of the others?"""

import math

import numpy as np

from harness.metric import Metric, NotMeasurable
from harness.scene import Scene
from harness.trajectory import Trajectory

__all__ = ["METRIC", "SUPPORT_FORCE_ERROR"]


def _measure(scene: Scene, actual: Trajectory, expected: Trajectory | None) -> float:
    if actual.contacts is None:
        raise NotMeasurable("no contacts were recorded")
    if len(actual) == 0:
        raise NotMeasurable("no samples")
    movable = np.array([body.movable for body in scene.bodies])
    weight = sum(body.mass for body in scene.bodies if body.movable) * np.array(scene.gravity)
    if not weight.any():
        raise NotMeasurable("nothing has weight")
    if not actual.finite:
        return math.nan
    total = np.zeros(3)
    for contacts in actual.contacts:
        # force_W acts on B: it counts as it is where B alone moves, and turned where A alone does.
        a, b = movable[contacts.body_A], movable[contacts.body_B]
        total += ((b & ~a).astype(float) - (a & ~b).astype(float)) @ contacts.force_W
    return float(np.linalg.norm(total / len(actual) + weight) / np.linalg.norm(weight))


SUPPORT_FORCE_ERROR = Metric(
    name="support_force_error",
    unit="1",
    source="balance of momentum at rest: |mean contact force of the fixed bodies on the movable ones + weight| / |weight|",
    measure=_measure,
)

METRIC = SUPPORT_FORCE_ERROR
