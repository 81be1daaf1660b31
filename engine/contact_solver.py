"""Sub-stepped, soft, warm-started sequential impulses with a circular friction cone.

In each sub-step h: kick; warm start; sweeps with the soft position error; drift; sweeps without it (relax); restitution.
A contact is a spring-damper of `hertz` and `damping_ratio` taken implicitly:

    a1 = 2 zeta + h omega,  a2 = h omega a1,  a3 = 1 / (1 + a2),
    bias rate = omega / a1,  mass scale = a2 a3,  impulse scale = a3

Friction is one vector per point in the tangent plane, projected onto the disc of radius mu times the present normal impulse; no
direction is preferred. While a manifold sticks the disc has mu_static, once its whole disc is used up it slips under
mu_kinetic.

Source: Catto, Solver2D, 2024 (TGS Soft); Catto, Soft Constraints, GDC 2011; Jean, Comput. Methods Appl. Mech. Eng. 177, 1999
(cone).
"""

import math

from engine.arena import (
    APPROACH,
    ARM_A,
    ARM_B,
    BODY_A,
    BODY_B,
    CAPSULE,
    CYLINDER,
    DYNAMIC,
    FIRST_GAP,
    GRAVITY,
    INV_MASS,
    LAW,
    LEADS,
    MOTION,
    NORMAL,
    NORMAL_IMPULSE,
    NORMAL_MASS,
    PLACE,
    POINTS,
    ROUND_A,
    ROUND_B,
    SEPARATION,
    SHAPE_A,
    SHAPE_B,
    SIZE,
    SLIPS,
    SPHERE,
    SPIKE,
    SPIN_IMPULSE,
    SPIN_MASS,
    SPOT_A,
    SPOT_B,
    STRUCK,
    SUM,
    TANGENT_IMPULSE,
    TANGENT_MASS,
    TYPE,
    P,
    Q,
    V,
    W,
)  # fmt: skip
from engine.jit import kernel
from engine.vec import (
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
    mat_vec,
    norm,
    quat_mat,
    scale,
    store3,
    sub,
    sym_vec,
    tmat_vec,
)  # fmt: skip

__all__ = ["approach", "bounce", "friction_mode", "prepare", "refresh", "sum_impulses", "sweep", "warm_start"]

STUCK = 0.999999
"""Share of the static disc from which a manifold counts as slipping."""


@kernel
def effective_masses(ma: float, ia: Sym, ra: Vec, mb: float, ib: Sym, rb: Vec, n: Vec) -> tuple[float, float]:
    """1 / (n . K n) and 1 / (largest tangential eigenvalue of K), K = the inverse effective mass matrix at a point."""
    x, y, z = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)
    m = ma + mb
    kx = add(cross(sym_vec(ia, cross(ra, x)), ra), cross(sym_vec(ib, cross(rb, x)), rb))
    ky = add(cross(sym_vec(ia, cross(ra, y)), ra), cross(sym_vec(ib, cross(rb, y)), rb))
    kz = add(cross(sym_vec(ia, cross(ra, z)), ra), cross(sym_vec(ib, cross(rb, z)), rb))
    xx, yy, zz, xy, xz, yz = m + kx[0], m + ky[1], m + kz[2], kx[1], kx[2], ky[2]
    k: Sym = (xx, yy, zz, xy, xz, yz)
    nn = dot(n, sym_vec(k, n))
    adjugate: Sym = (
        yy * zz - yz * yz,
        xx * zz - xz * xz,
        xx * yy - xy * xy,
        xz * yz - xy * zz,
        xy * yz - xz * yy,
        xy * xz - xx * yz,
    )
    trace = xx + yy + zz - nn
    determinant = dot(n, sym_vec(adjugate, n))
    largest = 0.5 * trace + math.sqrt(max(0.25 * trace * trace - determinant, 0.0))
    return 1.0 / nn, 1.0 / largest


@kernel
def radius(shape: Floats, shape_kind: Ints, pose: Floats, s: int, n: Vec) -> float:
    """The radius [m] along the normal n that does not turn with a round shape; 0 for boxes and planes."""
    if shape_kind[s, TYPE] == SPHERE or shape_kind[s, TYPE] == CAPSULE:
        return float(shape[s, SIZE])
    if shape_kind[s, TYPE] == CYLINDER:
        along = n[0] * pose[s, 5] + n[1] * pose[s, 8] + n[2] * pose[s, 11]
        return float(shape[s, SIZE] * math.sqrt(max(1.0 - along * along, 0.0)))
    return 0.0


