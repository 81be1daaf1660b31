"""The numbers of a soft contact: its spring in a sub-step, from which speed it bounces, when it slips, how it is swept.

Source: Catto, Soft Constraints, GDC 2011.
"""

import math
from typing import Final, NamedTuple

from plumbline.engine.compile.jit import kernel
from plumbline.engine.maths.rows import Floats, load3
from plumbline.engine.maths.vec import norm
from plumbline.engine.memory import arena as at

FRESH = 8
"""Times as many sweeps for a blow and in the first sub-step of a contact, which have no impulses to start from."""
FRESH_JOINTED = 4 * FRESH
"""As `FRESH`, where joints pass the impulses on, and sweeps over contacts and joints in turns settle later. By trial: with 8 a
humanoid at 1/60 s leaves its pose by .0060 rad as it is set down, with 32 by .0017."""
STUCK = 0.999999
"""Share of the static disc from which a contact counts as slipping."""
TOUCHING = 1e-9
"""Share of a sub-step's way [1] by which rounding may put a gap beyond its end."""

# What a sweep aims at.
PRESS: Final = 0  # velocities that also correct the position error
RELAX: Final = 1  # velocities alone
REBOUND: Final = 2  # the velocity after restitution, where a point struck

# What else is done to each contact in turn.
PUSH: Final = 3  # the impulses of the last sub-step
TURN: Final = 4  # arms, gaps and normals at the present poses


class Softness(NamedTuple):
    """How a contact gives way in a sub-step of h [s].

    Terms: bias_rate [1/s]: of a depth, into velocity; mass_scale, impulse_scale [1]: of the answer, and of the impulse that is
    forgotten; max_push [m/s]: the fastest correction.
    """

    h: float
    bias_rate: float
    mass_scale: float
    impulse_scale: float
    max_push: float
    backwards: int


@kernel
def softness_of(setting: Floats, h: float) -> Softness:
    """The spring of the settings over a sub-step of h [s]; at most a quarter turn per sub-step."""
    omega = 2.0 * math.pi * min(setting[0, at.HERTZ], 0.25 / h)
    a1 = 2.0 * setting[0, at.DAMPING_RATIO] + h * omega
    a2 = h * omega * a1
    a3 = 1.0 / (1.0 + a2)
    return Softness(h, omega / a1, a2 * a3, a3, setting[0, at.MAX_PUSH], 0)


@kernel
def slow_approach(setting: Floats, h: float) -> float:
    """The approach speed [m/s] below which nothing bounces: as set, or four times what gravity gives in one sub-step."""
    if setting[0, at.BOUNCE_SPEED] >= 0.0:
        return float(setting[0, at.BOUNCE_SPEED])
    return 4.0 * h * norm(load3(setting, 0, at.GRAVITY)) + 1e-9
