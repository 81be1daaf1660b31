"""A manifold at the start of a step: its frame, arms, material points and effective masses."""

from plumbline.engine.compile.jit import kernel
from plumbline.engine.maths.rows import load3, load4, store3
from plumbline.engine.maths.vec import axpy, cross, mat_vec, perpendicular, quat_mat, scale, sub, tmat_vec
from plumbline.engine.memory import arena as at
from plumbline.engine.memory.tables import Bodies, Contacts, Shapes
from plumbline.engine.respond.arms import spread
from plumbline.engine.respond.centre import Centre, Pair, frame_of, pair_of
from plumbline.engine.respond.mobility import write_blocks, write_masses
from plumbline.engine.respond.rolling import ON_ELLIPSOID, is_ellipsoid, radius, rim_of, rolls_on


@kernel
def weigh(contacts: Contacts, m: int, centre: Centre, pair: Pair) -> None:
    """Effective masses of manifold m between two bodies of the inverse masses of `pair`."""
    write_blocks(contacts.manifold, m, centre, pair)
    write_masses(contacts, m)


@kernel
def prepare(bodies: Bodies, shapes: Shapes, contacts: Contacts, m: int) -> None:
    """Frame, arms, material points and effective masses of manifold m at the start of a step."""
    state, manifold, point, key = bodies.state, contacts.manifold, contacts.point, contacts.key
    shape, pose, shape_kind = shapes
    a, b = key[m, at.BODY_A], key[m, at.BODY_B]
    n = load3(manifold, m, at.NORMAL)
    t1 = perpendicular(n)
    store3(manifold, m, at.TANGENTS, t1)
    store3(manifold, m, at.TANGENTS + 3, cross(n, t1))
    frame = frame_of(manifold, m)
    pair = pair_of(bodies.body, bodies.turned, a, b)
    pa, pb = load3(state, a, at.P), load3(state, b, at.P)
    ra_wb, rb_wb = quat_mat(load4(state, a, at.Q)), quat_mat(load4(state, b, at.Q))
    round_a = radius(shape, shape_kind, pose, key[m, at.SHAPE_A], n)
    round_b = radius(shape, shape_kind, pose, key[m, at.SHAPE_B], n)
    rim_a = rim_of(shape, shape_kind, pose, key[m, at.SHAPE_A], n)
    rim_b = rim_of(shape, shape_kind, pose, key[m, at.SHAPE_B], scale(-1.0, n))
    manifold[m, at.RIMS] = ON_ELLIPSOID if is_ellipsoid(shape_kind, key[m, at.SHAPE_A], key[m, at.SHAPE_B]) else 0.0
    for k in range(key[m, at.POINTS]):
        i = 4 * m + k
        place, gap = load3(point, i, at.PLACE), point[i, at.FIRST_GAP]
        store3(point, i, at.ARM_A, sub(place, pa))
        store3(point, i, at.ARM_B, sub(place, pb))
        on_a, on_b = axpy(-0.5 * gap, n, place), axpy(0.5 * gap, n, place)
        if manifold[m, at.RIMS] != ON_ELLIPSOID and rolls_on(rim_a, on_a):
            manifold[m, at.RIMS], point[i, at.ROUND_A] = 1.0, -rim_a.radius
            on_a = axpy(-rim_a.radius, rim_a.lowest, on_a)
        else:
            point[i, at.ROUND_A] = round_a
            on_a = axpy(-round_a, n, on_a)
        if manifold[m, at.RIMS] != ON_ELLIPSOID and rolls_on(rim_b, on_b):
            manifold[m, at.RIMS], point[i, at.ROUND_B] = 1.0, -rim_b.radius
            on_b = axpy(-rim_b.radius, rim_b.lowest, on_b)
        else:
            point[i, at.ROUND_B] = round_b
            on_b = axpy(round_b, n, on_b)
        store3(point, i, at.SPOT_A, tmat_vec(ra_wb, sub(on_a, pa)))
        store3(point, i, at.SPOT_B, tmat_vec(rb_wb, sub(on_b, pb)))
        point[i, at.SEPARATION] = gap
        held = mat_vec(frame, load3(point, i, at.TANGENT_IMPULSE))
        point[i, at.HELD], point[i, at.HELD + 1] = held[0], held[1]
    if manifold[m, at.RIMS] == 1.0:
        store3(manifold, m, at.RIM_AXIS_A, tmat_vec(ra_wb, rim_a.axis))
        store3(manifold, m, at.RIM_AXIS_B, tmat_vec(rb_wb, rim_b.axis))
    manifold[m, at.POINT_SHARE] = 1.0 / key[m, at.POINTS]
    spread(m, sub(pb, pa), manifold, key, point)
    weigh(contacts, m, Centre(frame, load3(manifold, m, at.CENTRE_A), load3(manifold, m, at.CENTRE_B)), pair)
