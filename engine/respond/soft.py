"""Sub-stepped, soft, warm-started sequential impulses with a circular friction cone.

In each sub-step h: kick; warm start; sweeps with the soft position error; drift; sweeps without it (relax); restitution.
A contact is a spring-damper of `hertz` and `damping_ratio` taken implicitly:

    a1 = 2 zeta + h omega,  a2 = h omega a1,  a3 = 1 / (1 + a2),
    bias rate = omega / a1,  mass scale = a2 a3,  impulse scale = a3

Friction is one vector per point in the tangent plane, projected onto the disc of radius mu times the present normal impulse; no
direction is preferred. While a manifold sticks the disc has mu_static, once its whole disc is used up it slips under
mu_kinetic.

All points of a manifold see one relative motion of its two bodies, six numbers: V of B against A at the manifold's centre and
W = w_B - w_A, in its frame (t1, t2, n). A sweep takes these six into registers, works through the points on them alone, by
(V, W) += M (force, moment) after each impulse, and gives the sum to the bodies:

    normal velocity at (x, y)        V3 + y W1 - x W2
    tangential velocity at (x, y)    V1 - y W3, V2 + x W3

M, six by six, is taken at the start of the step, as are the effective masses; the velocities themselves are always exact.

Source: Catto, Solver2D, 2024 (TGS Soft); Catto, Soft Constraints, GDC 2011; Jean, Comput. Methods Appl. Mech. Eng. 177, 1999
(cone); Featherstone, Rigid Body Dynamics Algorithms, 2008, section 2.4 (motion and force as six-vectors).
"""

import math

from engine.compile.jit import kernel
from engine.maths.vec import (
    Floats,
    Ints,
    Mat,
    Sym,
    Vec,
    add,
    axpy,
    cross,
    dot,
    load3,
    load4,
    load6,
    load9,
    mat_vec,
    norm,
    perpendicular,
    quat_mat,
    scale,
    store3,
    store6,
    store9,
    sub,
    sym_rotate,
    sym_vec,
    tmat_vec,
)  # fmt: skip
from engine.memory.arena import (
    APPROACH,
    ARM_A,
    ARM_B,
    BODY_A,
    BODY_B,
    CAPSULE,
    CENTRE_A,
    CENTRE_B,
    COUPLING,
    CYLINDER,
    DYNAMIC,
    FIRST_GAP,
    GRAVITY,
    HELD,
    INV_MASS,
    LAW,
    LEADS,
    MOTION,
    NORMAL,
    NORMAL_BLOCK,
    NORMAL_IMPULSE,
    NORMAL_MASS,
    PLACE,
    POINT_SHARE,
    POINTS,
    RIM_AXIS_A,
    RIM_AXIS_B,
    RIMS,
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
    SPREAD,
    STOP_BLOCK,
    STOP_TURN,
    STRIKES,
    STRUCK,
    SUM,
    TANGENT_BLOCK,
    TANGENT_IMPULSE,
    TANGENT_MASS,
    TANGENTS,
    TYPE,
    P,
    Q,
    V,
    W,
)  # fmt: skip

__all__ = [
    "approach", "bounce", "end_step", "end_substep", "friction_mode", "prepare", "refresh", "sum_impulses", "sweep",
    "warm_start",
]  # fmt: skip

THIN = 1e-6
"""Squared spread of the points over the squared arm at which they would move the bodies as much by turning as by shifting [1],
below which they count as one."""
UPRIGHT = 1e-3
"""Sine of a cylinder's tilt [1] below which it stands, and no point of its rim is the lowest; as in the narrow phase."""
ON_RIM = 1e-6
"""Share of its radius [1] by which a point may be off the lowest line of a cylinder."""
TOUCHING = 1e-9
"""Share of a sub-step's way [1] by which rounding may put a gap beyond its end."""

STUCK = 0.999999
"""Share of the static disc from which a manifold counts as slipping."""


@kernel
def frame_of(manifold: Floats, m: int) -> Mat:
    """The rotation from W to the frame of manifold m, rows t1, t2, n."""
    t1, t2, n = load3(manifold, m, TANGENTS), load3(manifold, m, TANGENTS + 3), load3(manifold, m, NORMAL)
    return t1[0], t1[1], t1[2], t2[0], t2[1], t2[2], n[0], n[1], n[2]


