"""Meetings: how many pairs of bodies ever touched, so that what is asked of blows is not answered by bodies that passed by."""

import numpy as np

from plumbline.harness.metric import NotMeasurable, Run, metric


@metric("1", better="higher", verdict="two bodies overlap in a point or push each other")
def pairs_met(run: Run) -> float:
    """definition: pairs of bodies with a point of contact, at some sample, that overlaps or carries a force"""
    if run.actual.contacts is None:
        raise NotMeasurable("no contacts were recorded")
    met = set()
    for contacts in run.actual.contacts:
        # Engines list pairs that are near too; those neither overlap nor push.
        touch = (contacts.gap <= 0) | (np.linalg.norm(contacts.force_W, axis=1) > 0)
        pairs = np.sort(np.stack([contacts.body_A, contacts.body_B], axis=1)[touch], axis=1)
        met |= {(int(a), int(b)) for a, b in pairs}
    return float(len(met))
