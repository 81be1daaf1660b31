"""One step of the classical Runge-Kutta method of order four, for a body that nothing touches.

State (p, q, v, L): p' = v,  q' = w q / 2,  v' = g + f/m - c v,  L' = tau - c L,  w = I(q)^-1 L.

Source: Hairer, Norsett, Wanner, Solving Ordinary Differential Equations I, section II.1, table 1.2 (1901, Kutta).
"""

from plumbline.engine.compile.jit import kernel
from plumbline.engine.integrate.semi_implicit_euler import angular_momentum, turn_inertia
from plumbline.engine.maths.rows import Floats, Quat, Sym, Vec, load3, load4, load6, store3, store4
from plumbline.engine.maths.vec import add, axpy, mat_vec, quat_mat, quat_mul, quat_turn, quat_unit, scale, sym_vec, tmat_vec
from plumbline.engine.memory import arena as at
from plumbline.engine.memory.tables import Bodies


@kernel
def quat_rate(q: Quat, w: Vec) -> Quat:
    """q' = (0, w) q / 2."""
    return quat_mul((0.0, 0.5 * w[0], 0.5 * w[1], 0.5 * w[2]), q)


@kernel
def quat_axpy(s: float, a: Quat, b: Quat) -> Quat:
    """s a + b."""
    return s * a[0] + b[0], s * a[1] + b[1], s * a[2] + b[2], s * a[3] + b[3]


@kernel
def weighted(a: Quat, b: Quat, c: Quat, d: Quat) -> Quat:
    """a + 2 b + 2 c + d."""
    return quat_axpy(1.0, quat_axpy(1.0, a, d), quat_axpy(2.0, b, quat_axpy(1.0, c, c)))


@kernel
def spin_rate(q: Quat, inverse: Sym, momentum: Vec) -> Vec:
    """w = R I_B^-1 R^T L."""
    m = quat_mat(q)
    return mat_vec(m, sym_vec(inverse, tmat_vec(m, momentum)))


@kernel
def spin_slopes(q: Quat, m: Vec, inverse: Sym, tau: Vec, d: float, gyroscopic: int) -> tuple[Quat, Vec]:
    """q' and m', m being L; without the gyroscopic effect it is w, which then stays where nothing turns the body."""
    if gyroscopic == 1:
        return quat_rate(q, spin_rate(q, inverse, m)), axpy(-d, m, tau)
    return quat_rate(q, m), axpy(-d, m, spin_rate(q, inverse, tau))


@kernel
def runge_kutta_free(bodies: Bodies, setting: Floats, b: int, dt: float, gyroscopic: int) -> None:
    """Advance body b by dt."""
    state, body, kind, load = bodies.state, bodies.body, bodies.kind, bodies.load
    p, q = load3(state, b, at.P), load4(state, b, at.Q)
    v, w = load3(state, b, at.V), load3(state, b, at.W)
    if kind[b, at.MOTION] == at.KINEMATIC:
        store3(state, b, at.P, axpy(dt, v, p))
        store4(state, b, at.Q, quat_turn(q, w, dt))
    if kind[b, at.MOTION] != at.DYNAMIC:
        return
    a = axpy(body[b, at.INV_MASS], load3(load, b, 0), load3(setting, 0, at.GRAVITY))
    c = body[b, at.LINEAR_DAMPING]
    if c == 0.0:
        store3(state, b, at.P, add(p, add(scale(dt, v), scale(0.5 * dt * dt, a))))
        store3(state, b, at.V, axpy(dt, a, v))
    else:
        v1 = axpy(-c, v, a)
        v2 = axpy(-c, axpy(0.5 * dt, v1, v), a)
        v3 = axpy(-c, axpy(0.5 * dt, v2, v), a)
        v4 = axpy(-c, axpy(dt, v3, v), a)
        store3(state, b, at.P, add(p, add(scale(dt, v), scale(dt * dt / 6.0, add(v1, add(v2, v3))))))
        store3(state, b, at.V, axpy(dt / 6.0, add(add(v1, v4), scale(2.0, add(v2, v3))), v))
    tau, d = load3(load, b, 3), body[b, at.ANGULAR_DAMPING]
    if tau == (0.0, 0.0, 0.0) and d == 0.0 and (body[b, at.ROUND] == 1.0 or w == (0.0, 0.0, 0.0)):
        store4(state, b, at.Q, quat_turn(q, w, dt))
    else:
        inverse = load6(body, b, at.INV_INERTIA)
        m = angular_momentum(state, body, b) if gyroscopic == 1 else w
        q1, (_, m1) = quat_rate(q, w), spin_slopes(q, m, inverse, tau, d, gyroscopic)
        q2, m2 = spin_slopes(quat_axpy(0.5 * dt, q1, q), axpy(0.5 * dt, m1, m), inverse, tau, d, gyroscopic)
        q3, m3 = spin_slopes(quat_axpy(0.5 * dt, q2, q), axpy(0.5 * dt, m2, m), inverse, tau, d, gyroscopic)
        q4, m4 = spin_slopes(quat_axpy(dt, q3, q), axpy(dt, m3, m), inverse, tau, d, gyroscopic)
        m = axpy(dt / 6.0, add(add(m1, m4), scale(2.0, add(m2, m3))), m)
        q = quat_unit(quat_axpy(dt / 6.0, weighted(q1, q2, q3, q4), q))
        store4(state, b, at.Q, q)
        store3(state, b, at.W, spin_rate(q, inverse, m) if gyroscopic == 1 else m)
    turn_inertia(state, body, bodies.turned, b)