@kernel
def mobility(frame: Mat, mass: float, inertia: Sym, c: Vec) -> tuple[Sym, Mat, Sym]:
    """What force and moment at the arm c [m] in W do to one body's motion there, per unit of impulse, in the frame.

    Args: mass [1/kg] and inertia [1/(kg m2)], in W, of the body, both inverse.
    Returns: velocity by force, velocity by moment (rows: velocity), angular velocity by moment.
    """
    g = sym_rotate(frame, inertia)
    c = mat_vec(frame, c)
    by_1, by_2, by_3 = cross((g[0], g[3], g[4]), c), cross((g[3], g[1], g[5]), c), cross((g[4], g[5], g[2]), c)
    x = cross((by_1[0], by_2[0], by_3[0]), c)
    y = cross((by_1[1], by_2[1], by_3[1]), c)
    z = cross((by_1[2], by_2[2], by_3[2]), c)
    turned: Mat = (by_1[0], by_2[0], by_3[0], by_1[1], by_2[1], by_3[1], by_1[2], by_2[2], by_3[2])
    return (mass + x[0], mass + y[1], mass + z[2], x[1], x[2], y[2]), turned, g


@kernel
def write_blocks(manifold: Floats, m: int, frame: Mat, ma: float, ia: Sym, ca: Vec, mb: float, ib: Sym, cb: Vec) -> None:
    """The three blocks of M: on (V3, W1, W2) and on (V1, V2, W3) of their own forces, and the rest, rows V1, V2, W3."""
    fa, ta, ga = mobility(frame, ma, ia, ca)
    fb, tb, gb = mobility(frame, mb, ib, cb)
    store6(
        manifold, m, NORMAL_BLOCK,
        (fa[2] + fb[2], ga[0] + gb[0], ga[1] + gb[1], ta[6] + tb[6], ta[7] + tb[7], ga[3] + gb[3]),
    )  # fmt: skip
    store6(
        manifold, m, TANGENT_BLOCK,
        (fa[0] + fb[0], fa[1] + fb[1], ga[2] + gb[2], fa[3] + fb[3], ta[2] + tb[2], ta[5] + tb[5]),
    )  # fmt: skip
    store9(
        manifold, m, COUPLING,
        (
            fa[4] + fb[4], ta[0] + tb[0], ta[1] + tb[1],
            fa[5] + fb[5], ta[3] + tb[3], ta[4] + tb[4],
            ta[8] + tb[8], ga[4] + gb[4], ga[5] + gb[5],
        ),
    )  # fmt: skip


@kernel
def effective_masses(normals: Sym, tangents: Sym, x: float, y: float) -> tuple[float, float]:
    """1 / the response to a normal impulse at (x, y), and 1 / the largest to a tangential one."""
    nn = normals[0] + y * (2.0 * normals[3] + y * normals[1] - 2.0 * x * normals[5]) + x * (x * normals[2] - 2.0 * normals[4])
    one = tangents[0] + y * (y * tangents[2] - 2.0 * tangents[4])
    two = tangents[1] + x * (x * tangents[2] + 2.0 * tangents[5])
    both = tangents[3] + x * tangents[4] - y * tangents[5] - x * y * tangents[2]
    half = 0.5 * (one - two)
    return 1.0 / nn, 1.0 / (0.5 * (one + two) + math.sqrt(half * half + both * both))


