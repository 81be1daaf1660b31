"""Sequential impulses: projected Gauss-Seidel on velocities, warm-started, with a split impulse for the position error.

For each point in turn, with the effective mass m of its direction and the velocity u of B against A,

    friction      l_T <- project onto the disc of radius mu l_N:  l_T - m_T u_T
    normal        l_N <- max(l_N - m_N (u_N + s / h), 0)           s > 0: a gap may close, not more
    restitution   l_N <- max(l_N - m_N (u_N + e u_before), 0)      for points that struck
    position      p   <- max(p - m_N (w_N + beta (s + slop) / h), 0)     pseudo-velocities w, forgotten after the move

and each change of an impulse goes into the velocities at once. Sweeps go through the contacts forwards and backwards in turn:
always in one order, from the ground up, a stack of ten boxes keeps swaying at 7 cm/s. The slop is a depth left alone, so that
contacts last; without it such a stack rattles at 1 cm/s, as sweeps that end too early part what they should hold. Soft
sub-stepped contact has a spring where this has the pseudo-velocities.

Source: Catto, Iterative Dynamics with Temporal Coherence, GDC 2005 (accumulated impulses, warm start); Catto, Fast and Simple
Physics using Sequential Impulses, GDC 2006 (split impulse); Jean, Comput. Methods Appl. Mech. Eng. 177, 1999 (cone); Saad,
Iterative Methods for Sparse Linear Systems, 2003, section 4.1 (symmetric Gauss-Seidel).
"""

import math

from engine.compile.jit import kernel
from engine.integrate.semi_implicit_euler import turn_inertia
from engine.maths.vec import (
    Floats,
    Ints,
    Sym,
    Vec,
    add,
    axpy,
    cross,
    dot,
    load3,
    load4,
    load6,
    norm,
    quat_turn,
    scale,
    store3,
    store4,
    sub,
    sym_vec,
)  # fmt: skip
from engine.memory.arena import (
    APPROACH,
    ARM_A,
    ARM_B,
    BODY_A,
    BODY_B,
    DYNAMIC,
    HELD,
    INV_MASS,
    LAW,
    MOTION,
    NORMAL,
    NORMAL_IMPULSE,
    NORMAL_MASS,
    POINTS,
    PUSH,
    SEPARATION,
    SLIPS,
    SPIKE,
    SPIN_IMPULSE,
    SPIN_MASS,
    STRUCK,
    TANGENT_MASS,
    TANGENTS,
    P,
    Q,
    V,
    W,
)  # fmt: skip

__all__ = ["push_apart", "sweep_velocities"]

BAUMGARTE = 0.2
"""Share of a depth [1] that one position correction works off; Baumgarte's, here on pseudo-velocities."""


@kernel
def push(
    ma: float, ia: Sym, ra: Vec, mb: float, ib: Sym, rb: Vec, impulse: Vec, va: Vec, wa: Vec, vb: Vec, wb: Vec
) -> tuple[Vec, Vec, Vec, Vec]:
    """The velocities after an impulse on B and its reaction on A."""
    return (
        axpy(-ma, impulse, va),
        sub(wa, sym_vec(ia, cross(ra, impulse))),
        axpy(mb, impulse, vb),
        add(wb, sym_vec(ib, cross(rb, impulse))),
    )


@kernel
def spin_impulse(manifold: Floats, m: int, n: Vec, w: Vec, total: float) -> Vec:
    """The impulse [N m s] against rolling and spinning at the relative angular velocity w, under the normal impulse `total`."""
    before = load3(manifold, m, SPIN_IMPULSE)
    most = manifold[m, LAW + 4] * total
    twist = min(max(dot(n, before) - manifold[m, SPIN_MASS + 1] * dot(n, w), -most), most)
    roll = axpy(-manifold[m, SPIN_MASS], axpy(-dot(n, w), n, w), axpy(-dot(n, before), n, before))
    size, most = norm(roll), manifold[m, LAW + 3] * total
    if size > most:
        roll = scale(most / size, roll)
    return axpy(twist, n, roll)


