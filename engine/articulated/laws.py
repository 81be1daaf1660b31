"""What acts along the coordinate of a joint over a sub-step: one force that falls with the rate at the end of it.

Springs, dampers, drives, dry friction and limits of coordinate and rate all push less, or back, the faster a joint moves. So
their sum f(v) falls with the rate v at the end of the sub-step h, straight between breaks, where it bends (a drive at its
limit) or jumps (friction at 0, a stop at the rate that reaches it):

    spring    -k (x + h v - rest) - c v             drive     k (target - x - h v) + c (target' - v), within its limit
    friction  -loss sign(v)                         stops     (lower - x) / h <= v <= (upper - x) / h,  |v| <= speed limit

A joint is on a piece, f = push - slope v, which adds h slope to its inertia, or at a jump, which fixes v. Coordinates that are
tied have one law, of the rate v of the one that leads: the sum of ratio f(ratio v) over all, which falls with v as well. A
tendon has a law like that of a joint, along its length.

Source: as `engine.constrain.coordinate`, whose rows say the same; Rockafellar, Convex Analysis, 1970, section 24 (monotone
graphs).
"""

import math

from plumbline.engine.articulated import tables as tree
from plumbline.engine.compile.jit import kernel
from plumbline.engine.maths.rows import Floats
from plumbline.engine.memory import arena as at

NEAR = 1e-9
"""A rate this near [m/s or rad/s] to a jump is tried there first."""

ROUND_OFF = 1e-12
"""What may be left of a rate or a force, as a share of what it is made of."""


@kernel
def put_break(law: Floats, k: int, break_rate: float, jumps: float) -> None:
    """Add a break between the ends of the law of law k, in its order."""
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
    """Let the law of law k end where `ratio` times its rate is between low and high."""
    law[k, tree.LOWEST] = max(law[k, tree.LOWEST], min(low / ratio, high / ratio))
    law[k, tree.HIGHEST] = min(law[k, tree.HIGHEST], max(low / ratio, high / ratio))


@kernel
def write_ends(law: Floats, k: int, h: float) -> None:
    """Write the rates between which law k is, with all its parts."""
    law[k, tree.LOWEST], law[k, tree.HIGHEST] = -math.inf, math.inf
    c = k
    while c >= 0:
        if int(law[c, tree.WHICH]) & at.HAS_LIMITS:
            x = law[c, tree.X]
            low, high = (law[c, tree.RULE + at.LOWER] - x) / h, (law[c, tree.RULE + at.UPPER] - x) / h
            narrow(law, k, low, high, law[c, tree.SHARED])
        c = int(law[c, tree.NEXT_PART])
    if law[k, tree.LOWEST] > law[k, tree.HIGHEST]:
        # Of coordinates that are tied, and that limits lock: by rounding.
        law[k, tree.LOWEST] = law[k, tree.HIGHEST] = 0.5 * (law[k, tree.LOWEST] + law[k, tree.HIGHEST])
    c = k
    while c >= 0:
        if int(law[c, tree.WHICH]) & at.HAS_SPEED_LIMIT:
            fastest = abs(law[c, tree.RULE + at.SPEED_LIMIT] / law[c, tree.SHARED])
            low, high = law[k, tree.LOWEST], law[k, tree.HIGHEST]
            law[k, tree.LOWEST] = min(max(low, -fastest), fastest)
            law[k, tree.HIGHEST] = max(min(high, fastest), -fastest)
        c = int(law[c, tree.NEXT_PART])