@kernel
def write_stop(manifold: Floats, m: int, key: Ints, point: Floats) -> None:
    """The inverse of the block on (V1, V2, W3), where the points can give a moment; else of that on (V1, V2)."""
    t = load6(manifold, m, TANGENT_BLOCK)
    square = 0.0
    for i in range(4 * m, 4 * m + key[m, POINTS]):
        square += point[i, SPREAD] * point[i, SPREAD] + point[i, SPREAD + 1] * point[i, SPREAD + 1]
    spans = square * t[2] > THIN * (t[0] + t[1])
    if not spans:
        t = (t[0], t[1], 1.0, t[3], 0.0, 0.0)
    stop: Sym = (
        t[1] * t[2] - t[5] * t[5],
        t[0] * t[2] - t[4] * t[4],
        t[0] * t[1] - t[3] * t[3],
        t[4] * t[5] - t[3] * t[2],
        t[3] * t[5] - t[4] * t[1],
        t[3] * t[4] - t[0] * t[5],
    )
    one = 1.0 / (t[0] * stop[0] + t[3] * stop[3] + t[4] * stop[4])
    store6(manifold, m, STOP_BLOCK, (one * stop[0], one * stop[1], one * stop[2], one * stop[3], one * stop[4], one * stop[5]))
    manifold[m, STOP_TURN] = 1.0 / square if spans else 0.0


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
def lowest_of(axis: Vec, n: Vec) -> Vec:
    """The unit vector from a cylinder's axis to what lies furthest along n; (0, 0, 0) where the rim is level."""
    fall = axpy(-dot(n, axis), axis, n)
    sine = norm(fall)
    return scale(1.0 / sine, fall) if sine > UPRIGHT else (0.0, 0.0, 0.0)


@kernel
def rim_of(shape: Floats, shape_kind: Ints, pose: Floats, s: int, n: Vec) -> tuple[float, Vec, Vec, Vec]:
    """Radius [m], centre, axis and lowest direction along n of a cylinder in W; radius 0 where there is no rim to roll on."""
    if shape_kind[s, TYPE] != CYLINDER:
        return 0.0, n, n, n
    axis = (pose[s, 5], pose[s, 8], pose[s, 11])
    lowest = lowest_of(axis, n)
    return (shape[s, SIZE] if dot(lowest, lowest) > 0.5 else 0.0), load3(pose, s, 0), axis, lowest


@kernel
def rolls_on(size: float, centre: Vec, axis: Vec, lowest: Vec, place: Vec) -> bool:
    """Whether a place on a cylinder is the lowest of its rim, or of its side."""
    way = sub(place, centre)
    off = axpy(-size, lowest, axpy(-dot(way, axis), axis, way))
    return size > 0.0 and dot(off, off) < (ON_RIM * size) ** 2


