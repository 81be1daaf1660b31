"""One stage of a step for all bodies that it concerns: those that nothing touches, or touched ones."""

from plumbline.engine.compile.jit import kernel
from plumbline.engine.integrate.runge_kutta import runge_kutta_free
from plumbline.engine.integrate.semi_implicit_euler import drift, drift_free, kick
from plumbline.engine.maths.rows import Floats, Ints
from plumbline.engine.memory import arena as at
from plumbline.engine.memory.carve import ints_of
from plumbline.engine.memory.tables import Bodies


@kernel
def advance_untouched(bodies: Bodies, setting: Floats, count: Ints, order: Ints) -> None:
    """Advance the bodies that neither contacts nor joints touch by dt, with the integrator of the settings; list the others.

    Args: order: BODY_ORDER.
    """
    dt, substeps, gyroscopic, touched = setting[0, at.DT], count[0, at.SUBSTEPS], count[0, at.GYROSCOPIC], 0
    for b in range(count[0, at.BODIES]):
        if bodies.kind[b, at.TOUCHED] == 1:
            order[touched, 0] = b
            touched += 1
        elif count[0, at.RUNGE_KUTTA] == 1:
            runge_kutta_free(bodies, setting, b, dt, gyroscopic)
        else:
            drift_free(bodies, setting, b, dt, substeps, gyroscopic)
    count[0, at.TOUCHED_BODIES] = touched


@kernel
def touched_of(ints: Ints) -> Ints:
    """The bodies (k, 1) that `advance_untouched` has left."""
    return ints_of(ints, at.BODY_ORDER)[: ints_of(ints, at.COUNT)[0, at.TOUCHED_BODIES]]


@kernel
def kick_all(bodies: Bodies, some: Ints, setting: Floats, h: float) -> None:
    """Gravity, loads and damping for h seconds on some bodies (k, 1)."""
    for rank in range(len(some)):
        kick(bodies, setting, some[rank, 0], h)


@kernel
def drift_all(bodies: Bodies, some: Ints, count: Ints, h: float) -> None:
    """Move some bodies (k, 1) for h seconds."""
    for rank in range(len(some)):
        drift(bodies, some[rank, 0], h, count[0, at.GYROSCOPIC])
