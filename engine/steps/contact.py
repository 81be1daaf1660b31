"""Steps of worlds with contact, without joints: find contacts, advance what is free, solve what is touched in sub-steps."""

import math

from engine.compile.jit import entry, kernel
from engine.contact.find_contacts import find_contacts, keep_contacts
from engine.integrate.all_bodies import advance_untouched, drift_touched, kick_touched
from engine.integrate.finite_state import is_finite
from engine.maths.vec import Floats, Ints, load3, norm
from engine.memory.arena import (
    BODIES,
    BOUNCE_SPEED,
    COUNT,
    DAMPING_RATIO,
    DT,
    GRAVITY,
    HERTZ,
    ITERATIONS,
    MANIFOLD,
    MANIFOLD_KEY,
    MANIFOLDS,
    MAX_PUSH,
    NEW,
    POINT,
    RELAXATIONS,
    REST,
    SETTING,
    START,
    STEPS,
    SUBSTEPS,
)  # fmt: skip
from engine.memory.carve import floats_of, ints_of
from engine.memory.tables import bodies_of
from engine.respond.share_loads import share_loads
from engine.respond.soft import approach, bounce, end_step, end_substep, friction_mode, refresh, sweep, warm_start

__all__ = ["slow_approach", "soft_factors", "step_contact"]

FRESH = 8
"""Times as many sweeps for a blow and in the first sub-step of a contact, which have no impulses to start from."""


@kernel
def soft_factors(hertz: float, damping_ratio: float, h: float) -> tuple[float, float, float]:
    """Bias rate [1/s], mass scale and impulse scale of a soft contact; at most a quarter turn per sub-step.

    Source: Catto, Soft Constraints, GDC 2011.
    """
    omega = 2.0 * math.pi * min(hertz, 0.25 / h)
    a1 = 2.0 * damping_ratio + h * omega
    a2 = h * omega * a1
    a3 = 1.0 / (1.0 + a2)
    return omega / a1, a2 * a3, a3


@kernel
def slow_approach(setting: Floats, h: float) -> float:
    """The approach speed [m/s] below which nothing bounces: as set, or four times what gravity gives in one sub-step."""
    if setting[0, BOUNCE_SPEED] >= 0.0:
        return float(setting[0, BOUNCE_SPEED])
    return 4.0 * h * norm(load3(setting, 0, GRAVITY)) + 1e-9


@entry
def step_contact(floats: Floats, ints: Ints, steps: int) -> tuple[int, int]:
    """Advance bodies in contact.

    Returns: steps done, and 0, or 1 if the state stopped being finite, or 2 if the arena must grow before the next step, or 3
    if pairs wait for the convex narrow phase.
    """
    bodies = bodies_of(floats, ints)
    state, body, turned, _, kind = bodies
    setting, sums = floats_of(floats, ints, SETTING), floats_of(floats, ints, START)
    manifold, point, key = floats_of(floats, ints, MANIFOLD), floats_of(floats, ints, POINT), ints_of(ints, MANIFOLD_KEY)
    count, rest = ints_of(ints, COUNT), floats_of(floats, ints, REST)
    last, substeps = count[0, BODIES], count[0, SUBSTEPS]
    h = setting[0, DT] / substeps
    rate, mass_scale, keep = soft_factors(setting[0, HERTZ], setting[0, DAMPING_RATIO], h)
    slow, most = slow_approach(setting, h), setting[0, MAX_PUSH]
    for step in range(steps):
        if not keep_contacts(state, body, kind, rest, setting, count, key, point):
            status = find_contacts(floats, ints)
            if status != 0:
                return step, status
        n = count[0, MANIFOLDS]
        advance_untouched(bodies, setting, count)
        if n > 0:
            for substep in range(substeps):
                kick_touched(bodies, setting, count, h)
                strikes = approach(state, kind, setting, n, manifold, key, point, h, slow)
                patience = FRESH if strikes > 0 or (substep == 0 and count[0, NEW] > 0) else 1
                share_loads(kind, last, sums, n, manifold, key, point)
                warm_start(state, body, turned, n, manifold, key, point)
                for _ in range(count[0, ITERATIONS] * patience):
                    sweep(state, body, turned, n, manifold, key, point, h, rate, mass_scale, keep, most, 1, 0)
                drift_touched(bodies, count, h)
                refresh(state, 0, n, manifold, key, point)
                share_loads(kind, last, sums, n, manifold, key, point)
                for _ in range(count[0, RELAXATIONS] * patience):
                    sweep(state, body, turned, n, manifold, key, point, h, rate, mass_scale, keep, most, 0, 0)
                if bounce(n, manifold, key, point):
                    for _ in range(FRESH * (count[0, ITERATIONS] + count[0, RELAXATIONS])):
                        sweep(state, body, turned, n, manifold, key, point, h, rate, mass_scale, keep, most, 0, 1)
                friction_mode(state, body, n, manifold, key, point)
                end_substep(n, key, point)
            end_step(n, manifold, key, point)
        count[0, STEPS] += 1
        if not is_finite(state, last):
            return step + 1, 1
    return steps, 0
