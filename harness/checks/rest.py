"""What bodies at rest are allowed by a step of gravity.

Contact forces are known once a step: a body falls freely for as long before its supports push, and gains g dt.
"""

from harness.case import Check
from harness.metrics.collapse import COLLAPSE_TIME
from harness.metrics.contact_force import SUPPORT_FORCE_ERROR
from harness.metrics.jitter import RMS_SPEED
from harness.scene import EARTH_GRAVITY

__all__ = ["settled_speed", "stands", "supported"]

G = -EARTH_GRAVITY[2]


def stands(duration: float, what: str) -> Check:
    """A pile, named in words, stands for the whole run of `duration` [s]."""
    return Check(
        metric=COLLAPSE_TIME,
        at_most=lambda dt: duration - dt,
        because=f"{what} for the whole run, which ends within a step of its nominal length",
    )


def settled_speed(start: float, body: str = "a body") -> Check:
    """From `start` [s] on no body is faster than one step of gravity makes it."""
    return Check(
        metric=RMS_SPEED,
        at_most=lambda dt: G * dt,
        because=f"g dt, what one step of gravity gives {body} before its supports take it away",
        start=start,
    )


def supported(start: float, duration: float) -> Check:
    """From `start` [s] to the end of the run the ground bears the weight."""
    return Check(
        metric=SUPPORT_FORCE_ERROR,
        at_most=lambda dt: dt / (duration - start),
        because="the mean force over the window misses the weight by the change of momentum, at most m g dt where speeds "
        "stay under one step of gravity",
        start=start,
    )
