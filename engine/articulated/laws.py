"""What acts along the coordinate of a joint over a sub-step: one force that falls with the rate at the end of it.

Springs, dampers, drives, dry friction and limits of coordinate and rate all push less, or back, the faster a joint moves. So
their sum f(v) falls with the rate v at the end of the sub-step h, straight between breaks, where it bends (a drive at its
limit) or jumps (friction at 0, a stop at the rate that reaches it):

    spring    -k (x + h v - rest) - c v             drive     k (target - x - h v) + c (target' - v), within its limit
    friction  -loss sign(v)                         stops     (lower - x) / h <= v <= (upper - x) / h,  |v| <= speed limit

A joint is on a piece, f = push - slope v, which adds h slope to its inertia, or at a jump, which fixes v. Coordinates that are
tied have one law, of the rate v of the one that leads: the sum of ratio f(ratio v) over all, which falls with v as well.

Source: as `engine.constrain.coordinate`, whose rows say the same; Rockafellar, Convex Analysis, 1970, section 24 (monotone
graphs).
"""

import math
from typing import Final

from plumbline.engine.articulated import tables as tree
from plumbline.engine.articulated.tables import Tables
from plumbline.engine.compile.jit import kernel
from plumbline.engine.maths.rows import Floats
from plumbline.engine.memory import arena as at
from plumbline.engine.memory.tables import Joints

# Which laws act.
PRESSED: Final = -1
"""All, and links are pressed by contacts."""
ALL: Final = 0
SMOOTH: Final = 2
"""Springs and drives."""
STIFF_ALONE: Final = 1
"""Limits, and springs and drives that are marked as too stiff for explicit stages."""

NEAR = 1e-9
"""A rate this near [m/s or rad/s] to a jump is tried there first."""

ROUND_OFF = 1e-12
"""What may be left of a rate or a force, as a share of what it is made of."""


@kernel
def put_break(law: Floats, k: int, break_rate: float, jumps: float) -> None:
    """Add a break between the ends of the law of column k, in its order."""
    n = int(law[k, tree.BREAKS])
    place = 0
    while place < n and law[k, tree.BREAK + place] < break_rate:
        place += 1
    if place < n and law[k, tree.BREAK + place] == break_rate:
        law[k, tree.JUMPS + place] = max(law[k, tree.JUMPS + place], jumps)
        return
    for m in range(n, place, -1):
        law[k, tree.BREAK + m], law[k, tree.JUMPS + m] = law[k, tree.BREAK + m - 1], law[k, tree.JUMPS + m - 1]
    law[k, tree.BREAK + place], law[k, tree.JUMPS + place] = break_rate, jumps
    law[k, tree.BREAKS] = n + 1


@kernel
def narrow(law: Floats, k: int, low: float, high: float, ratio: float) -> None:
    """Let the law of column k end where `ratio` times its rate is between low and high."""
    law[k, tree.LOWEST] = max(law[k, tree.LOWEST], min(low / ratio, high / ratio))
    law[k, tree.HIGHEST] = min(law[k, tree.HIGHEST], max(low / ratio, high / ratio))


@kernel
def write_ends(tables: Tables, i: int, joints: Joints, h: float) -> None:
    """Write the rates between which the law of the column of link i is, with those of all that it leads."""
    law, kind, joint, k = tables.law, tables.kind, joints.joint, tables.kind[i, tree.FIRST]
    law[k, tree.LOWEST], law[k, tree.HIGHEST] = -math.inf, math.inf
    m = i
    while m >= 0:
        c, j, ratio = kind[m, tree.FIRST], kind[m, tree.JOINT], tables.link[m, tree.RATIO]
        if int(law[c, tree.WHICH]) & at.HAS_LIMITS:
            x = law[c, tree.X]
            narrow(law, k, (joint[j, at.LOWER] - x) / h, (joint[j, at.UPPER] - x) / h, ratio)
        m = kind[m, tree.NEXT]
    if law[k, tree.LOWEST] > law[k, tree.HIGHEST]:
        # Of coordinates that are tied, and that limits lock: by rounding.
        law[k, tree.LOWEST] = law[k, tree.HIGHEST] = 0.5 * (law[k, tree.LOWEST] + law[k, tree.HIGHEST])
    m = i
    while m >= 0:
        c, j, ratio = kind[m, tree.FIRST], kind[m, tree.JOINT], tables.link[m, tree.RATIO]
        if int(law[c, tree.WHICH]) & at.HAS_SPEED_LIMIT:
            fastest = abs(joint[j, at.SPEED_LIMIT] / ratio)
            low, high = law[k, tree.LOWEST], law[k, tree.HIGHEST]
            law[k, tree.LOWEST] = min(max(low, -fastest), fastest)
            law[k, tree.HIGHEST] = max(min(high, fastest), -fastest)
        m = kind[m, tree.NEXT]


