"""Support force: do the fixed bodies carry the weight of the others?"""

import math

import numpy as np

from harness.metric import Metric, NotMeasurable
from harness.metric.contact_impulses import mean_forces
from harness.scene import Scene
from harness.trajectory import Trajectory


def _measure(scene: Scene, actual: Trajectory, expected: Trajectory | None) -> float:
    movable = np.array([body.movable for body in scene.bodies])
    weight = sum(body.mass for body in scene.bodies if body.movable) * np.array(scene.gravity)
    forces = mean_forces(actual, len(scene.bodies))
    if not weight.any():
        raise NotMeasurable("nothing has weight")
    if not actual.finite:
        return math.nan
    return float(np.linalg.norm(forces[~movable][:, movable].sum(axis=(0, 1)) + weight) / np.linalg.norm(weight))


SUPPORT_FORCE_ERROR = Metric(
    name="support_force_error",
    unit="1",
    source="balance of momentum at rest: |mean contact force of the fixed bodies on the movable ones + weight| / |weight|",
    measure=_measure,
    impulses=True,
)

METRIC = SUPPORT_FORCE_ERROR