@kernel
def prepare(
    state: Floats, body: Floats, turned: Floats, shape: Floats, shape_kind: Ints, pose: Floats, m: int,
    manifold: Floats, key: Ints, point: Floats,
) -> None:  # fmt: skip
    """Frame, arms, material points and effective masses of manifold m at the start of a step."""
    a, b = key[m, BODY_A], key[m, BODY_B]
    n = load3(manifold, m, NORMAL)
    t1 = perpendicular(n)
    store3(manifold, m, TANGENTS, t1)
    store3(manifold, m, TANGENTS + 3, cross(n, t1))
    frame = frame_of(manifold, m)
    ma, mb = body[a, INV_MASS], body[b, INV_MASS]
    ia, ib = load6(turned, a, 0), load6(turned, b, 0)
    pa, pb = load3(state, a, P), load3(state, b, P)
    ra_wb, rb_wb = quat_mat(load4(state, a, Q)), quat_mat(load4(state, b, Q))
    round_a = radius(shape, shape_kind, pose, key[m, SHAPE_A], n)
    round_b = radius(shape, shape_kind, pose, key[m, SHAPE_B], n)
    size_a, centre_a, axis_a, low_a = rim_of(shape, shape_kind, pose, key[m, SHAPE_A], n)
    size_b, centre_b, axis_b, low_b = rim_of(shape, shape_kind, pose, key[m, SHAPE_B], scale(-1.0, n))
    manifold[m, RIMS] = 0.0
    for k in range(key[m, POINTS]):
        i = 4 * m + k
        place, gap = load3(point, i, PLACE), point[i, FIRST_GAP]
        store3(point, i, ARM_A, sub(place, pa))
        store3(point, i, ARM_B, sub(place, pb))
        on_a, on_b = axpy(-0.5 * gap, n, place), axpy(0.5 * gap, n, place)
        if rolls_on(size_a, centre_a, axis_a, low_a, on_a):
            manifold[m, RIMS], point[i, ROUND_A] = 1.0, -size_a
            on_a = axpy(-size_a, low_a, on_a)
        else:
            point[i, ROUND_A] = round_a
            on_a = axpy(-round_a, n, on_a)
        if rolls_on(size_b, centre_b, axis_b, low_b, on_b):
            manifold[m, RIMS], point[i, ROUND_B] = 1.0, -size_b
            on_b = axpy(-size_b, low_b, on_b)
        else:
            point[i, ROUND_B] = round_b
            on_b = axpy(round_b, n, on_b)
        store3(point, i, SPOT_A, tmat_vec(ra_wb, sub(on_a, pa)))
        store3(point, i, SPOT_B, tmat_vec(rb_wb, sub(on_b, pb)))
        point[i, SEPARATION] = gap
        held = mat_vec(frame, load3(point, i, TANGENT_IMPULSE))
        point[i, HELD], point[i, HELD + 1] = held[0], held[1]
    if manifold[m, RIMS] == 1.0:
        store3(manifold, m, RIM_AXIS_A, tmat_vec(ra_wb, axis_a))
        store3(manifold, m, RIM_AXIS_B, tmat_vec(rb_wb, axis_b))
    manifold[m, POINT_SHARE] = 1.0 / key[m, POINTS]
    spread(m, sub(pb, pa), manifold, key, point)
    write_blocks(manifold, m, frame, ma, ia, load3(manifold, m, CENTRE_A), mb, ib, load3(manifold, m, CENTRE_B))
    normals, tangents = load6(manifold, m, NORMAL_BLOCK), load6(manifold, m, TANGENT_BLOCK)
    for i in range(4 * m, 4 * m + key[m, POINTS]):
        point[i, NORMAL_MASS], point[i, TANGENT_MASS] = effective_masses(
            normals, tangents, point[i, SPREAD], point[i, SPREAD + 1]
        )
    write_stop(manifold, m, key, point)
    if manifold[m, LAW + 3] > 0.0 or manifold[m, LAW + 4] > 0.0:
        manifold[m, SPIN_MASS] = 1.0 / max(normals[1] + normals[2], 1e-300)
        manifold[m, SPIN_MASS + 1] = 1.0 / max(tangents[2], 1e-300)


@kernel
def spread(m: int, way: Vec, manifold: Floats, key: Ints, point: Floats) -> None:
    """The centre of a manifold, amid its points and in the tangent plane of the deepest, and the points' places about it.

    The deepest corner is the one furthest along the normal where the corners are those of A, least far where they are B's.

    Args: way [m] from A to B, in W.
    """
    n, t1, t2 = load3(manifold, m, NORMAL), load3(manifold, m, TANGENTS), load3(manifold, m, TANGENTS + 3)
    first, points = 4 * m, key[m, POINTS]
    way_in = 1.0 - 2.0 * key[m, LEADS]
    total, deepest = (0.0, 0.0, 0.0), -math.inf
    for i in range(first, first + points):
        arm = load3(point, i, ARM_A)
        total = add(total, arm)
        deepest = max(deepest, way_in * dot(n, arm))
    middle = scale(manifold[m, POINT_SHARE], total)
    centre = axpy(way_in * deepest - dot(n, middle), n, middle)
    store3(manifold, m, CENTRE_A, centre)
    store3(manifold, m, CENTRE_B, sub(centre, way))
    for i in range(first, first + points):
        d = sub(load3(point, i, ARM_A), centre)
        point[i, SPREAD], point[i, SPREAD + 1] = dot(t1, d), dot(t2, d)


