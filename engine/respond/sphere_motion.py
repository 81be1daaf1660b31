"""The kick and the drift of spheres in contact, whose velocities stand in a table of their own during a step."""

from engine.compile.jit import kernel
from engine.maths.elementary import exp
from engine.maths.vec import Floats, Ints, axpy, load3, load4, quat_spin, quat_unit, scale, store3, store4
from engine.memory.arena import (
    ANGULAR_DAMPING,
    BODIES,
    DYNAMIC,
    GRAVITY,
    LINEAR_DAMPING,
    M_INV_INERTIA,
    M_INV_MASS,
    MOTION,
    TOUCHED,
    P,
    Q,
    V,
    W,
)
from engine.memory.tables import Bodies

__all__ = ["drift_spheres", "end_spheres", "kick_spheres"]


@kernel
def kick_spheres(bodies: Bodies, mover: Floats, setting: Floats, count: Ints, h: float) -> None:
    """Gravity, applied loads and damping for h seconds on all bodies in contact."""
    body, load, kind = bodies.body, bodies.load, bodies.kind
    g = load3(setting, 0, GRAVITY)
    for b in range(count[0, BODIES]):
        if kind[b, TOUCHED] == 1 and kind[b, MOTION] == DYNAMIC:
            v = axpy(h, axpy(mover[b, M_INV_MASS], load3(load, b, 0), g), load3(mover, b, 0))
            w = axpy(h * mover[b, M_INV_INERTIA], load3(load, b, 3), load3(mover, b, 3))
            if body[b, LINEAR_DAMPING] > 0.0:
                v = scale(exp(-h * body[b, LINEAR_DAMPING]), v)
            if body[b, ANGULAR_DAMPING] > 0.0:
                w = scale(exp(-h * body[b, ANGULAR_DAMPING]), w)
            store3(mover, b, 0, v)
            store3(mover, b, 3, w)


@kernel
def drift_spheres(bodies: Bodies, mover: Floats, count: Ints, h: float) -> None:
    """Move all bodies in contact for h seconds; `end_spheres` makes the quaternions unit."""
    state, kind = bodies.state, bodies.kind
    for b in range(count[0, BODIES]):
        if kind[b, TOUCHED] == 1 and kind[b, MOTION] == DYNAMIC:
            store3(state, b, P, axpy(h, load3(mover, b, 0), load3(state, b, P)))
            store4(state, b, Q, quat_spin(load4(state, b, Q), load3(mover, b, 3), h))


@kernel
def end_spheres(bodies: Bodies, mover: Floats, count: Ints) -> None:
    """Put the velocities of all bodies in contact back into the state."""
    state, kind = bodies.state, bodies.kind
    for b in range(count[0, BODIES]):
        if kind[b, TOUCHED] == 1 and kind[b, MOTION] == DYNAMIC:
            store4(state, b, Q, quat_unit(load4(state, b, Q)))
            store3(state, b, V, load3(mover, b, 0))
            store3(state, b, W, load3(mover, b, 3))
