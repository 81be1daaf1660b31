"""Blows from the side or from above on bodies that nothing holds: when, and from what.

A blow may be shorter than the time between two samples, so that no contact of it is recorded: it is read off the jump that it
leaves in the velocity. What comes from below is a landing or a bounce and is left to those who look for them.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from plumbline.harness.scene import Scene
from plumbline.harness.trajectory.depths import pair_depths
from plumbline.harness.trajectory.trajectory import Floats, Integers, Trajectory

BLOW = 2.0
"""Times what weight changes a velocity by between two samples."""
VISIBLE = 0.01
"""Of its size: a blow that moves a body by less until the next sample is seen by nobody."""
LASTS = 3
"""Samples before and after, at which the force of a blow is not there any more: friction and drives go on pushing."""
STANDS_OUT = 4.0
"""Times the push at those samples."""


@dataclass(frozen=True, slots=True)
class Blow:
    """Terms: body: its place. sample: the first after the blow. other: the place of what it hit, None where nothing tells."""

    body: int
    sample: int
    other: int | None


def blows(
    scene: Scene, run: Trajectory, sizes: Mapping[int, float], partners: Mapping[int, tuple[Integers, Integers]]
) -> list[Blow]:
    """All blows in a run; two bodies that hit each other have one, that of the first.

    Args: sizes [m]: of the bodies that are looked at, by place. partners: of them, the samples at which they touch others and
    the places of those.
    """
    pushes = {body: _push(run.time, run.v_WB[:, body], np.array(scene.gravity)) for body in sizes}
    struck = {body: _struck(run.time, *pushes[body], scene, size) for body, size in sizes.items()}
    hits: list[Blow] = []
    for body, samples in struck.items():
        for sample in samples:
            before, about = _touched(sample, *partners[body]) if body in partners else (set(), [])
            other = _thrown_back(scene, body, sample, struck, pushes)
            if other is None:
                other = next((each for each in about if each not in before), None)
            if other is None:
                other = _nearest_fixed(scene, run, body, sample, before)
            counted = any(each.body == other and each.other == body and abs(each.sample - sample) < LASTS for each in hits)
            # What already lies on something and meets nothing else is stopped by friction.
            if not counted and not (other is None and before):
                hits.append(Blow(body, sample, other))
    return hits


def _push(time: Floats, v_WB: Floats, gravity: Floats) -> tuple[Floats, Floats]:
    """What changes a velocity between two samples beyond weight, (t - 1, 3) m/s: all, and without what comes from below."""
    push = np.diff(v_WB, axis=0) - gravity * np.diff(time)[:, None]
    strength = float(np.linalg.norm(gravity))
    if not strength:
        return push, push
    up = -gravity / strength
    return push, push - np.maximum(push @ up, 0.0)[:, None] * up


def _struck(time: Floats, push: Floats, across: Floats, scene: Scene, size: float) -> list[int]:
    """The samples after a blow that is not from below."""
    if len(push) == 0:
        return []
    strength, dt = np.linalg.norm(across, axis=1), np.diff(time)
    from_below = np.linalg.norm(push, axis=1) > np.sqrt(2.0) * strength
    least = np.maximum(BLOW * float(np.linalg.norm(scene.gravity)) * dt, VISIBLE * size / dt)
    beside = np.pad(strength, LASTS)
    quiet = np.maximum(beside[: len(strength)], beside[2 * LASTS :])
    hit = (strength > least) & (strength > STANDS_OUT * quiet) & ~from_below
    # Of a blow that is spread over several samples the strongest.
    near = np.array([strength[max(0, k - LASTS + 1) : k + LASTS].max() for k in range(len(strength))])
    return (np.flatnonzero(hit & (strength >= near)) + 1).tolist()


def _touched(sample: int, samples: Integers, others: Integers) -> tuple[set[int], list[int]]:
    """The places of what a body touches before a blow, be it now and again, and about it."""
    before = (samples < sample - LASTS) & (samples >= sample - 4 * LASTS)
    return set(others[before].tolist()), others[np.abs(samples - sample) < LASTS].tolist()


def _thrown_back(
    scene: Scene, body: int, sample: int, struck: Mapping[int, Sequence[int]], pushes: Mapping[int, tuple[Floats, Floats]]
) -> int | None:
    """The body that is pushed the other way at the same time, the one whose impulse comes nearest."""
    own = scene.bodies[body].mass * pushes[body][0][sample - 1]
    shares = {
        other: -float(scene.bodies[other].mass * pushes[other][0][sample - 1] @ own) / float(own @ own)
        for other, samples in struck.items()
        if other != body and any(abs(each - sample) < LASTS for each in samples)
    }
    best = max(shares, key=lambda other: shares[other], default=None)
    return best if best is not None and shares[best] > 0 else None


def _nearest_fixed(scene: Scene, run: Trajectory, body: int, sample: int, before: set[int]) -> int | None:
    """What is fixed or led and nearest by poses, no further than the body comes between two samples, and not touched before."""
    moment = run.between(float(run.time[sample - 1]), float(run.time[sample]))
    reach = float(np.linalg.norm(moment.v_WB[:, body], axis=1).max() * (moment.time[-1] - moment.time[0]))
    nearest: dict[int, float] = {}
    for a, b, deep in pair_depths(scene, moment):
        other = b if a == body else a
        if body not in (a, b) or deep is None or other in before or scene.bodies[other].movable:
            continue
        if deep.max() > -reach:
            nearest[other] = max(nearest.get(other, -np.inf), float(deep.max()))
    return max(nearest, key=lambda other: nearest[other], default=None)
