"""Impulse: the largest one that contacts give to a body within one step."""

import numpy as np

from plumbline.harness.metric import NotMeasurable, Run, metric
from plumbline.harness.metric.contact_impulses import forces_on


@metric("N s", even=True)
def impulse_max(run: Run) -> float:
    """definition: greatest |sum of the contact forces on a body|, averaged over a step, times the step"""
    if run.actual.contacts is None:
        raise NotMeasurable("the run has no contacts")
    if run.actual.dt <= 0.0:
        raise NotMeasurable("a truth has no steps")
    largest = 0.0
    for contacts in run.actual.contacts:
        total = forces_on(contacts, len(run.scene.bodies))
        # max() of Python would drop a NaN.
        largest = float(np.max([largest, *np.linalg.norm(total[run.movable], axis=1)]))
    return largest * run.actual.dt