@kernel
def sweep_velocities(
    state: Floats, body: Floats, turned: Floats, manifolds: int, manifold: Floats, key: Ints, point: Floats, h: float,
    bouncing: int, back: int,
) -> None:  # fmt: skip
    """One sweep over all manifolds: friction first, then the normals, which matter most.

    Args: bouncing: 1 to aim at the velocity after restitution where a point struck; then points that gave no impulse stay out,
    for what a rebound meets is a blow to come. back: 1 to go from the last to the first.
    """
    for turn in range(manifolds):
        m = manifolds - 1 - turn if back == 1 else turn
        a, b = key[m, BODY_A], key[m, BODY_B]
        n, t1, t2 = load3(manifold, m, NORMAL), load3(manifold, m, TANGENTS), load3(manifold, m, TANGENTS + 3)
        ma, mb = body[a, INV_MASS], body[b, INV_MASS]
        ia, ib = load6(turned, a, 0), load6(turned, b, 0)
        va, wa, vb, wb = load3(state, a, V), load3(state, a, W), load3(state, b, V), load3(state, b, W)
        first, last = 4 * m, 4 * m + key[m, POINTS]
        if manifold[m, LAW + 3] > 0.0 or manifold[m, LAW + 4] > 0.0:
            total = 0.0
            for i in range(first, last):
                total += point[i, NORMAL_IMPULSE]
            spin = spin_impulse(manifold, m, n, sub(wb, wa), total)
            change = sub(spin, load3(manifold, m, SPIN_IMPULSE))
            store3(manifold, m, SPIN_IMPULSE, spin)
            wa, wb = sub(wa, sym_vec(ia, change)), add(wb, sym_vec(ib, change))
        friction = manifold[m, LAW] if key[m, SLIPS] == 0 else manifold[m, LAW + 1]
        if friction > 0.0:
            for k in range(first, last):
                i = first + last - 1 - k if back == 1 else k
                ra, rb = load3(point, i, ARM_A), load3(point, i, ARM_B)
                u = sub(add(vb, cross(wb, rb)), add(va, cross(wa, ra)))
                was_1, was_2 = point[i, HELD], point[i, HELD + 1]
                one, two = was_1 - point[i, TANGENT_MASS] * dot(t1, u), was_2 - point[i, TANGENT_MASS] * dot(t2, u)
                size, most = math.sqrt(one * one + two * two), friction * point[i, NORMAL_IMPULSE]
                if size > most:
                    one, two = most / size * one, most / size * two
                point[i, HELD], point[i, HELD + 1] = one, two
                change = axpy(one - was_1, t1, scale(two - was_2, t2))
                va, wa, vb, wb = push(ma, ia, ra, mb, ib, rb, change, va, wa, vb, wb)
        for k in range(first, last):
            i = first + last - 1 - k if back == 1 else k
            if bouncing == 1 and point[i, SEPARATION] > 0.0 and point[i, NORMAL_IMPULSE] == 0.0:
                continue
            ra, rb = load3(point, i, ARM_A), load3(point, i, ARM_B)
            bias = max(point[i, SEPARATION], 0.0) / h
            if bouncing == 1 and point[i, STRUCK] == 1.0 and point[i, SPIKE] > 0.0:
                bias = manifold[m, LAW + 2] * point[i, APPROACH]
            speed = dot(n, sub(add(vb, cross(wb, rb)), add(va, cross(wa, ra))))
            before = point[i, NORMAL_IMPULSE]
            impulse = max(before - point[i, NORMAL_MASS] * (speed + bias), 0.0)
            point[i, NORMAL_IMPULSE] = impulse
            point[i, SPIKE] = max(point[i, SPIKE], impulse)
            va, wa, vb, wb = push(ma, ia, ra, mb, ib, rb, scale(impulse - before, n), va, wa, vb, wb)
        store3(state, a, V, va)
        store3(state, a, W, wa)
        store3(state, b, V, vb)
        store3(state, b, W, wb)


@kernel
def push_apart(
    state: Floats, body: Floats, kind: Ints, turned: Floats, bodies: int, pseudo: Floats, manifolds: int, manifold: Floats,
    key: Ints, point: Floats, h: float, sweeps: int, slop: float,
) -> bool:  # fmt: skip
    """Work off depths by pseudo-velocities, kept in `pseudo` (bodies + 1, 13), that last for this one move of h seconds.

    Args: slop [m]: the depth that is left. Returns: whether anything was deep enough to move.
    """
    deep = False
    for m in range(manifolds):
        for i in range(4 * m, 4 * m + key[m, POINTS]):
            point[i, PUSH] = 0.0
            deep = deep or point[i, SEPARATION] < -slop
    if not deep:
        return False
    for b in range(bodies + 1):
        store3(pseudo, b, V, (0.0, 0.0, 0.0))
        store3(pseudo, b, W, (0.0, 0.0, 0.0))
    for _ in range(sweeps):
        for m in range(manifolds):
            a, b = key[m, BODY_A], key[m, BODY_B]
            n = load3(manifold, m, NORMAL)
            ma, mb = body[a, INV_MASS], body[b, INV_MASS]
            ia, ib = load6(turned, a, 0), load6(turned, b, 0)
            va, wa, vb, wb = load3(pseudo, a, V), load3(pseudo, a, W), load3(pseudo, b, V), load3(pseudo, b, W)
            for i in range(4 * m, 4 * m + key[m, POINTS]):
                s, before = point[i, SEPARATION], point[i, PUSH]
                if s > -slop and before == 0.0:
                    continue
                ra, rb = load3(point, i, ARM_A), load3(point, i, ARM_B)
                speed = dot(n, sub(add(vb, cross(wb, rb)), add(va, cross(wa, ra))))
                after = max(before - point[i, NORMAL_MASS] * (speed + BAUMGARTE * min(s + slop, 0.0) / h), 0.0)
                point[i, PUSH] = after
                va, wa, vb, wb = push(ma, ia, ra, mb, ib, rb, scale(after - before, n), va, wa, vb, wb)
            store3(pseudo, a, V, va)
            store3(pseudo, a, W, wa)
            store3(pseudo, b, V, vb)
            store3(pseudo, b, W, wb)
    for b in range(bodies):
        if kind[b, MOTION] == DYNAMIC:
            store3(state, b, P, axpy(h, load3(pseudo, b, V), load3(state, b, P)))
            store4(state, b, Q, quat_turn(load4(state, b, Q), load3(pseudo, b, W), h))
            turn_inertia(state, body, turned, b)
    return True