@kernel
def refresh(state: Floats, first: int, end: int, manifold: Floats, key: Ints, point: Floats) -> None:
    """Arms and separations of the points of manifolds first..end - 1 at the present poses.

    A point goes with the corner or the round surface that makes it, while the other body slides under it; on the rim of a
    tilted cylinder it rolls on, or a disc on its edge would lose its tilt, in proportion to the time step. Both arms lead to
    one place, which keeps angular momentum.
    """
    for m in range(first, end):
        a, b = key[m, BODY_A], key[m, BODY_B]
        n = load3(manifold, m, NORMAL)
        pa, pb = load3(state, a, P), load3(state, b, P)
        ra_wb, rb_wb = quat_mat(load4(state, a, Q)), quat_mat(load4(state, b, Q))
        way = sub(pb, pa)
        low_a, low_b = n, n
        if manifold[m, RIMS] == 1.0:
            low_a = lowest_of(mat_vec(ra_wb, load3(manifold, m, RIM_AXIS_A)), n)
            low_b = lowest_of(mat_vec(rb_wb, load3(manifold, m, RIM_AXIS_B)), scale(-1.0, n))
        for k in range(key[m, POINTS]):
            i = 4 * m + k
            ra, rb = mat_vec(ra_wb, load3(point, i, SPOT_A)), mat_vec(rb_wb, load3(point, i, SPOT_B))
            round_a, round_b = point[i, ROUND_A], point[i, ROUND_B]
            ra = axpy(round_a, n, ra) if round_a >= 0.0 else axpy(-round_a, low_a, ra)
            rb = axpy(-round_b, n, rb) if round_b >= 0.0 else axpy(-round_b, low_b, rb)
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
        spread(m, way, manifold, key, point)


@kernel
def relative_motion(frame: Mat, ca: Vec, cb: Vec, va: Vec, wa: Vec, vb: Vec, wb: Vec) -> tuple[Vec, Vec]:
    """(V, W) of B against A at the centre, in the frame."""
    return (
        mat_vec(frame, sub(add(vb, cross(wb, cb)), add(va, cross(wa, ca)))),
        mat_vec(frame, sub(wb, wa)),
    )


@kernel
def push(
    state: Floats, a: int, b: int, ma: float, ia: Sym, mb: float, ib: Sym, frame: Mat, ca: Vec, cb: Vec, va: Vec, wa: Vec,
    vb: Vec, wb: Vec, force: Vec, moment: Vec,
) -> None:  # fmt: skip
    """Give the impulses of force [N s] and moment [N m s] at the centre, in the frame, to B, and their reaction to A."""
    f, t = tmat_vec(frame, force), tmat_vec(frame, moment)
    store3(state, a, V, axpy(-ma, f, va))
    store3(state, a, W, sub(wa, sym_vec(ia, add(cross(ca, f), t))))
    store3(state, b, V, axpy(mb, f, vb))
    store3(state, b, W, add(wb, sym_vec(ib, add(cross(cb, f), t))))


@kernel
def warm_start(state: Floats, body: Floats, turned: Floats, manifolds: int, manifold: Floats, key: Ints, point: Floats) -> None:
    """Apply the impulses of the last sub-step."""
    for m in range(manifolds):
        a, b = key[m, BODY_A], key[m, BODY_B]
        frame = frame_of(manifold, m)
        moment = mat_vec(frame, load3(manifold, m, SPIN_IMPULSE))
        f1, f2, f3, m1, m2, m3 = 0.0, 0.0, 0.0, moment[0], moment[1], moment[2]
        for i in range(4 * m, 4 * m + key[m, POINTS]):
            x, y, normal, one, two = (
                point[i, SPREAD], point[i, SPREAD + 1], point[i, NORMAL_IMPULSE], point[i, HELD], point[i, HELD + 1]
            )  # fmt: skip
            f1, f2, f3 = f1 + one, f2 + two, f3 + normal
            m1, m2, m3 = m1 + y * normal, m2 - x * normal, m3 + x * two - y * one
        push(
            state, a, b, body[a, INV_MASS], load6(turned, a, 0), body[b, INV_MASS], load6(turned, b, 0), frame,
            load3(manifold, m, CENTRE_A), load3(manifold, m, CENTRE_B), load3(state, a, V), load3(state, a, W),
            load3(state, b, V), load3(state, b, W), (f1, f2, f3), (m1, m2, m3),
        )  # fmt: skip


