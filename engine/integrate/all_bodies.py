"""One stage of a step for all bodies that it concerns: those that nothing touches, or the touched ones."""

from plumbline.engine.compile.jit import kernel
from plumbline.engine.integrate.runge_kutta import runge_kutta_free
from plumbline.engine.integrate.semi_implicit_euler import drift, drift_free, kick
from plumbline.engine.maths.rows import Floats, Ints
from plumbline.engine.memory import arena as at
from plumbline.engine.memory.tables import Bodies


@kernel
def advance_untouched(bodies: Bodies, setting: Floats, count: Ints) -> None:
    """Advance the bodies that neither contacts nor joints touch by dt, with the integrator of the settings."""
    dt, substeps, gyroscopic = setting[0, at.DT], count[0, at.SUBSTEPS], count[0, at.GYROSCOPIC]
    for b in range(count[0, at.BODIES]):
        if bodies.kind[b, at.TOUCHED] == 0:
            if count[0, at.RUNGE_KUTTA] == 1:
                runge_kutta_free(bodies, setting, b, dt, gyroscopic)
            else:
                drift_free(bodies, setting, b, dt, substeps, gyroscopic)


@kernel
def kick_touched(bodies: Bodies, setting: Floats, count: Ints, h: float) -> None:
    """Gravity, loads and damping for h seconds on the bodies that contacts or joints touch."""
    for b in range(count[0, at.BODIES]):
        if bodies.kind[b, at.TOUCHED] == 1:
            kick(bodies, setting, b, h)


@kernel
def drift_touched(bodies: Bodies, count: Ints, h: float) -> None:
    """Move the bodies that contacts or joints touch for h seconds."""
    for b in range(count[0, at.BODIES]):
        if bodies.kind[b, at.TOUCHED] == 1:
            drift(bodies, b, h, count[0, at.GYROSCOPIC])