@kernel
def prepare(
    state: Floats, body: Floats, turned: Floats, shape: Floats, shape_kind: Ints, pose: Floats, manifolds: int,
    manifold: Floats, key: Ints, point: Floats,
) -> None:  # fmt: skip
    """Arms, material points and effective masses of every contact point at the start of the step."""
    for m in range(manifolds):
        a, b = key[m, BODY_A], key[m, BODY_B]
        n = load3(manifold, m, NORMAL)
        ma, mb = body[a, INV_MASS], body[b, INV_MASS]
        ia, ib = load6(turned, a, 0), load6(turned, b, 0)
        pa, pb = load3(state, a, P), load3(state, b, P)
        ra_wb, rb_wb = quat_mat(load4(state, a, Q)), quat_mat(load4(state, b, Q))
        round_a = radius(shape, shape_kind, pose, key[m, SHAPE_A], n)
        round_b = radius(shape, shape_kind, pose, key[m, SHAPE_B], n)
        for k in range(key[m, POINTS]):
            i = 4 * m + k
            place, gap = load3(point, i, PLACE), point[i, FIRST_GAP]
            ra, rb = sub(place, pa), sub(place, pb)
            store3(point, i, ARM_A, ra)
            store3(point, i, ARM_B, rb)
            store3(point, i, SPOT_A, tmat_vec(ra_wb, axpy(-0.5 * gap - round_a, n, ra)))
            store3(point, i, SPOT_B, tmat_vec(rb_wb, axpy(0.5 * gap + round_b, n, rb)))
            point[i, ROUND_A], point[i, ROUND_B] = round_a, round_b
            point[i, SEPARATION] = gap
            point[i, NORMAL_MASS], point[i, TANGENT_MASS] = effective_masses(ma, ia, ra, mb, ib, rb, n)
            tangent = load3(point, i, TANGENT_IMPULSE)
            store3(point, i, TANGENT_IMPULSE, axpy(-dot(n, tangent), n, tangent))
        if manifold[m, LAW + 3] > 0.0 or manifold[m, LAW + 4] > 0.0:
            spin = ia[0] + ib[0] + ia[1] + ib[1] + ia[2] + ib[2]
            twist = dot(n, sym_vec(ia, n)) + dot(n, sym_vec(ib, n))
            manifold[m, SPIN_MASS] = 1.0 / max(spin - twist, 1e-300)
            manifold[m, SPIN_MASS + 1] = 1.0 / max(twist, 1e-300)


@kernel
def refresh(state: Floats, manifolds: int, manifold: Floats, key: Ints, point: Floats) -> None:
    """Arms and separations of every point at the present poses.

    A point goes with the corner or the round surface that makes it, while the other body slides under it. Both arms lead to one
    place, which keeps angular momentum.
    """
    for m in range(manifolds):
        a, b = key[m, BODY_A], key[m, BODY_B]
        n = load3(manifold, m, NORMAL)
        pa, pb = load3(state, a, P), load3(state, b, P)
        ra_wb, rb_wb = quat_mat(load4(state, a, Q)), quat_mat(load4(state, b, Q))
        way = sub(pb, pa)
        for k in range(key[m, POINTS]):
            i = 4 * m + k
            ra = axpy(point[i, ROUND_A], n, mat_vec(ra_wb, load3(point, i, SPOT_A)))
            rb = axpy(-point[i, ROUND_B], n, mat_vec(rb_wb, load3(point, i, SPOT_B)))
            gap = dot(n, add(way, sub(rb, ra)))
            point[i, SEPARATION] = gap
            if key[m, LEADS] == 0:
                ra = axpy(0.5 * gap, n, ra)
                rb = sub(ra, way)
            else:
                rb = axpy(-0.5 * gap, n, rb)
                ra = add(rb, way)
            store3(point, i, ARM_A, ra)
            store3(point, i, ARM_B, rb)


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
def warm_start(state: Floats, body: Floats, turned: Floats, manifolds: int, manifold: Floats, key: Ints, point: Floats) -> None:
    """Apply the impulses of the last sub-step."""
    for m in range(manifolds):
        a, b = key[m, BODY_A], key[m, BODY_B]
        n = load3(manifold, m, NORMAL)
        ma, mb = body[a, INV_MASS], body[b, INV_MASS]
        ia, ib = load6(turned, a, 0), load6(turned, b, 0)
        va, wa, vb, wb = load3(state, a, V), load3(state, a, W), load3(state, b, V), load3(state, b, W)
        for k in range(key[m, POINTS]):
            i = 4 * m + k
            impulse = axpy(point[i, NORMAL_IMPULSE], n, load3(point, i, TANGENT_IMPULSE))
            va, wa, vb, wb = push(ma, ia, load3(point, i, ARM_A), mb, ib, load3(point, i, ARM_B), impulse, va, wa, vb, wb)
        spin = load3(manifold, m, SPIN_IMPULSE)
        store3(state, a, V, va)
        store3(state, a, W, sub(wa, sym_vec(ia, spin)))
        store3(state, b, V, vb)
        store3(state, b, W, add(wb, sym_vec(ib, spin)))


