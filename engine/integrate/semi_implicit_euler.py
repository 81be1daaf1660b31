"""One body's velocity kick and pose drift: semi-implicit Euler on the Lie group.

    v <- exp(-c h) (v + h a),  L <- exp(-c h) (L + h tau),  p <- p + h v,  q <- exp(h w) q,  w <- I(q)^-1 L

Source: Hairer, Lubich, Wanner, Geometric Numerical Integration, sections I.1.2 and VII.5. Angular momentum is what is kept
while the body turns, so a free body conserves it to round-off.
"""

from plumbline.engine.compile.jit import kernel
from plumbline.engine.maths.elementary import exp
from plumbline.engine.maths.rows import Floats, Vec, load3, load4, load6, store3, store4, store6
from plumbline.engine.maths.vec import axpy, mat_vec, quat_mat, quat_turn, scale, sym_rotate, sym_vec, tmat_vec
from plumbline.engine.memory import arena as at
from plumbline.engine.memory.tables import Bodies


@kernel
def turn_inertia(state: Floats, body: Floats, turned: Floats, b: int) -> None:
    """Write I^-1 of body b in W, R I_B^-1 R^T."""
    store6(turned, b, 0, sym_rotate(quat_mat(load4(state, b, at.Q)), load6(body, b, at.INV_INERTIA)))


@kernel
def angular_momentum(state: Floats, body: Floats, b: int) -> Vec:
    """L = R I_B R^T w [kg m2/s] of body b about its centre of mass, in W."""
    m = quat_mat(load4(state, b, at.Q))
    return mat_vec(m, sym_vec(load6(body, b, at.INERTIA), tmat_vec(m, load3(state, b, at.W))))


@kernel
def kick(bodies: Bodies, setting: Floats, b: int, h: float) -> None:
    """Gravity, applied loads and damping for h seconds on the velocities of body b."""
    if bodies.kind[b, at.MOTION] != at.DYNAMIC:
        return
    state, body, load = bodies.state, bodies.body, bodies.load
    g = load3(setting, 0, at.GRAVITY)
    a = axpy(body[b, at.INV_MASS], load3(load, b, 0), g)
    v = axpy(h, a, load3(state, b, at.V))
    w = axpy(h, sym_vec(load6(bodies.turned, b, 0), load3(load, b, 3)), load3(state, b, at.W))
    if body[b, at.LINEAR_DAMPING] > 0.0:
        v = scale(exp(-h * body[b, at.LINEAR_DAMPING]), v)
    if body[b, at.ANGULAR_DAMPING] > 0.0:
        w = scale(exp(-h * body[b, at.ANGULAR_DAMPING]), w)
    store3(state, b, at.V, v)
    store3(state, b, at.W, w)


@kernel
def drift(bodies: Bodies, b: int, h: float, gyroscopic: int) -> None:
    """Move body b for h seconds with its velocities, keeping its angular momentum if the gyroscopic effect is on."""
    state, body, turned = bodies.state, bodies.body, bodies.turned
    if bodies.kind[b, at.MOTION] == at.DYNAMIC:
        store3(state, b, at.P, axpy(h, load3(state, b, at.V), load3(state, b, at.P)))
        w = load3(state, b, at.W)
        if body[b, at.ROUND] == 1.0:
            store4(state, b, at.Q, quat_turn(load4(state, b, at.Q), w, h))
        else:
            m = angular_momentum(state, body, b)
            store4(state, b, at.Q, quat_turn(load4(state, b, at.Q), w, h))
            turn_inertia(state, body, turned, b)
            if gyroscopic == 1:
                store3(state, b, at.W, sym_vec(load6(turned, b, 0), m))
    elif bodies.kind[b, at.MOTION] == at.KINEMATIC:
        store3(state, b, at.P, axpy(h, load3(state, b, at.V), load3(state, b, at.P)))
        store4(state, b, at.Q, quat_turn(load4(state, b, at.Q), load3(state, b, at.W), h))


@kernel
def drift_free(bodies: Bodies, setting: Floats, b: int, dt: float, substeps: int, gyroscopic: int) -> None:
    """One step of semi-implicit Euler for a body that nothing touches."""
    h = dt / substeps
    for _ in range(substeps):
        kick(bodies, setting, b, h)
        drift(bodies, b, h, gyroscopic)
