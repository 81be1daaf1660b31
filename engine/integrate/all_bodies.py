"""Integration of all bodies that it is about: those that nothing touches by whole steps, the touched ones by kick and drift."""

from engine.compile.jit import kernel
from engine.integrate.runge_kutta import runge_kutta_free
from engine.integrate.semi_implicit_euler import drift, drift_free, kick
from engine.maths.vec import Floats, Ints
from engine.memory.arena import BODIES, DT, GYROSCOPIC, RUNGE_KUTTA, SUBSTEPS, TOUCHED
from engine.memory.tables import Bodies

__all__ = ["advance_untouched", "drift_touched", "kick_touched"]


@kernel
def advance_untouched(bodies: Bodies, setting: Floats, count: Ints) -> None:
    """Advance the bodies that nothing touches by a whole step."""
    state, body, turned, load, kind = bodies
    dt, gyroscopic, substeps = setting[0, DT], count[0, GYROSCOPIC], count[0, SUBSTEPS]
    for b in range(count[0, BODIES]):
        if kind[b, TOUCHED] == 0:
            if count[0, RUNGE_KUTTA] == 1:
                runge_kutta_free(state, body, kind, turned, load, setting, b, dt, gyroscopic)
            else:
                drift_free(state, body, kind, turned, load, setting, b, dt, substeps, gyroscopic)


@kernel
def kick_touched(bodies: Bodies, setting: Floats, count: Ints, h: float) -> None:
    """Gravity, loads and damping for h seconds on the bodies in contact or held by joints."""
    state, body, turned, load, kind = bodies
    for b in range(count[0, BODIES]):
        if kind[b, TOUCHED] == 1:
            kick(state, body, kind, turned, load, setting, b, h)


@kernel
def drift_touched(bodies: Bodies, count: Ints, h: float) -> None:
    """Move the bodies in contact or held by joints for h seconds."""
    state, body, turned, _, kind = bodies
    for b in range(count[0, BODIES]):
        if kind[b, TOUCHED] == 1:
            drift(state, body, kind, turned, b, h, count[0, GYROSCOPIC])