@kernel
def write_breaks(law: Floats, k: int, h: float) -> None:
    """Write the ends and breaks of law k, with all its parts."""
    write_ends(law, k, h)
    low, high = law[k, tree.LOWEST], law[k, tree.HIGHEST]
    law[k, tree.BREAKS] = 0.0
    for end in (low, high):
        if math.isfinite(end):
            put_break(law, k, end, 1.0)
    c = k
    while c >= 0:
        if int(law[c, tree.WHICH]) & at.HAS_FRICTION and low < 0.0 < high:
            put_break(law, k, 0.0, 1.0)
        limit = law[c, tree.RULE + at.DRIVE + 4]
        if int(law[c, tree.WHICH]) & at.HAS_DRIVE and limit < math.inf:
            push, slope = drive_line(law, c, h)
            for side in (-1.0, 1.0):
                break_rate = (push + side * limit) / slope / law[c, tree.SHARED] if slope > 0.0 else math.inf
                if low < break_rate < high:
                    put_break(law, k, break_rate, 0.0)
        c = int(law[c, tree.NEXT_PART])


@kernel
def drive_line(law: Floats, c: int, h: float) -> tuple[float, float]:
    """Force at rate 0, and by how much it falls with the rate, of the drive of part c within its limit."""
    drive = tree.RULE + at.DRIVE
    stiffness, damping = law[c, drive], law[c, drive + 1]
    push = stiffness * (law[c, drive + 2] - law[c, tree.X]) + damping * law[c, drive + 3]
    return push, damping + h * stiffness


@kernel
def piece(law: Floats, c: int, h: float, rate: float) -> tuple[float, float]:
    """Push and slope of the piece that a rate of part c, between breaks, lies on; of what acts along it alone."""
    has, spring = int(law[c, tree.WHICH]), tree.RULE + at.SPRING
    push, slope = 0.0, 0.0
    if has & at.HAS_SPRING:
        push -= law[c, spring] * (law[c, tree.X] - law[c, spring + 2])
        slope += law[c, spring + 1] + h * law[c, spring]
    if has & at.HAS_DRIVE:
        line, fall = drive_line(law, c, h)
        if fall > 0.0:
            force, limit = line - fall * rate, law[c, tree.RULE + at.DRIVE + 4]
            if abs(force) <= limit:
                push += line
                slope += fall
            else:
                push += math.copysign(limit, force)
    if has & at.HAS_FRICTION:
        push -= math.copysign(law[c, tree.RULE + at.FRICTION_LOSS], rate)
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
def force_beside(law: Floats, k: int, h: float, side: int) -> float:
    """The force just below (side 0) or above (1) the jump that law k is at; infinite beyond its ends."""
    at_break = int(law[k, tree.SEGMENT]) // 2
    break_rate = law[k, tree.BREAK + at_break]
    if side == 0 and break_rate == law[k, tree.LOWEST]:
        return math.inf
    if side == 1 and break_rate == law[k, tree.HIGHEST]:
        return -math.inf
    rate, total, c = middle(law, k, at_break + side, break_rate), 0.0, k
    while c >= 0:
        ratio = law[c, tree.SHARED]
        push, slope = piece(law, c, h, ratio * rate)
        total += ratio * (push - slope * (ratio * break_rate))
        c = int(law[c, tree.NEXT_PART])
    return total


@kernel
def next_segment(law: Floats, k: int, h: float, found: float, open_by: float) -> int:
    """The segment that law k goes on to, one at a time; the present one where it is right.

    Args: found: its rate at the end or, where it is at a jump, the force that keeps it there; open_by: how exactly that is
        known, beside round-off.
    """
    segment = int(law[k, tree.SEGMENT])
    at_break = segment // 2
    least = ROUND_OFF * (1.0 + abs(found)) + open_by
    if segment % 2 == 1:
        if found > force_beside(law, k, h, 0) + least:
            return segment - 1
        return segment + 1 if found < force_beside(law, k, h, 1) - least else segment
    if at_break > 0 and found < law[k, tree.BREAK + at_break - 1] - least:
        return segment - (1 if law[k, tree.JUMPS + at_break - 1] == 1.0 else 2)
    if at_break < int(law[k, tree.BREAKS]) and found > law[k, tree.BREAK + at_break] + least:
        return segment + (1 if law[k, tree.JUMPS + at_break] == 1.0 else 2)
    return segment
