"""What bodies at rest are allowed: a step of gravity, and to give way by what nobody would notice.

Contact forces are known once a step: a body falls freely for as long before its supports push, and gains g dt. What it sinks by
then depends on the class of method. One that finds the force which stops the body at the end of a step lets it sink by g dt^2;
one whose contacts are springs of a fixed time constant T, critically damped, takes the speed g dt within T and sinks by
g dt T/e (MuJoCo, "Computation", solver parameters: 0.3 mm at 1/240 s and its own T = 0.02 s), and by what its stiffness
makes of the weight, at any step. Neither is an error of the other kind: what both are held to is what a user needs.
"""

from plumbline.harness.case import Check
from plumbline.harness.metrics.collapse import collapse_time
from plumbline.harness.metrics.contact_force import support_force_error
from plumbline.harness.metrics.jitter import rms_speed
from plumbline.harness.metrics.penetration import penetration
from plumbline.harness.scene import EARTH_GRAVITY

G = -EARTH_GRAVITY[2]
GIVE = 1e-3
"""What a contact may give way under weight and still be a firm one [m]: a millimetre, the play of a machine that is 0.1 to 1 m
large, and less than anybody sees of it."""


def stands(duration: float, what: str) -> Check:
    """A pile, named in words, stands for the whole run of `duration` [s]."""
    return Check(
        metric=collapse_time,
        at_most=lambda dt, _: duration - dt.outer,
        because=f"{what} for the whole run, which ends within a step between two calls of its nominal length",
    )


def bears(body: str, start: float = 0.0) -> Check:
    """From `start` [s] on no body stands in another, but for a step's fall and a millimetre."""
    return Check(
        metric=penetration,
        at_most=lambda dt, _: G * dt**2 + GIVE,
        because=f"g dt^2, the way that {body} falls in the one step before its contact can push; and a millimetre, which a "
        "contact may give way under weight: a rigid one needs none of it, one of a fixed time constant T = 0.02 s sinks by "
        "g dt T/e",
        start=start,
    )


def settled_speed(start: float, body: str = "a body") -> Check:
    """From `start` [s] on no body is faster than one step of gravity makes it."""
    return Check(
        metric=rms_speed,
        at_most=lambda dt, _: G * dt,
        because=f"g dt, what one step of gravity gives {body} before its supports take it away",
        start=start,
    )


def supported(start: float, duration: float) -> Check:
    """From `start` [s] to the end of the run the ground bears the weight."""
    return Check(
        metric=support_force_error,
        at_most=lambda dt, _: dt / (duration - start),
        because="the mean force over the window misses the weight by the change of momentum, at most m g dt where speeds "
        "stay under one step of gravity",
        start=start,
    )