@kernel
def approach(
    state: Floats,
    kind: Ints,
    setting: Floats,
    manifolds: int,
    manifold: Floats,
    key: Ints,
    point: Floats,
    h: float,
    slow: float,
) -> None:
    """Note the points that are about to strike in this sub-step, with their normal velocity at the moment of impact [m/s].

    With separation s and normal velocity u < 0 after the kick a h, the impact comes after the share tau = s / (-u h) of the
    sub-step, when the velocity is u - (1 - tau) a h. Impulses of earlier sub-steps are no guess for a blow and are dropped.
    """
    g = load3(setting, 0, GRAVITY)
    for m in range(manifolds):
        a, b = key[m, BODY_A], key[m, BODY_B]
        n = load3(manifold, m, NORMAL)
        kick = h * dot(n, g) * ((1.0 if kind[b, MOTION] == DYNAMIC else 0.0) - (1.0 if kind[a, MOTION] == DYNAMIC else 0.0))
        va, wa, vb, wb = load3(state, a, V), load3(state, a, W), load3(state, b, V), load3(state, b, W)
        for k in range(key[m, POINTS]):
            i = 4 * m + k
            ra, rb = load3(point, i, ARM_A), load3(point, i, ARM_B)
            u = dot(n, sub(add(vb, cross(wb, rb)), add(va, cross(wa, ra))))
            point[i, STRUCK] = 0.0
            if u < -slow and point[i, SEPARATION] < -u * h:
                share = min(max(point[i, SEPARATION] / (-u * h), 0.0), 1.0)
                point[i, STRUCK] = 1.0
                point[i, APPROACH] = min(u - (1.0 - share) * kick, 0.0)
                point[i, NORMAL_IMPULSE] = 0.0
                store3(point, i, TANGENT_IMPULSE, (0.0, 0.0, 0.0))


@kernel
def sweep(
    state: Floats, body: Floats, turned: Floats, manifolds: int, manifold: Floats, key: Ints, point: Floats, h: float,
    bias_rate: float, mass_scale: float, impulse_scale: float, max_push: float, soft: int, bouncing: int,
) -> None:  # fmt: skip
    """One sweep over all manifolds: rolling and torsional friction, then friction and normal.

    While the position error is corrected the normal comes last, since it matters most; in the relaxing sweeps friction does,
    so that it ends on the cone of the final normal impulse.

    Args: soft: 1 to correct the position error, 0 to relax; then points that gave no impulse stay out. bouncing: 1 to aim at
    the velocity after restitution instead.
    """
    for m in range(manifolds):
        a, b = key[m, BODY_A], key[m, BODY_B]
        n = load3(manifold, m, NORMAL)
        ma, mb = body[a, INV_MASS], body[b, INV_MASS]
        ia, ib = load6(turned, a, 0), load6(turned, b, 0)
        va, wa, vb, wb = load3(state, a, V), load3(state, a, W), load3(state, b, V), load3(state, b, W)
        points = key[m, POINTS]
        rolling, torsional = manifold[m, LAW + 3], manifold[m, LAW + 4]
        if rolling > 0.0 or torsional > 0.0:
            total = 0.0
            for k in range(points):
                total += point[4 * m + k, NORMAL_IMPULSE]
            w = sub(wb, wa)
            before = load3(manifold, m, SPIN_IMPULSE)
            twist = dot(n, before) - manifold[m, SPIN_MASS + 1] * dot(n, w)
            twist = min(max(twist, -torsional * total), torsional * total)
            roll = axpy(-manifold[m, SPIN_MASS], axpy(-dot(n, w), n, w), axpy(-dot(n, before), n, before))
            size = norm(roll)
            if size > rolling * total:
                roll = scale(rolling * total / size, roll)
            after = axpy(twist, n, roll)
            store3(manifold, m, SPIN_IMPULSE, after)
            wa = sub(wa, sym_vec(ia, sub(after, before)))
            wb = add(wb, sym_vec(ib, sub(after, before)))
        friction = manifold[m, LAW] if key[m, SLIPS] == 0 else manifold[m, LAW + 1]
        for part in range(2):
            if (part == 0) != (soft == 1):
                for k in range(points):
                    i = 4 * m + k
                    s, before = point[i, SEPARATION], point[i, NORMAL_IMPULSE]
                    bias, hard, keep = 0.0, 1.0, 0.0
                    if soft == 1:
                        if s > 0.0:
                            bias = s / h
                        else:
                            bias, hard, keep = max(bias_rate * s, -max_push), mass_scale, impulse_scale
                    elif s > 0.0 and before == 0.0:
                        continue
                    elif bouncing == 1 and point[i, STRUCK] == 1.0 and point[i, SPIKE] > 0.0:
                        bias = manifold[m, LAW + 2] * point[i, APPROACH]
                    ra, rb = load3(point, i, ARM_A), load3(point, i, ARM_B)
                    u = dot(n, sub(add(vb, cross(wb, rb)), add(va, cross(wa, ra))))
                    impulse = max(before - point[i, NORMAL_MASS] * hard * (u + bias) - keep * before, 0.0)
                    point[i, NORMAL_IMPULSE] = impulse
                    point[i, SPIKE] = max(point[i, SPIKE], impulse)
                    va, wa, vb, wb = push(ma, ia, ra, mb, ib, rb, scale(impulse - before, n), va, wa, vb, wb)
            elif friction > 0.0:
                for k in range(points):
                    i = 4 * m + k
                    ra, rb = load3(point, i, ARM_A), load3(point, i, ARM_B)
                    slip = sub(add(vb, cross(wb, rb)), add(va, cross(wa, ra)))
                    slip = axpy(-dot(n, slip), n, slip)
                    held = load3(point, i, TANGENT_IMPULSE)
                    after = axpy(-point[i, TANGENT_MASS], slip, held)
                    size, most = norm(after), friction * point[i, NORMAL_IMPULSE]
                    if size > most:
                        after = scale(most / size, after)
                    store3(point, i, TANGENT_IMPULSE, after)
                    va, wa, vb, wb = push(ma, ia, ra, mb, ib, rb, sub(after, held), va, wa, vb, wb)
        store3(state, a, V, va)
        store3(state, a, W, wa)
        store3(state, b, V, vb)
        store3(state, b, W, wb)


