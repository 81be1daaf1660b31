"""What bodies give each other through contacts, in the mean over all steps.

A balance of momentum over a stretch of time holds of all steps. Forces of contacts may shake from one to the next, and the mean
of each fourth of them is another number. So the impulses of every step are summed up as a run goes, in a stream.
"""

import numpy as np

from harness.metric.metric import NotMeasurable
from harness.trajectory import Contacts, Floats, Trajectory

__all__ = ["IMPULSES", "IMPULSES_TIME", "forces_between", "mean_forces"]

IMPULSES, IMPULSES_TIME = "contacts/impulse", "contacts/time"
"""The stream: what body a gave body b since the sample before, in W [N s], antisymmetric (k, bodies, bodies, 3); its stamps."""


def forces_between(contacts: Contacts, bodies: int) -> Floats:
    """The force [N] of body a on body b at an instant, in W, antisymmetric (bodies, bodies, 3)."""
    force = np.zeros((bodies, bodies, 3))
    np.add.at(force, (contacts.body_A, contacts.body_B), contacts.force_W)
    return force - force.transpose(1, 0, 2)


def mean_forces(actual: Trajectory, bodies: int) -> Floats:
    """The mean force [N] of body a on body b, in W, antisymmetric (bodies, bodies, 3).

    It is that of all steps between the first and the last sample where they were summed up, and of the samples elsewhere.

    Raises: NotMeasurable.
    """
    if actual.contacts is None:
        raise NotMeasurable("no contacts were recorded")
    if len(actual) == 0:
        raise NotMeasurable("no samples")
    if IMPULSES in actual.streams and len(actual) > 1:
        # What came before the first sample is no part of this stretch.
        later = actual.streams[IMPULSES_TIME] > actual.time[0]
        summed: Floats = actual.streams[IMPULSES][later].sum(axis=0) / (actual.time[-1] - actual.time[0])
        return summed
    mean: Floats = np.mean([forces_between(contacts, bodies) for contacts in actual.contacts], axis=0)
    return mean
