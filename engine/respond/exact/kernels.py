"""The compiled parts of an exact step: find contacts, kick, drift: the stages of the soft solver, one by one."""

from engine.compile.jit import entry
from engine.contact.find_contacts import find_contacts
from engine.integrate.all_bodies import advance_untouched
from engine.integrate.finite_state import is_finite
from engine.integrate.semi_implicit_euler import drift, kick
from engine.maths.vec import Floats, Ints
from engine.memory.arena import (
    BODIES,
    COUNT,
    GYROSCOPIC,
    MANIFOLD,
    MANIFOLD_KEY,
    MANIFOLDS,
    POINT,
    SETTING,
    STEPS,
    TOUCHED,
)  # fmt: skip
from engine.memory.carve import floats_of, ints_of
from engine.memory.tables import bodies_of
from engine.respond.soft import approach, refresh, sum_impulses
from engine.steps.contact import slow_approach

__all__ = ["begin_step", "drift_touched", "kick_touched"]


@entry
def begin_step(floats: Floats, ints: Ints) -> int:
    """Find the contacts of a step and advance the bodies that nothing touches. Returns: as `find_contacts`."""
    count = ints_of(ints, COUNT)
    status = find_contacts(floats, ints)
    if status != 0:
        return status
    advance_untouched(bodies_of(floats, ints), floats_of(floats, ints, SETTING), count)
    return 0


@entry
def kick_touched(floats: Floats, ints: Ints, h: float) -> float:
    """Gravity, loads and damping for h seconds on the bodies in contact, and note the points that will strike.

    Returns: the approach speed [m/s] below which nothing bounces.
    """
    bodies, setting, count = bodies_of(floats, ints), floats_of(floats, ints, SETTING), ints_of(ints, COUNT)
    state, kind = bodies.state, bodies.kind
    for b in range(count[0, BODIES]):
        if kind[b, TOUCHED] == 1:
            kick(bodies, setting, b, h)
    manifold, point, key = floats_of(floats, ints, MANIFOLD), floats_of(floats, ints, POINT), ints_of(ints, MANIFOLD_KEY)
    slow = slow_approach(setting, h)
    approach(state, kind, setting, count[0, MANIFOLDS], manifold, key, point, h, slow)
    return slow


@entry
def drift_touched(floats: Floats, ints: Ints, h: float, last: int) -> int:
    """Move the bodies in contact for h seconds. Args: last: 1 to end the step. Returns: 0, or 1 if no longer finite."""
    bodies, count = bodies_of(floats, ints), ints_of(ints, COUNT)
    state, kind = bodies.state, bodies.kind
    manifold, point, key = floats_of(floats, ints, MANIFOLD), floats_of(floats, ints, POINT), ints_of(ints, MANIFOLD_KEY)
    for b in range(count[0, BODIES]):
        if kind[b, TOUCHED] == 1:
            drift(bodies, b, h, count[0, GYROSCOPIC])
    refresh(state, 0, count[0, MANIFOLDS], manifold, key, point)
    sum_impulses(count[0, MANIFOLDS], manifold, key, point)
    if last == 1:
        count[0, STEPS] += 1
        return 0 if is_finite(state, count[0, BODIES]) else 1
    return 0