@kernel
def bounce(manifolds: int, manifold: Floats, key: Ints, point: Floats) -> bool:
    """Whether any point struck a surface with restitution in this sub-step."""
    for m in range(manifolds):
        if manifold[m, LAW + 2] > 0.0:
            for k in range(key[m, POINTS]):
                if point[4 * m + k, STRUCK] == 1.0 and point[4 * m + k, SPIKE] > 0.0:
                    return True
    return False


@kernel
def friction_mode(state: Floats, body: Floats, manifolds: int, manifold: Floats, key: Ints, point: Floats) -> None:
    """Sticking manifolds that use up their static disc start to slip; slipping ones that it can stop stick."""
    for m in range(manifolds):
        a, b = key[m, BODY_A], key[m, BODY_B]
        n, static = load3(manifold, m, NORMAL), manifold[m, LAW]
        used, needed, room = 0.0, 0.0, 0.0
        share = 1.0 / (max(body[a, INV_MASS] + body[b, INV_MASS], 1e-300) * max(key[m, POINTS], 1))
        for k in range(key[m, POINTS]):
            i = 4 * m + k
            slip = sub(load3(state, b, V), load3(state, a, V))
            slip = add(
                slip, sub(cross(load3(state, b, W), load3(point, i, ARM_B)), cross(load3(state, a, W), load3(point, i, ARM_A)))
            )
            held = load3(point, i, TANGENT_IMPULSE)
            used += norm(held)
            needed += norm(axpy(-share, axpy(-dot(n, slip), n, slip), held))
            room += static * point[i, NORMAL_IMPULSE]
        if room > 0.0:
            key[m, SLIPS] = int(used >= STUCK * room) if key[m, SLIPS] == 0 else int(needed >= STUCK * room)


@kernel
def sum_impulses(manifolds: int, manifold: Floats, key: Ints, point: Floats) -> None:
    """Add the sub-step's impulses to the step's, and drop those of a blow, which do not last."""
    for m in range(manifolds):
        n = load3(manifold, m, NORMAL)
        for k in range(key[m, POINTS]):
            i = 4 * m + k
            tangent = load3(point, i, TANGENT_IMPULSE)
            store3(point, i, SUM, add(load3(point, i, SUM), axpy(point[i, NORMAL_IMPULSE], n, tangent)))
            if point[i, STRUCK] == 1.0:
                point[i, NORMAL_IMPULSE] = 0.0
                store3(point, i, TANGENT_IMPULSE, (0.0, 0.0, 0.0))
            point[i, SPIKE] = 0.0
