"""The compiled parts of an exact step: find contacts, kick, drift: the stages of the soft solver, one by one."""

from engine.compile.jit import entry
from engine.contact.find_contacts import find_contacts
from engine.integrate.finite_state import is_finite
from engine.integrate.runge_kutta import runge_kutta_free
from engine.integrate.semi_implicit_euler import drift, drift_free, kick
from engine.maths.vec import Floats, Ints
from engine.memory.arena import (
    BODIES,
    BODY,
    BODY_KIND,
    COUNT,
    DT,
    GYROSCOPIC,
    LOAD,
    MANIFOLD,
    MANIFOLD_KEY,
    MANIFOLDS,
    POINT,
    RUNGE_KUTTA,
    SETTING,
    STATE,
    STEPS,
    SUBSTEPS,
    TOUCHED,
    TURNED,
)  # fmt: skip
from engine.memory.carve import floats_of, ints_of
from engine.respond.soft import approach, refresh, sum_impulses
from engine.steps.contact import slow_approach

__all__ = ["begin_step", "drift_touched", "kick_touched"]


@entry
def begin_step(floats: Floats, ints: Ints) -> int:
    """Find the contacts of a step and advance the bodies that nothing touches. Returns: as `find_contacts`."""
    state, body, turned = floats_of(floats, ints, STATE), floats_of(floats, ints, BODY), floats_of(floats, ints, TURNED)
    load, setting = floats_of(floats, ints, LOAD), floats_of(floats, ints, SETTING)
    kind, count = ints_of(ints, BODY_KIND), ints_of(ints, COUNT)
    status = find_contacts(floats, ints)
    if status != 0:
        return status
    for b in range(count[0, BODIES]):
        if kind[b, TOUCHED] == 0:
            if count[0, RUNGE_KUTTA] == 1:
                runge_kutta_free(state, body, kind, turned, load, setting, b, setting[0, DT], count[0, GYROSCOPIC])
            else:
                drift_free(
                    state, body, kind, turned, load, setting, b, setting[0, DT], count[0, SUBSTEPS], count[0, GYROSCOPIC]
                )
    return 0


@entry
def kick_touched(floats: Floats, ints: Ints, h: float) -> float:
    """Gravity, loads and damping for h seconds on the bodies in contact, and note the points that will strike.

    Returns: the approach speed [m/s] below which nothing bounces.
    """
    state, body, turned = floats_of(floats, ints, STATE), floats_of(floats, ints, BODY), floats_of(floats, ints, TURNED)
    load, setting = floats_of(floats, ints, LOAD), floats_of(floats, ints, SETTING)
    kind, count = ints_of(ints, BODY_KIND), ints_of(ints, COUNT)
    for b in range(count[0, BODIES]):
        if kind[b, TOUCHED] == 1:
            kick(state, body, kind, turned, load, setting, b, h)
    manifold, point, key = floats_of(floats, ints, MANIFOLD), floats_of(floats, ints, POINT), ints_of(ints, MANIFOLD_KEY)
    slow = slow_approach(setting, h)
    approach(state, kind, setting, count[0, MANIFOLDS], manifold, key, point, h, slow)
    return slow


@entry
def drift_touched(floats: Floats, ints: Ints, h: float, last: int) -> int:
    """Move the bodies in contact for h seconds. Args: last: 1 to end the step. Returns: 0, or 1 if no longer finite."""
    state, body, turned = floats_of(floats, ints, STATE), floats_of(floats, ints, BODY), floats_of(floats, ints, TURNED)
    kind, count = ints_of(ints, BODY_KIND), ints_of(ints, COUNT)
    manifold, point, key = floats_of(floats, ints, MANIFOLD), floats_of(floats, ints, POINT), ints_of(ints, MANIFOLD_KEY)
    for b in range(count[0, BODIES]):
        if kind[b, TOUCHED] == 1:
            drift(state, body, kind, turned, b, h, count[0, GYROSCOPIC])
    refresh(state, 0, count[0, MANIFOLDS], manifold, key, point)
    sum_impulses(count[0, MANIFOLDS], manifold, key, point)
    if last == 1:
        count[0, STEPS] += 1
        return 0 if is_finite(state, count[0, BODIES]) else 1
    return 0
