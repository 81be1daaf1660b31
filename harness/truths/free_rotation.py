"""The torque-free rotation of an asymmetric top, in closed form, and what first-order methods make of it.

Moments of inertia are principal, (3,) kg m2; a spin is the angular velocity in B at time 0, (3,) rad/s, with B on W there.
"""

from functools import lru_cache

import numpy as np

from plumbline.harness.scene.values import Vector3
from plumbline.harness.trajectory import Floats
from plumbline.harness.trajectory.kinematics import conjugate, product, rotate

FIRST_ORDER = (
    "twice the error, to first order in dt, of the worst of the four textbook first-order methods (gyroscopic torque explicit "
    "or implicit, turning by old or new rates) in this very motion; the factor 2 leaves room for terms of second order"
)
"""Why twice `first_order_errors` bounds the errors of any consistent method."""


def body_rates(time: Floats, moments: Vector3, spin: Vector3) -> Floats:
    """Angular velocity in B, (t, 3) rad/s: Jacobi's elliptic functions (Landau and Lifshitz, Mechanics, 3rd ed., section 37).

    Raises:
        ValueError: the moments are not ascending, or the motion lies on the separatrix, where the functions degenerate.
    """
    from scipy.special import ellipj, ellipkinc  # late: a listing must not pay for it

    order = np.arange(3)
    i, w = np.array(moments), np.array(spin)
    if not i[0] < i[1] < i[2]:
        raise ValueError(f"moments {moments} kg m2, expected three in strictly ascending order")
    excess = i[2] * (i[2] - i[1]) * w[2] ** 2 - i[0] * (i[1] - i[0]) * w[0] ** 2
    if abs(excess) < 1e-9 * np.sum((i * w) ** 2):
        raise ValueError(f"spin {spin} rad/s lies on the separatrix of moments {moments} kg m2")
    if excess < 0:
        # The top turns about its first axis: the formulas hold with the first and third exchanged.
        order = order[::-1]
        i, w = i[::-1], w[::-1]
    i1, i2, i3 = i
    # 2 E I3 - L^2 and L^2 - 2 E I1, written as sums of squares so that a spin near an axis loses no digits to a difference.
    upper = i1 * (i3 - i1) * w[0] ** 2 + i2 * (i3 - i2) * w[1] ** 2
    lower = i2 * (i2 - i1) * w[1] ** 2 + i3 * (i3 - i1) * w[2] ** 2
    a1, a2 = np.sqrt(upper / (i1 * (i3 - i1))), np.sqrt(upper / (i2 * (i3 - i2)))
    a3 = np.sqrt(lower / (i3 * (i3 - i1)))
    rate = np.sqrt((i3 - i2) * lower / (i1 * i2 * i3))
    m = float(np.clip((i2 - i1) * upper / ((i3 - i2) * lower), 0.0, 1.0))
    if a1 == 0.0 and a2 == 0.0:
        return np.broadcast_to(np.array(spin), (len(time), 3)).copy()
    # w1 = a1 cn u, w2 = a2 sn u, w3 = s3 a3 dn u. Euler's first equation gives the sign of u' as that of w3 in both orders: the
    # exchange of two axes turns the signs of i3 - i2 and of the vector product together.
    s3 = 1.0 if w[2] >= 0 else -1.0
    u0 = float(ellipkinc(float(np.arctan2(w[1] / a2, w[0] / a1)), m))
    sn, cn, dn, _ = ellipj(u0 + s3 * rate * np.asarray(time), m)
    rates = np.stack([a1 * cn, a2 * sn, s3 * a3 * dn], axis=1)
    ordered: Floats = rates[:, np.argsort(order)]
    return ordered


def _turn(axis: int, angle: Floats) -> Floats:
    """The rotation by angles [rad] (t,) about a coordinate axis, (t, 4)."""
    q = np.zeros((len(angle), 4))
    q[:, 0], q[:, 1 + axis] = np.cos(angle / 2), np.sin(angle / 2)
    return q


