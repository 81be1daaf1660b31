"""Contact flips: how often points of contact appear and vanish."""

import math
from collections import Counter
from itertools import pairwise

import numpy as np

from plumbline.harness.metric import NotMeasurable, Run, metric
from plumbline.harness.trajectory import Contacts


def _bearing(contacts: Contacts) -> Counter[tuple[int, int]]:
    """Number of points of each pair of bodies that carry force; a near miss that an engine lists carries none."""
    loaded = np.linalg.norm(contacts.force_W, axis=1) > 0
    pairs = zip(contacts.body_A[loaded].tolist(), contacts.body_B[loaded].tolist(), strict=True)
    return Counter(pairs)


@metric("1/step", verdict="a point begins or ceases to carry force")
def contact_flips(run: Run) -> float:
    """points that begin or cease to carry force, per step: sum over pairs of bodies of the change of their number"""
    if run.actual.contacts is None:
        raise NotMeasurable("no contacts were recorded")
    if len(run.actual) < 2:
        raise NotMeasurable("fewer than two samples")
    spacing = np.diff(run.actual.time)
    if run.actual.dt > 0 and np.any(np.abs(spacing - run.actual.dt) > 1e-6 * run.actual.dt):
        raise NotMeasurable(f"samples {spacing.max():g} s apart, expected one every step of {run.actual.dt:g} s")
    if not all(np.isfinite(c.force_W).all() for c in run.actual.contacts):
        return math.nan
    counts = [_bearing(c) for c in run.actual.contacts]
    if not any(counts):
        return math.nan
    flips = 0
    for before, after in pairwise(counts):
        flips += sum(abs(after[pair] - before[pair]) for pair in before.keys() | after.keys())
    return flips / (len(counts) - 1)
