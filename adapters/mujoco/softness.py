"""How soft a constraint is: time constants, and impedance."""

import math
from typing import Any

from plumbline.adapters.mujoco.options import Options

VENDOR_TIME_CONSTANT = 0.02
"""The time constant of MuJoCo's constraints [s] (solref[0])."""
LEAST_STEPS = 2.0
"""Time constants below this number of steps are raised to it by the engine, unless its integrator is the discrete one.

Source: MuJoCo, "Modeling", solver parameters; XML reference, option/flag/refsafe (the discrete integrator replaces what no step
resolves, time constant times damping ratio below a step, by the stiffest row that does not rebound).
"""


def impedance(d: float) -> tuple[float, ...]:
    """solimp of the constant impedance d: the share of the reference in the acceleration of a constraint."""
    return (d, d, 0.001, 0.5, 2.0)


def time_constant(steps: float | None, h: float, slowest: float | None) -> float:
    """The time constant [s] that is asked for: told in steps of h [s] and bounded by `slowest` [s], or the vendor's."""
    return VENDOR_TIME_CONSTANT if steps is None else min(steps * h, math.inf if slowest is None else slowest)


def friction_constant(options: Options, h: float) -> float | None:
    """The time constant [s] of friction that is told of its own; None where it has none: a pyramid has no rows for it."""
    if options.friction_steps is None or options.cone != "elliptic":
        return None
    return time_constant(options.friction_steps, h, options.slowest)


def hold(constraint: Any, options: Options, h: float) -> None:
    """Tell a loop or a rod how stiffly it is held, in steps of h [s]."""
    constraint.solref = [time_constant(options.loop_steps, h, options.slowest), 1.0]
    if options.loop_impedance is not None:
        constraint.solimp = impedance(options.loop_impedance)


def hold_dry(rubbed: Any, options: Options, h: float) -> None:
    """Tell a coordinate how stiffly its dry friction holds it, as a loop is held, in steps of h [s]."""
    rubbed.solref_friction = [time_constant(options.loop_steps, h, options.slowest), 1.0]
    if options.loop_impedance is not None:
        rubbed.solimp_friction = impedance(options.loop_impedance)


def stop(limited: Any, options: Options, h: float) -> None:
    """Tell a coordinate or a tendon how it is stopped at its limits, in steps of h [s]."""
    limited.solref_limit = [time_constant(options.limit_steps, h, options.slowest), options.limit_damping_ratio or 1.0]
    if options.limit_impedance is not None:
        limited.solimp_limit = impedance(options.limit_impedance)
