"""Bounds that more than one case is judged by, each derived once.

What bodies at rest are allowed: a step of gravity, and to give way by what nobody would notice. Contact forces are known once
a step: a body falls freely for as long before its supports push, and gains g dt. What it sinks by then depends on the class
of method. One that finds the force which stops the body at the end of a step lets it sink by g dt^2; one whose contacts are
springs of a fixed time constant T, critically damped, takes the speed g dt within T and sinks by g dt T/e (MuJoCo,
"Computation", solver parameters: 0.3 mm at 1/240 s and its own T = 0.02 s), and by what its stiffness makes of the weight, at
any step. Neither is an error of the other kind: what both are held to is what a user needs.

What recorded contact forces are allowed to miss of Newton's and Coulomb's laws, whatever the time step. Forces and motion are
two readings of one solve, so that no order of the step lies between them. What does is the residual of a solver that
iterates: it stops where the cost improves by less than 1e-8 of its scale, the finest default among the engines, and a cost is
quadratic in its residual, so that forces are known to the root of it.

What a law of restitution is allowed to miss by how long an impact lasts: a step, or the length of a spring. A method that has
such a law turns a body round within the step that finds it. One whose contacts are springs with dampers, stiff enough for
their half period to last T, keeps a body for T and is passed into by v T/pi. T is a number of steps: ten, in which Euler's
method still keeps the half period to half a percent, (w dt)^2/24 = (pi/10)^2/24. Such a contact gives back what gravity does
to it meanwhile, but for the damper's share: over all damping ratios the square of the rebound falls by at most g T/(3 v) of
the square of the speed of approach v, and the body leaves the place of contact by at most T later than it came, the slower
flight that follows taken together with it (x'' = max(0, -2 z w x' - w^2 x) - g, integrated).
"""

from plumbline.harness.case.case import Check
from plumbline.harness.metrics.collapse import collapse_time
from plumbline.harness.metrics.contacts import (
    cone_residual,
    dissipation_residual,
    momentum_residual,
    penetration,
    signorini_residual,
    support_force_error,
)
from plumbline.harness.metrics.jitter import rms_speed
from plumbline.harness.metrics.settled import settled_share_high
from plumbline.harness.scene import EARTH_GRAVITY

G = -EARTH_GRAVITY[2]
SINGLE = 2.0**-24
"""Relative rounding of a float32: an engine in single precision is judged as such."""
GIVE = 1e-3
"""What a contact may give way under weight and still be a firm one [m]: a millimetre, the play of a machine that is 0.1 to 1 m
large, and less than anybody sees of it."""
SOLVED = 1e-4
"""Share by which forces may miss a law that is solved for: the root of 1e-8."""
_ROOT = "1e-4: a solver that stops at an improvement of 1e-8 of a cost that is quadratic in its residual"
SPRING_STEPS = 10
"""How long an impact lasts that is a spring's half period [steps]."""


def stands(duration: float, what: str) -> Check:
    """A pile, named in words, stands for the whole run of `duration` [s]."""
    return Check(
        collapse_time,
        lambda dt, _: duration - dt.outer,
        f"{what} for the whole run, which ends within a step between two calls of its nominal length",
    )


def bears(body: str, start: float = 0.0) -> Check:
    """From `start` [s] on no body stands in another, but for a step's fall and a millimetre."""
    return Check(
        penetration,
        lambda dt, _: G * dt**2 + GIVE,
        f"g dt^2, the way that {body} falls in the one step before its contact can push; and a millimetre, which a "
        "contact may give way under weight: a rigid one needs none of it, one of a fixed time constant T = 0.02 s sinks by "
        "g dt T/e",
        start=start,
    )


def settled_speed(start: float, body: str = "a body") -> Check:
    """From `start` [s] on no body is faster than one step of gravity makes it."""
    return Check(
        rms_speed,
        lambda dt, _: G * dt,
        f"g dt, what one step of gravity gives {body} before its supports take it away",
        start=start,
    )


def settles_from_most_starts(start: float, what: str) -> Check:
    """From `start` [s] on nothing is faster than a step of gravity makes it, from more starts than not, where bits decide."""
    return Check(
        settled_share_high,
        0.5,
        f"{what} more often than not: of eight starts that differ by 1e-9 m the interval of the share must reach a half, which "
        "2 of 8 do (.59) and 1 of 8 does not (.47); whether one of them does hangs on roundings",
        start=start,
    )


def supported(start: float, duration: float) -> Check:
    """From `start` [s] to the end of the run the ground bears the weight."""
    return Check(
        support_force_error,
        lambda dt, _: dt / (duration - start),
        "the mean force over the window misses the weight by the change of momentum, at most m g dt where speeds "
        "stay under one step of gravity",
        start=start,
    )


def forces_keep_momentum() -> Check:
    """In each step contact forces and gravity give bodies the momentum that they gain."""
    return Check(momentum_residual, SOLVED, f"a force is what changes momentum, {_ROOT}; where samples are a step apart")


def forces_obey_coulomb(end: float | None = None) -> tuple[Check, ...]:
    """Contacts push across no gap, stay in their cone, and rub mu N against their slip, until `end` [s]."""
    return (
        Check(signorini_residual, SOLVED, f"contacts neither pull nor act across a gap; {_ROOT}", end=end),
        Check(cone_residual, SOLVED, f"no friction is beyond mu N; {_ROOT}", end=end),
        Check(
            dissipation_residual,
            SOLVED,
            f"what slips, and goes on for the whole step, is rubbed by mu N against its way; {_ROOT}",
            end=end,
        ),
    )