@kernel
def approach(
    state: Floats, kind: Ints, setting: Floats, manifolds: int, manifold: Floats, key: Ints, point: Floats, h: float,
    slow: float,
) -> int:  # fmt: skip
    """Note the points that are about to strike in this sub-step, with their normal velocity at the moment of impact [m/s].

    With separation s and normal velocity u < 0 after the kick a h, the impact comes after the share tau = s / (-u h) of the
    sub-step, when the velocity is u - (1 - tau) a h. Impulses of earlier sub-steps are no guess for a blow and are dropped. A
    gap that is the way of the sub-step to rounding is one that closes in it.

    Returns: how many points strike.
    """
    strikes = 0
    g = load3(setting, 0, GRAVITY)
    for m in range(manifolds):
        a, b = key[m, BODY_A], key[m, BODY_B]
        frame = frame_of(manifold, m)
        v, w = relative_motion(
            frame, load3(manifold, m, CENTRE_A), load3(manifold, m, CENTRE_B), load3(state, a, V), load3(state, a, W),
            load3(state, b, V), load3(state, b, W),
        )  # fmt: skip
        kick = h * dot(load3(manifold, m, NORMAL), g)
        kick *= (1.0 if kind[b, MOTION] == DYNAMIC else 0.0) - (1.0 if kind[a, MOTION] == DYNAMIC else 0.0)
        if key[m, STRIKES] == 1:
            key[m, STRIKES] = 0
            for i in range(4 * m, 4 * m + key[m, POINTS]):
                point[i, STRUCK] = 0.0
        for i in range(4 * m, 4 * m + key[m, POINTS]):
            u = v[2] + w[0] * point[i, SPREAD + 1] - w[1] * point[i, SPREAD]
            if u < -slow and point[i, SEPARATION] < -u * h * (1.0 + TOUCHING):
                share = min(max(point[i, SEPARATION] / (-u * h), 0.0), 1.0)
                strikes += 1
                key[m, STRIKES] = 1
                point[i, STRUCK] = 1.0
                point[i, SPIKE] = 0.0
                point[i, APPROACH] = min(u - (1.0 - share) * kick, 0.0)
                point[i, NORMAL_IMPULSE], point[i, HELD], point[i, HELD + 1] = 0.0, 0.0, 0.0
                store3(point, i, TANGENT_IMPULSE, (0.0, 0.0, 0.0))
    return strikes


@kernel
def resist_spin(manifold: Floats, m: int, frame: Mat, w: Vec, total: float) -> Vec:
    """Rolling and torsional friction under the normal impulse `total` [N s]: the change of their moment, in the frame."""
    before = mat_vec(frame, load3(manifold, m, SPIN_IMPULSE))
    rolling, torsional = manifold[m, LAW + 3] * total, manifold[m, LAW + 4] * total
    one, two = before[0] - manifold[m, SPIN_MASS] * w[0], before[1] - manifold[m, SPIN_MASS] * w[1]
    size = math.sqrt(one * one + two * two)
    if size > rolling:
        one, two = one * (rolling / size), two * (rolling / size)
    after = (one, two, min(max(before[2] - manifold[m, SPIN_MASS + 1] * w[2], -torsional), torsional))
    store3(manifold, m, SPIN_IMPULSE, tmat_vec(frame, after))
    return sub(after, before)


@kernel
def stick(manifold: Floats, m: int, slide: Vec, friction: float, first: int, end: int, point: Floats) -> Vec:
    """Stop the tangential motion (V1, V2, W3) of a manifold by impulses spread over its points first..end - 1, as a pair.

    Returns: force and moment, given to the points; or inf, and nothing given, where a point would leave its disc.
    """
    stop = sym_vec(load6(manifold, m, STOP_BLOCK), slide)
    share = manifold[m, POINT_SHARE]
    f1, f2, turn = -share * stop[0], -share * stop[1], -stop[2] * manifold[m, STOP_TURN]
    inside, square = True, 0.0
    for i in range(first, end):
        x, y, most = point[i, SPREAD], point[i, SPREAD + 1], friction * point[i, NORMAL_IMPULSE]
        one, two = point[i, HELD] + f1 - y * turn, point[i, HELD + 1] + f2 + x * turn
        inside = inside and one * one + two * two <= most * most
        square += x * x + y * y
    if not inside:
        return math.inf, 0.0, 0.0
    for i in range(first, end):
        point[i, HELD] += f1 - point[i, SPREAD + 1] * turn
        point[i, HELD + 1] += f2 + point[i, SPREAD] * turn
    return -stop[0], -stop[1], turn * square