def _against_momentum(time: Floats, moments: Vector3, spin: Vector3) -> Floats:
    """Attitude of B against a frame with its third axis along L, (t, 4), by Euler angles about the body's middle axis.

    L never points along the middle axis off the separatrix, so that the angles are regular: with x, y, z the axes 3, 1, 2 of B,
    L_B = |L| (sin theta sin psi, sin theta cos psi, cos theta) and phi' = |L| (w_x L_x + w_y L_y)/(L_x^2 + L_y^2), which is
    integrated by Gauss and Legendre's rule of 10 points over pieces of at most 0.1 rad.
    """
    inertia = np.array(moments)
    edges = np.concatenate([[0.0], np.asarray(time, dtype=np.float64)])
    pieces = np.maximum(1, np.ceil(np.abs(np.diff(edges)) * np.linalg.norm(spin) * inertia[2] / inertia[0] / 0.1)).astype(int)
    fine = np.concatenate([np.linspace(a, b, n, endpoint=False) for a, b, n in zip(edges, edges[1:], pieces, strict=False)])
    fine = np.append(fine, edges[-1])
    nodes, weights = np.polynomial.legendre.leggauss(10)
    half, middle = np.diff(fine) / 2, (fine[1:] + fine[:-1]) / 2
    w_B = body_rates((middle[:, None] + half[:, None] * nodes).ravel(), moments, spin)
    l_B = w_B * inertia
    across = l_B[:, 2] ** 2 + l_B[:, 0] ** 2
    rate = np.linalg.norm(l_B, axis=1) * (w_B[:, 2] * l_B[:, 2] + w_B[:, 0] * l_B[:, 0]) / across
    grown = np.concatenate([[0.0], np.cumsum(half * (rate.reshape(-1, 10) @ weights))])
    phi = grown[np.cumsum(pieces)]
    l_B = body_rates(time, moments, spin) * inertia
    theta = np.arctan2(np.hypot(l_B[:, 2], l_B[:, 0]), l_B[:, 1])
    psi = np.arctan2(l_B[:, 2], l_B[:, 0])
    # The axes 3, 1, 2 are those of B turned by a third of a turn about (1, 1, 1).
    relabelled = np.full((len(phi), 4), 0.5)
    return product(product(_turn(2, phi), _turn(0, theta)), product(_turn(2, psi), relabelled))


def free_rotation(time: Floats, moments: Vector3, spin: Vector3) -> tuple[Floats, Floats]:
    """Attitude q_WB (t, 4) and angular velocity w_WB (t, 3) rad/s of a body that nothing acts on.

    The rates come from elliptic functions, the attitude by quadrature about the constant angular momentum.

    Raises:
        ValueError: as `body_rates`.
    """
    from_start = _against_momentum(np.concatenate([[0.0], time]), moments, spin)
    q_WB = product(np.broadcast_to(conjugate(from_start[:1]), (len(time), 4)), from_start[1:])
    return q_WB, rotate(q_WB, body_rates(time, moments, spin))


@lru_cache(maxsize=16)
def first_order_errors(moments: Vector3, spin: Vector3, duration: float) -> tuple[float, float, float]:
    """Largest errors per dt [1/s] of textbook methods of first order in `duration` [s]: attitude, momentum, energy.

    A first-order method follows, to second order, the exact equations with its first-order defect added (backward error
    analysis: Hairer, Lubich, Wanner, chapter IX). With a = w' = f(w) that defect is -/+ (dt/2) a' in the rates (gyroscopic
    torque explicit or implicit) and +/- (dt/2) a in the turning of the body (new or old rates used); the four are integrated
    along the true motion together with Euler's equations, and the worst is taken.
    """
    from scipy.integrate import solve_ivp  # late: a listing must not pay for it

    inertia = np.array(moments)
    after, before = [1, 2, 0], [2, 0, 1]
    coupling = (inertia[before] - inertia[after]) / inertia

    def acceleration(w: Floats) -> Floats:
        a: Floats = -coupling * w[after] * w[before]
        return a

    def change(w: Floats, dw: Floats) -> Floats:
        c: Floats = -coupling * (dw[after] * w[before] + w[after] * dw[before])
        return c

    times = np.linspace(0.0, duration, 401)
    worst = np.zeros(3)
    for torque in (-0.5, 0.5):
        for turning in (-0.5, 0.5):

            def rates(_t: float, y: Floats, torque: float = torque, turning: float = turning) -> Floats:
                w, dw, angle = y[:3], y[3:6], y[6:]
                a = acceleration(w)
                carried = angle[after] * w[before] - angle[before] * w[after]
                return np.concatenate([a, change(w, dw) + torque * change(w, a), carried + dw + turning * a])

            states = solve_ivp(rates, (0, duration), [*spin] + [0.0] * 6, "DOP853", t_eval=times, rtol=1e-9, atol=1e-11).y.T
            w, dw, angle = states[:, :3], states[:, 3:6], states[:, 6:]
            l_B = inertia * w
            moved = np.linalg.norm(np.cross(angle, l_B) + inertia * dw, axis=1) / np.linalg.norm(l_B[0])
            energy = np.abs(np.sum(dw * l_B, axis=1)) / (0.5 * np.sum(w[0] * l_B[0]))
            here = np.array([np.linalg.norm(angle, axis=1).max(), moved.max(), energy.max()])
            worst = np.maximum(worst, here)
    return float(worst[0]), float(worst[1]), float(worst[2])
