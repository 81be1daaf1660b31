"""Support force: do the fixed bodies carry the weight of the others?"""

import numpy as np

from plumbline.harness.metric import NotMeasurable, Run, metric
from plumbline.harness.metric.contact_impulses import mean_forces


@metric("1", impulses=True)
def support_force_error(run: Run) -> float:
    """balance of momentum at rest: |mean contact force of the fixed bodies on the movable ones + weight| / |weight|"""
    movable = np.array([body.movable for body in run.scene.bodies])
    weight = sum(body.mass for body in run.scene.bodies if body.movable) * np.array(run.scene.gravity)
    forces = mean_forces(run.actual, len(run.scene.bodies))
    if not weight.any():
        raise NotMeasurable("nothing has weight")
    return float(np.linalg.norm(forces[~movable][:, movable].sum(axis=(0, 1)) + weight) / np.linalg.norm(weight))