@kernel
def rub(tangents: Sym, slide: Vec, friction: float, first: int, end: int, point: Floats) -> Vec:
    """Friction at the points first..end - 1 one by one, each within its disc. Returns: the force and moment that they give."""
    f1, f2, m3 = 0.0, 0.0, 0.0
    for i in range(first, end):
        x, y, mass, most = (
            point[i, SPREAD], point[i, SPREAD + 1], point[i, TANGENT_MASS], friction * point[i, NORMAL_IMPULSE]
        )  # fmt: skip
        was_1, was_2 = point[i, HELD], point[i, HELD + 1]
        one, two = was_1 - mass * (slide[0] - y * slide[2]), was_2 - mass * (slide[1] + x * slide[2])
        square = one * one + two * two
        if square > most * most:
            share = most / math.sqrt(square)
            one, two = share * one, share * two
        point[i, HELD], point[i, HELD + 1] = one, two
        one, two = one - was_1, two - was_2
        slide = axpy(one, sym_vec(tangents, (1.0, 0.0, -y)), axpy(two, sym_vec(tangents, (0.0, 1.0, x)), slide))
        f1, f2, m3 = f1 + one, f2 + two, m3 + x * two - y * one
    return f1, f2, m3


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
        frame = frame_of(manifold, m)
        ma, mb = body[a, INV_MASS], body[b, INV_MASS]
        ia, ib = load6(turned, a, 0), load6(turned, b, 0)
        va, wa, vb, wb = load3(state, a, V), load3(state, a, W), load3(state, b, V), load3(state, b, W)
        ca, cb = load3(manifold, m, CENTRE_A), load3(manifold, m, CENTRE_B)
        v, w = relative_motion(frame, ca, cb, va, wa, vb, wb)
        normals, tangents, coupling = (
            load6(manifold, m, NORMAL_BLOCK), load6(manifold, m, TANGENT_BLOCK), load9(manifold, m, COUPLING)
        )  # fmt: skip
        first, end = 4 * m, 4 * m + key[m, POINTS]
        lift: Vec = (v[2], w[0], w[1])
        slide: Vec = (v[0], v[1], w[2])
        pressed, rubbed = (0.0, 0.0, 0.0), (0.0, 0.0, 0.0)
        if manifold[m, LAW + 3] > 0.0 or manifold[m, LAW + 4] > 0.0:
            total = 0.0
            for i in range(first, end):
                total += point[i, NORMAL_IMPULSE]
            moment = resist_spin(manifold, m, frame, w, total)
            pressed, rubbed = (0.0, moment[0], moment[1]), (0.0, 0.0, moment[2])
            lift = add(add(lift, sym_vec(normals, pressed)), tmat_vec(coupling, rubbed))
            slide = add(add(slide, sym_vec(tangents, rubbed)), mat_vec(coupling, pressed))
        friction = manifold[m, LAW] if key[m, SLIPS] == 0 else manifold[m, LAW + 1]
        for part in range(2):
            if (part == 0) != (soft == 1):
                f, m1, m2 = 0.0, 0.0, 0.0
                for i in range(first, end):
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
                    x, y, mass = point[i, SPREAD], point[i, SPREAD + 1], hard * point[i, NORMAL_MASS]
                    u = lift[0] + y * lift[1] - x * lift[2]
                    impulse = max(((1.0 - keep) * before - mass * bias) - mass * u, 0.0)
                    point[i, NORMAL_IMPULSE] = impulse
                    if key[m, STRIKES] == 1:
                        point[i, SPIKE] = max(point[i, SPIKE], impulse)
                    change = impulse - before
                    lift = axpy(change, sym_vec(normals, (1.0, y, -x)), lift)
                    f, m1, m2 = f + change, m1 + y * change, m2 - x * change
                pressed = add(pressed, (f, m1, m2))
                slide = add(slide, mat_vec(coupling, (f, m1, m2)))
            elif friction > 0.0:
                f1, f2, m3 = stick(manifold, m, slide, friction, first, end, point)
                if f1 == math.inf:
                    f1, f2, m3 = rub(tangents, slide, friction, first, end, point)
                rubbed = add(rubbed, (f1, f2, m3))
                lift = add(lift, tmat_vec(coupling, (f1, f2, m3)))
        push(
            state, a, b, ma, ia, mb, ib, frame, ca, cb, va, wa, vb, wb, (rubbed[0], rubbed[1], pressed[0]),
            (pressed[1], pressed[2], rubbed[2]),
        )  # fmt: skip


