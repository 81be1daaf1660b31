"""The kick and the drift of spheres in contact, whose velocities stand in a table of their own during a step."""

from plumbline.engine.compile.jit import kernel
from plumbline.engine.maths.elementary import exp
from plumbline.engine.maths.rows import Floats, Ints, load3, load4, store3, store4
from plumbline.engine.maths.vec import axpy, quat_spin, quat_unit, scale
from plumbline.engine.memory import arena as at
from plumbline.engine.memory.tables import Bodies


@kernel
def kick_spheres(bodies: Bodies, mover: Floats, setting: Floats, count: Ints, h: float) -> None:
    """Gravity, applied loads and damping for h seconds on all bodies in contact."""
    body, load, kind = bodies.body, bodies.load, bodies.kind
    g = load3(setting, 0, at.GRAVITY)
    for b in range(count[0, at.BODIES]):
        if kind[b, at.TOUCHED] == 1 and kind[b, at.MOTION] == at.DYNAMIC:
            v = axpy(h, axpy(mover[b, at.M_INV_MASS], load3(load, b, 0), g), load3(mover, b, 0))
            w = axpy(h * mover[b, at.M_INV_INERTIA], load3(load, b, 3), load3(mover, b, 3))
            if body[b, at.LINEAR_DAMPING] > 0.0:
                v = scale(exp(-h * body[b, at.LINEAR_DAMPING]), v)
            if body[b, at.ANGULAR_DAMPING] > 0.0:
                w = scale(exp(-h * body[b, at.ANGULAR_DAMPING]), w)
            store3(mover, b, 0, v)
            store3(mover, b, 3, w)


@kernel
def drift_spheres(bodies: Bodies, mover: Floats, count: Ints, h: float) -> None:
    """Move all bodies in contact for h seconds; `end_spheres` makes the quaternions unit."""
    state, kind = bodies.state, bodies.kind
    for b in range(count[0, at.BODIES]):
        if kind[b, at.TOUCHED] == 1 and kind[b, at.MOTION] == at.DYNAMIC:
            store3(state, b, at.P, axpy(h, load3(mover, b, 0), load3(state, b, at.P)))
            store4(state, b, at.Q, quat_spin(load4(state, b, at.Q), load3(mover, b, 3), h))


@kernel
def end_spheres(bodies: Bodies, mover: Floats, count: Ints) -> None:
    """Put the velocities of all bodies in contact back into the state."""
    state, kind = bodies.state, bodies.kind
    for b in range(count[0, at.BODIES]):
        if kind[b, at.TOUCHED] == 1 and kind[b, at.MOTION] == at.DYNAMIC:
            store4(state, b, at.Q, quat_unit(load4(state, b, at.Q)))
            store3(state, b, at.V, load3(mover, b, 0))
            store3(state, b, at.W, load3(mover, b, 3))
