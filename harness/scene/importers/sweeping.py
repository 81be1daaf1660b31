"""The scenario that drives each joint through its range and back, all at once, by sinusoids that start where it stands."""

import math
from collections.abc import Sequence
from dataclasses import replace

from plumbline.harness.scene.importers.consequences import Massive
from plumbline.harness.scene.importers.fidelity import Fidelity
from plumbline.harness.scene.importers.robot import Coordinate, Robot
from plumbline.harness.scene.importers.scenarios import held_by_drives
from plumbline.harness.scene.motion import Sinusoid

FREQUENCY = 0.5
"""Of the sinusoid [Hz]: through the range and back in two seconds, where that is not too fast."""
FASTEST = 2.0
"""Greatest speed of a target [rad/s], a slide's a tenth of that [m/s]: what arms do whose makers say so."""
INSTANTS = 4
"""Poses on the way for which drives are made strong enough, beside the start."""
SHARE = 0.8
"""Of half the range: the stops are not what is asked about, and a drive overshoots."""
OPEN = 1.0
"""Half the range of a joint that has no end on a side [rad]; a slide's is a tenth of that [m]."""


def poses_of(robot: Robot) -> list[Robot]:
    """The robot at the start and at instants of its sweep; at the start alone where loops are closed."""
    made = [robot]
    for k in range(0 if robot.closures else INSTANTS):
        share = math.sin(math.pi * (k + 0.5) / INSTANTS) * (-1.0) ** k

        def there(c: Coordinate, share: float = share) -> Coordinate:
            middle, reach = _reach(c)
            return replace(c, position=middle + share * reach) if c.kind in ("revolute", "prismatic") else c

        made.append(robot.each(there))
    return made


def swept(robot: Robot, poses: Sequence[Sequence[Massive]]) -> Robot:
    """The robot with a drive on each joint, whose target goes through the range, and what is to be said of that.

    Where the companion moves a target that motion stays. In a machine with closed loops joints do not move freely of each
    other: there those with a drive of their own are swept or, where none has one, the first.
    """
    moving = [c for c in robot.coordinates() if c.kind in ("revolute", "prismatic")]
    if robot.closures:
        moving = [c for c in moving if c.servo is not None] or moving[:1]
    names = {c.name for c in moving}
    driven = held_by_drives(robot, poses, names if robot.closures else None)
    frequencies = {c.name: _frequency(c, _reach(c)[1]) for c in moving}
    slow = Fidelity.exact(
        "sweep",
        [name for name, frequency in frequencies.items() if frequency < FREQUENCY],
        "a slower sinusoid",
        consequence=f"no faster than the joint may be, nor than {FASTEST:g} rad/s or {FASTEST / 10:g} m/s; the slowest "
        "goes there and back at",
        value=min(frequencies.values(), default=FREQUENCY),
        unit="Hz",
    )
    return driven.each(lambda c: _swept(c) if c.name in names else c).told(slow)


def _swept(c: Coordinate) -> Coordinate:
    if c.servo is None or c.servo.motion is not None:
        return c
    middle, reach = _reach(c)
    here = c.reference if c.position is None else c.position
    phase = math.asin(min(max((here - middle) / reach, -1.0), 1.0)) if reach > 0 else 0.0
    motion = Sinusoid(amplitude=reach, frequency=_frequency(c, reach), phase=phase)
    return replace(c, servo=replace(c.servo, target=middle, motion=motion))


def _reach(c: Coordinate) -> tuple[float, float]:
    """The middle of the way that a joint is driven, and how far to each side [rad or m]."""
    here = c.reference if c.position is None else c.position
    wide = OPEN if c.kind == "revolute" else OPEN / 10
    lower = here - wide if c.lower is None else c.lower
    upper = here + wide if c.upper is None else c.upper
    return (lower + upper) / 2, max(SHARE * (upper - lower) / 2, 0.0)


def _frequency(c: Coordinate, reach: float) -> float:
    """Such that the target is never faster than the joint may be, nor than arms are."""
    if reach <= 0:
        return FREQUENCY
    fastest = FASTEST if c.kind == "revolute" else FASTEST / 10
    return min(FREQUENCY, min(fastest, c.speed or math.inf) / (2 * math.pi * reach))