@kernel
def bounce(manifolds: int, manifold: Floats, key: Ints, point: Floats) -> bool:
    """Whether any point struck a surface with restitution in this sub-step."""
    for m in range(manifolds):
        if key[m, STRIKES] == 1 and manifold[m, LAW + 2] > 0.0:
            for i in range(4 * m, 4 * m + key[m, POINTS]):
                if point[i, STRUCK] == 1.0 and point[i, SPIKE] > 0.0:
                    return True
    return False


@kernel
def friction_mode(state: Floats, body: Floats, manifolds: int, manifold: Floats, key: Ints, point: Floats) -> None:
    """Sticking manifolds that use up their static disc start to slip; slipping ones that it can stop stick."""
    for m in range(manifolds):
        static = manifold[m, LAW]
        if static == manifold[m, LAW + 1]:
            continue
        a, b = key[m, BODY_A], key[m, BODY_B]
        v, w = relative_motion(
            frame_of(manifold, m), load3(manifold, m, CENTRE_A), load3(manifold, m, CENTRE_B), load3(state, a, V),
            load3(state, a, W), load3(state, b, V), load3(state, b, W),
        )  # fmt: skip
        used, needed, room = 0.0, 0.0, 0.0
        share = 1.0 / (max(body[a, INV_MASS] + body[b, INV_MASS], 1e-300) * max(key[m, POINTS], 1))
        for i in range(4 * m, 4 * m + key[m, POINTS]):
            one, two = point[i, HELD], point[i, HELD + 1]
            used += math.sqrt(one * one + two * two)
            one -= share * (v[0] - point[i, SPREAD + 1] * w[2])
            two -= share * (v[1] + point[i, SPREAD] * w[2])
            needed += math.sqrt(one * one + two * two)
            room += static * point[i, NORMAL_IMPULSE]
        if room > 0.0:
            key[m, SLIPS] = int(used >= STUCK * room) if key[m, SLIPS] == 0 else int(needed >= STUCK * room)


@kernel
def end_substep(manifolds: int, key: Ints, point: Floats) -> None:
    """Add the sub-step's impulses to the step's, in the frames, and drop those of a blow, which do not last."""
    for m in range(manifolds):
        for i in range(4 * m, 4 * m + key[m, POINTS]):
            point[i, SUM] += point[i, HELD]
            point[i, SUM + 1] += point[i, HELD + 1]
            point[i, SUM + 2] += point[i, NORMAL_IMPULSE]
            if point[i, STRUCK] == 1.0:
                point[i, NORMAL_IMPULSE], point[i, HELD], point[i, HELD + 1] = 0.0, 0.0, 0.0


@kernel
def end_step(manifolds: int, manifold: Floats, key: Ints, point: Floats) -> None:
    """Turn the sum of the step's impulses, and the friction that the next step starts from, into W."""
    for m in range(manifolds):
        frame = frame_of(manifold, m)
        for i in range(4 * m, 4 * m + key[m, POINTS]):
            store3(point, i, SUM, tmat_vec(frame, load3(point, i, SUM)))
            store3(point, i, TANGENT_IMPULSE, tmat_vec(frame, (point[i, HELD], point[i, HELD + 1], 0.0)))


@kernel
def sum_impulses(manifolds: int, manifold: Floats, key: Ints, point: Floats) -> None:
    """As `end_substep`, where friction impulses are kept in W all along."""
    for m in range(manifolds):
        n = load3(manifold, m, NORMAL)
        for i in range(4 * m, 4 * m + key[m, POINTS]):
            tangent = load3(point, i, TANGENT_IMPULSE)
            store3(point, i, SUM, add(load3(point, i, SUM), axpy(point[i, NORMAL_IMPULSE], n, tangent)))
            if point[i, STRUCK] == 1.0:
                point[i, NORMAL_IMPULSE] = 0.0
                store3(point, i, TANGENT_IMPULSE, (0.0, 0.0, 0.0))