@kernel
def write_breaks(tables: Tables, i: int, joints: Joints, h: float) -> None:
    """Write the ends and breaks of the law of the column of link i, with those of all that it leads."""
    law, kind, joint, k = tables.law, tables.kind, joints.joint, tables.kind[i, tree.FIRST]
    write_ends(tables, i, joints, h)
    low, high = law[k, tree.LOWEST], law[k, tree.HIGHEST]
    law[k, tree.BREAKS] = 0.0
    if low > -math.inf:
        put_break(law, k, low, 1.0)
    if high < math.inf:
        put_break(law, k, high, 1.0)
    m = i
    while m >= 0:
        c, j, ratio = kind[m, tree.FIRST], kind[m, tree.JOINT], tables.link[m, tree.RATIO]
        has = int(law[c, tree.WHICH])
        if has & at.HAS_FRICTION and low < 0.0 < high:
            put_break(law, k, 0.0, 1.0)
        put_drive_breaks(law, k, c, joint, j, ratio, h)
        m = kind[m, tree.NEXT]


@kernel
def put_drive_breaks(law: Floats, k: int, c: int, joint: Floats, j: int, ratio: float, h: float) -> None:
    """Add to the law of column k where the drive of joint j, on column c of `ratio` times its rate, comes to its limit."""
    if int(law[c, tree.WHICH]) & at.HAS_DRIVE and joint[j, at.DRIVE + 4] < math.inf:
        push, slope = drive_line(joint, j, law[c, tree.X], h)
        if slope > 0.0:
            for side in (-1.0, 1.0):
                break_rate = (push + side * joint[j, at.DRIVE + 4]) / slope / ratio
                if law[k, tree.LOWEST] < break_rate < law[k, tree.HIGHEST]:
                    put_break(law, k, break_rate, 0.0)


@kernel
def drive_line(joint: Floats, j: int, x: float, h: float) -> tuple[float, float]:
    """Force at rate 0, and by how much it falls with the rate, of a drive within its limit."""
    stiffness, damping = joint[j, at.DRIVE], joint[j, at.DRIVE + 1]
    return stiffness * (joint[j, at.DRIVE + 2] - x) + damping * joint[j, at.DRIVE + 3], damping + h * stiffness


@kernel
def piece(law: Floats, k: int, joint: Floats, j: int, h: float, rate: float) -> tuple[float, float]:
    """Push and slope of the piece that a rate of column k, between breaks, lies on; of what acts along it alone."""
    has, x = int(law[k, tree.WHICH]), law[k, tree.X]
    push, slope = 0.0, 0.0
    if has & at.HAS_SPRING:
        push -= joint[j, at.SPRING] * (x - joint[j, at.SPRING + 2])
        slope += joint[j, at.SPRING + 1] + h * joint[j, at.SPRING]
    if has & at.HAS_DRIVE:
        line, fall = drive_line(joint, j, x, h)
        if fall > 0.0:
            force, limit = line - fall * rate, joint[j, at.DRIVE + 4]
            if abs(force) <= limit:
                push += line
                slope += fall
            else:
                push += math.copysign(limit, force)
    if has & at.HAS_FRICTION:
        push -= math.copysign(joint[j, at.FRICTION_LOSS], rate)
    return push, slope


@kernel
def middle(law: Floats, k: int, i: int, rate: float) -> float:
    """A rate on the piece below break i, or above the last one; the rate itself where there are no breaks."""
    n = int(law[k, tree.BREAKS])
    if n == 0:
        return rate
    if i == 0:
        return float(law[k, tree.BREAK] - 1.0)
    if i == n:
        return float(law[k, tree.BREAK + n - 1] + 1.0)
    return float(0.5 * (law[k, tree.BREAK + i - 1] + law[k, tree.BREAK + i]))


@kernel
def first_segment(law: Floats, k: int, rate: float) -> int:
    """Where the rate at the start of a sub-step lies."""
    n = int(law[k, tree.BREAKS])
    for i in range(n):
        break_rate = law[k, tree.BREAK + i]
        if law[k, tree.JUMPS + i] == 1.0 and (
            abs(rate - break_rate) <= NEAR or (rate <= break_rate and break_rate == law[k, tree.LOWEST])
        ):
            return 2 * i + 1
        if rate <= break_rate:
            return 2 * i
    return 2 * n - 1 if n > 0 and law[k, tree.BREAK + n - 1] == law[k, tree.HIGHEST] else 2 * n


