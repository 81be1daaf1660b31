"""Contact flips: how often points of contact appear and vanish."""

import math
from collections import Counter
from itertools import pairwise

import numpy as np

from harness.metric import Metric, NotMeasurable
from harness.scene import Scene
from harness.trajectory import Contacts, Trajectory


def _bearing(contacts: Contacts) -> Counter[tuple[int, int]]:
    """Number of points of each pair of bodies that carry force; a near miss that an engine lists carries none."""
    loaded = np.linalg.norm(contacts.force_W, axis=1) > 0
    pairs = zip(contacts.body_A[loaded].tolist(), contacts.body_B[loaded].tolist(), strict=True)
    return Counter(pairs)


def _measure(scene: Scene, actual: Trajectory, expected: Trajectory | None) -> float:
    if actual.contacts is None:
        raise NotMeasurable("no contacts were recorded")
    if len(actual) < 2:
        raise NotMeasurable("fewer than two samples")
    spacing = np.diff(actual.time)
    if actual.dt > 0 and np.any(np.abs(spacing - actual.dt) > 1e-6 * actual.dt):
        raise NotMeasurable(f"samples {spacing.max():g} s apart, expected one every step of {actual.dt:g} s")
    if not actual.finite or not all(np.isfinite(c.force_W).all() for c in actual.contacts):
        return math.nan
    counts = [_bearing(c) for c in actual.contacts]
    if not any(counts):
        return math.nan
    flips = 0
    for before, after in pairwise(counts):
        flips += sum(abs(after[pair] - before[pair]) for pair in before.keys() | after.keys())
    return flips / (len(counts) - 1)


CONTACT_FLIPS = Metric(
    name="contact_flips",
    unit="1/step",
    source="points that begin or cease to carry force, per step: sum over pairs of bodies of the change of their number",
    measure=_measure,
    verdict="a point begins or ceases to carry force",
)

METRIC = CONTACT_FLIPS
