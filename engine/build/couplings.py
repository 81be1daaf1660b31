"""Which coordinate each coupled joint follows in the end, and by what ratio, through all couplings between."""

import math
from collections.abc import Sequence

from plumbline.engine.describe.joints import Joint, Prismatic, Revolute

TIED = 1e-9
"""What positions of coupled joints may differ by at the start [rad or m, relative above 1]: rounding of a file's digits."""

MOST_DRIVES = 2
"""Drives with a limit that the one law of coordinates which follow each other has room for."""


def leaders_of(joints: Sequence[Joint]) -> dict[str, tuple[str, float]]:
    """By the name of each coupled joint that of the one it follows, which follows none, and the ratio of their coordinates.

    Raises: ValueError for a coupling to no joint with one coordinate, one that leads back, positions that it forbids, or more
    drives with a limit along coordinates that follow each other than there is room for.
    """
    scalar = {joint.name: joint for joint in joints if isinstance(joint, Revolute | Prismatic)}
    found: dict[str, tuple[str, float]] = {}
    for joint in scalar.values():
        if joint.coupling is None:
            continue
        label, ratio, at, passed = f"joint '{joint.name}': coupling to '{joint.coupling.joint}'", 1.0, joint, {joint.name}
        while at.coupling is not None:
            name = at.coupling.joint
            if name not in scalar or name in passed:
                raise ValueError(f"{label}: '{name}' {'follows itself' if name in passed else 'has no coordinate'}")
            tied = at.coupling.ratio * scalar[name].position + at.coupling.offset
            if abs(at.position - tied) > TIED * max(1.0, abs(at.position), abs(at.coupling.offset)):
                raise ValueError(f"{label}: position {at.position}, expected {tied}")
            ratio, at = ratio * at.coupling.ratio, scalar[name]
            passed.add(name)
        found[joint.name] = (at.name, ratio)
    for leader in {name for name, _ in found.values()}:
        group = [leader, *(name for name, (other, _) in found.items() if other == leader)]
        limited = [name for name in group if (drive := scalar[name].drive) is not None and drive.limit < math.inf]
        if len(limited) > MOST_DRIVES:
            raise ValueError(
                f"joint '{limited[-1]}': drive limit {scalar[limited[-1]].drive}, expected at most {MOST_DRIVES} drives with "
                "a limit along coordinates that follow each other"
            )
    return found