@kernel
def take_segment(tables: Tables, i: int, joints: Joints, h: float) -> None:
    """Write what the segment of the column of link i adds to the inertia and pushes by, or the change that a jump prescribes;
    of all columns that it leads too."""
    law, column, kind, joint, k = tables.law, tables.column, tables.kind, joints.joint, tables.kind[i, tree.FIRST]
    segment = int(law[k, tree.SEGMENT])
    rate = law[k, tree.BREAK + segment // 2] if segment % 2 == 1 else middle(law, k, segment // 2, column[k, tree.RATE])
    m = i
    while m >= 0:
        c, j, own = kind[m, tree.FIRST], kind[m, tree.JOINT], tables.link[m, tree.RATIO] * rate
        law[c, tree.SEGMENT] = segment
        if segment % 2 == 1:
            law[c, tree.HELD], column[c, tree.ADDED] = own, math.inf
            column[c, tree.CHANGE] = (own - column[c, tree.RATE]) / h
        else:
            push, slope = piece(law, c, joint, j, h, own)
            column[c, tree.ADDED] = joint[j, at.ARMATURE] + h * slope
            column[c, tree.PUSH] = push - slope * column[c, tree.RATE] + column[c, tree.BESIDE]
        m = kind[m, tree.NEXT]


@kernel
def force_beside(tables: Tables, i: int, joints: Joints, h: float, side: int) -> float:
    """The force just below (side 0) or above (1) the jump that the column of link i is at; infinite beyond the ends of its
    law."""
    law, kind, k = tables.law, tables.kind, tables.kind[i, tree.FIRST]
    at_break = int(law[k, tree.SEGMENT]) // 2
    break_rate = law[k, tree.BREAK + at_break]
    if side == 0 and break_rate == law[k, tree.LOWEST]:
        return math.inf
    if side == 1 and break_rate == law[k, tree.HIGHEST]:
        return -math.inf
    rate, total, m = middle(law, k, at_break + side, break_rate), 0.0, i
    while m >= 0:
        c, ratio = kind[m, tree.FIRST], tables.link[m, tree.RATIO]
        push, slope = piece(law, c, joints.joint, kind[m, tree.JOINT], h, ratio * rate)
        total += ratio * (push - slope * (ratio * break_rate))
        m = kind[m, tree.NEXT]
    return total


@kernel
def next_segment(tables: Tables, i: int, joints: Joints, h: float, found: float, open_by: float) -> int:
    """The segment that the column of link i goes on to, one at a time; the present one where it is right.

    Args: found: its rate at the end or, where it is at a jump, the force that keeps it there; open_by: how exactly that is
        known, beside round-off.
    """
    law, k, below, above = tables.law, tables.kind[i, tree.FIRST], 0.0, 0.0
    if int(law[k, tree.SEGMENT]) % 2 == 1:
        below, above = force_beside(tables, i, joints, h, 0), force_beside(tables, i, joints, h, 1)
    return segment_after(law, k, found, open_by, below, above)


@kernel
def segment_after(law: Floats, k: int, found: float, open_by: float, below: float, above: float) -> int:
    """As `next_segment`, of a law. Args: below, above: its force just below and above the jump that it is at."""
    segment = int(law[k, tree.SEGMENT])
    at_break = segment // 2
    least = ROUND_OFF * (1.0 + abs(found)) + open_by
    if segment % 2 == 1:
        if found > below + least:
            return segment - 1
        if found < above - least:
            return segment + 1
        return segment
    if at_break > 0 and found < law[k, tree.BREAK + at_break - 1] - least:
        return segment - (1 if law[k, tree.JUMPS + at_break - 1] == 1.0 else 2)
    if at_break < int(law[k, tree.BREAKS]) and found > law[k, tree.BREAK + at_break] + least:
        return segment + (1 if law[k, tree.JUMPS + at_break] == 1.0 else 2)
    return segment


@kernel
def is_ruled(tables: Tables, joints: Joints, i: int) -> bool:
    """Whether link i has a column with a law; one that follows another has none of its own."""
    j = tables.kind[i, tree.JOINT]
    return bool(j >= 0 and joints.kind[j, at.HAS] != 0 and tables.kind[i, tree.LEADER] == i)


@kernel
def write_laws(tables: Tables, joints: Joints, h: float, which: int) -> int:
    """Write the laws of all columns for a sub-step h, each on its first segment. Returns: how many breaks they have."""
    law, kind, breaks = tables.law, tables.kind, 0
    for i in range(kind.shape[0]):
        if not is_ruled(tables, joints, i):
            continue
        k, m = kind[i, tree.FIRST], i
        while m >= 0:
            c, j = kind[m, tree.FIRST], kind[m, tree.JOINT]
            acting = -1 if which <= ALL else joints.kind[j, at.IMPLICIT] | at.HAS_LIMITS
            if which == SMOOTH:
                acting = at.HAS_SPRING | at.HAS_DRIVE
            law[c, tree.WHICH] = joints.kind[j, at.HAS] & acting
            law[c, tree.X] = tables.coordinate[m, 0]
            m = kind[m, tree.NEXT]
        write_breaks(tables, i, joints, h)
        law[k, tree.SEGMENT] = first_segment(law, k, tables.column[k, tree.RATE])
        take_segment(tables, i, joints, h)
        breaks += int(law[k, tree.BREAKS])
    return breaks


@kernel
def take_laws(tables: Tables, joints: Joints, h: float) -> None:
    """Write what the segments of all columns add and push anew, from the present rates on."""
    for i in range(tables.kind.shape[0]):
        if is_ruled(tables, joints, i):
            take_segment(tables, i, joints, h)
