"""A manifold at the start of a step: its frame, arms, material points and effective masses."""

from engine.compile.jit import kernel
from engine.maths.vec import axpy, cross, load3, load4, load6, mat_vec, perpendicular, quat_mat, scale, store3, sub, tmat_vec
from engine.memory.arena import (
    ARM_A,
    ARM_B,
    BODY_A,
    BODY_B,
    CENTRE_A,
    CENTRE_B,
    FIRST_GAP,
    HELD,
    LAW,
    NORMAL,
    NORMAL_BLOCK,
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
    SPIN_MASS,
    SPOT_A,
    SPOT_B,
    SPREAD,
    TANGENT_BLOCK,
    TANGENT_IMPULSE,
    TANGENT_MASS,
    TANGENTS,
    P,
    Q,
)
from engine.memory.tables import Bodies, Contacts, Shapes
from engine.respond.arms import spread
from engine.respond.centre import Centre, frame_of
from engine.respond.mobility import effective_masses, write_blocks, write_stop
from engine.respond.pair import Pair, pair_of
from engine.respond.rolling_ellipsoids import ON_ELLIPSOID, is_ellipsoid
from engine.respond.rolling_rims import radius, rim_of, rolls_on

__all__ = ["prepare", "weigh"]


@kernel
def weigh(contacts: Contacts, m: int, centre: Centre, pair: Pair) -> None:
    """Effective masses of manifold m between two bodies of the inverse masses of `pair`."""
    manifold, point, key = contacts.manifold, contacts.point, contacts.key
    write_blocks(manifold, m, centre, pair)
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
def prepare(bodies: Bodies, shapes: Shapes, contacts: Contacts, m: int) -> None:
    """Frame, arms, material points and effective masses of manifold m at the start of a step."""
    state, manifold, point, key = bodies.state, contacts.manifold, contacts.point, contacts.key
    shape, pose, shape_kind = shapes
    a, b = key[m, BODY_A], key[m, BODY_B]
    n = load3(manifold, m, NORMAL)
    t1 = perpendicular(n)
    store3(manifold, m, TANGENTS, t1)
    store3(manifold, m, TANGENTS + 3, cross(n, t1))
    frame = frame_of(manifold, m)
    pair = pair_of(bodies.body, bodies.turned, a, b)
    pa, pb = load3(state, a, P), load3(state, b, P)
    ra_wb, rb_wb = quat_mat(load4(state, a, Q)), quat_mat(load4(state, b, Q))
    round_a = radius(shape, shape_kind, pose, key[m, SHAPE_A], n)
    round_b = radius(shape, shape_kind, pose, key[m, SHAPE_B], n)
    rim_a = rim_of(shape, shape_kind, pose, key[m, SHAPE_A], n)
    rim_b = rim_of(shape, shape_kind, pose, key[m, SHAPE_B], scale(-1.0, n))
    manifold[m, RIMS] = ON_ELLIPSOID if is_ellipsoid(shape_kind, key[m, SHAPE_A], key[m, SHAPE_B]) else 0.0
    for k in range(key[m, POINTS]):
        i = 4 * m + k
        place, gap = load3(point, i, PLACE), point[i, FIRST_GAP]
        store3(point, i, ARM_A, sub(place, pa))
        store3(point, i, ARM_B, sub(place, pb))
        on_a, on_b = axpy(-0.5 * gap, n, place), axpy(0.5 * gap, n, place)
        if manifold[m, RIMS] != ON_ELLIPSOID and rolls_on(rim_a, on_a):
            manifold[m, RIMS], point[i, ROUND_A] = 1.0, -rim_a.radius
            on_a = axpy(-rim_a.radius, rim_a.lowest, on_a)
        else:
            point[i, ROUND_A] = round_a
            on_a = axpy(-round_a, n, on_a)
        if manifold[m, RIMS] != ON_ELLIPSOID and rolls_on(rim_b, on_b):
            manifold[m, RIMS], point[i, ROUND_B] = 1.0, -rim_b.radius
            on_b = axpy(-rim_b.radius, rim_b.lowest, on_b)
        else:
            point[i, ROUND_B] = round_b
            on_b = axpy(round_b, n, on_b)
        store3(point, i, SPOT_A, tmat_vec(ra_wb, sub(on_a, pa)))
        store3(point, i, SPOT_B, tmat_vec(rb_wb, sub(on_b, pb)))
        point[i, SEPARATION] = gap
        held = mat_vec(frame, load3(point, i, TANGENT_IMPULSE))
        point[i, HELD], point[i, HELD + 1] = held[0], held[1]
    if manifold[m, RIMS] == 1.0:
        store3(manifold, m, RIM_AXIS_A, tmat_vec(ra_wb, rim_a.axis))
        store3(manifold, m, RIM_AXIS_B, tmat_vec(rb_wb, rim_b.axis))
    manifold[m, POINT_SHARE] = 1.0 / key[m, POINTS]
    spread(m, sub(pb, pa), manifold, key, point)
    weigh(contacts, m, Centre(frame, load3(manifold, m, CENTRE_A), load3(manifold, m, CENTRE_B)), pair)
