"""Impulse: the largest one that contacts give to a body within one step."""

import numpy as np

from harness.metric import Metric, NotMeasurable
from harness.metric.contact_impulses import forces_on
from harness.scene import Scene
from harness.trajectory import Trajectory
from harness.trajectory.kinematics import movable


def _measure(scene: Scene, actual: Trajectory, expected: Trajectory | None) -> float:
    if actual.contacts is None:
        raise NotMeasurable("the run has no contacts")
    if actual.dt <= 0.0:
        raise NotMeasurable("a truth has no steps")
    largest = 0.0
    for contacts in actual.contacts:
        total = forces_on(contacts, len(scene.bodies))
        # max() of Python would drop a NaN.
        largest = float(np.max([largest, *np.linalg.norm(total[movable(scene)], axis=1)]))
    return largest * actual.dt


IMPULSE_MAX = Metric(
    name="impulse_max",
    unit="N s",
    even=True,
    source="definition: greatest |sum of the contact forces on a body|, averaged over a step, times the step",
    measure=_measure,
)

METRIC = IMPULSE_MAX
