"""Contacts of any two convex shapes: the normal by GJK or EPA, or a face that is as good, then the features clipped.

Source: van den Bergen, Collision Detection in Interactive 3D Environments, 2003, sections 4.3.4 (radii around cores), 4.3.8;
Gregorius, The Separating Axis Test between Convex Polyhedra, GDC 2013 (preferring faces).
"""

from plumbline.engine.compile.jit import kernel
from plumbline.engine.maths.rows import Vec, load3, store3
from plumbline.engine.maths.vec import add, axpy, dot, neg, norm, scale, sub
from plumbline.engine.memory import arena as at
from plumbline.engine.narrow.clip_features import clip_features, crossing_lines
from plumbline.engine.narrow.curved import sharpen
from plumbline.engine.narrow.epa import depth
from plumbline.engine.narrow.features import facing, is_line, write_feature
from plumbline.engine.narrow.gjk import Simplex, closest_points, distance
from plumbline.engine.narrow.point import CORNERS_OF_B, Points, put_point
from plumbline.engine.narrow.sphere_triangle import sphere_triangle
from plumbline.engine.narrow.support import Solids, core_radius, separation_along
from plumbline.engine.narrow.triangle import BACK, BESIDE, leans_over

FACE = 1 << 13
"""Features of one reference face lie within this many numbers."""
TOUCHING = 1e-9
"""Share of the size [1] of a distance whose direction rounding spoils: EPA answers such pairs, with a depth of either sign."""
ALIGNED = 0.9999
"""Cosine between a normal and a face above which a capsule lies on the face."""
SAME = 1.0 - 1e-10
"""Cosine above which two faces are parallel."""


@kernel
def part_cores(
    t: Solids, a: int, b: int, d: Vec, size: float, most: float, simplex: Simplex
) -> tuple[float, Vec, Vec, Vec]:  # fmt: skip
    """The signed distance [m] of two cores whose centres lie d apart.

    Returns: the gap (a larger one than `most` may be too small), the normal from A to B, and the closest points of A and B,
    from the centre of A.
    """
    work = simplex.work
    gap, v, count = distance(t, a, b, d, size, most, work)
    if gap > TOUCHING * size:
        qa, qb = closest_points(work, count)
        return sharpen(t, a, b, d, size, (gap, scale(-1.0 / norm(v), v), qa, qb))
    deep, n, qa, qb = depth(t, a, b, d, size, count, simplex)
    return sharpen(t, a, b, d, size, (-deep, n, qa, qb))


@kernel
def convex_contact(
    t: Solids, a: int, b: int, margin: float, slack: float, simplex: Simplex, out: Points, row: int
) -> tuple[int, Vec]:  # fmt: skip
    """Convex shape A against convex shape B, or against the outer side of a triangle B.

    Args: slack [m]: what a face may lose against the best normal and still be taken.

    Which side of a triangle is met is told by the way out of the contact. Where the shape's centre lies does not tell it: a
    slab reaches under triangles that are turned away from its middle.
    """
    pa, pb = load3(t.pose, a, 0), load3(t.pose, b, 0)
    d = sub(pb, pa)
    ra, rb = core_radius(t, a), core_radius(t, b)
    size = t.shape[a, at.BALL_RADIUS] + t.shape[b, at.BALL_RADIUS]
    one_sided = t.shape_kind[b, at.TYPE] == at.TRIANGLE
    if one_sided and t.shape_kind[a, at.TYPE] == at.SPHERE:
        return sphere_triangle(t, a, b, margin, out, row)
    outward = (t.pose[b, 5], t.pose[b, 8], t.pose[b, 11])
    if one_sided and dot(d, outward) > t.shape[a, at.BALL_RADIUS]:
        return 0, outward
    gap, n, qa, qb = part_cores(t, a, b, d, size, margin + ra + rb, simplex)
    if gap - ra - rb > margin or (one_sided and dot(n, outward) > BACK):
        return 0, n
    forced = False
    if one_sided and leans_over(t, b, sub(qb, d), neg(n), t.polyhedron[b, at.INNER]):
        if dot(n, outward) > -BESIDE:
            return 0, n
        n, forced = neg(outward), True
    fa, na, ca = facing(t, a, n)
    fb, nb, cb = facing(t, b, neg(n))
    on_a, on_b = False, forced
    if forced:
        pass
    elif ra + rb > 0.0:
        flat = t.shape_kind[a, at.TYPE] != at.SPHERE and t.shape_kind[b, at.TYPE] != at.SPHERE
        on_a, on_b = flat and ca > ALIGNED, flat and cb > ALIGNED
    else:
        gap_a, gap_b = separation_along(t, a, b, d, na), separation_along(t, a, b, d, neg(nb))
        on_a, on_b = gap - gap_a <= slack, gap - gap_b <= slack
        # Whatever faces an ellipsoid is as good as its own tangent: it has no faces to prefer.
        on_a, on_b = on_a and t.shape_kind[a, at.TYPE] != at.ELLIPSOID, on_b and t.shape_kind[b, at.TYPE] != at.ELLIPSOID
        if on_b and (one_sided or gap_b > gap_a + slack):
            on_a = False
    if on_a and on_b:
        on_a = not (t.shape_kind[a, at.TYPE] == at.CYLINDER and dot(na, nb) < -SAME)
    if on_a:
        n = na
    elif on_b:
        n = neg(nb)
    third, points = out.polygon.shape[0] // 3, 0
    if on_a:
        fb, nb, cb = facing(t, b, neg(n))
        sides = write_feature(t, a, fa, n, out, 0)
        count = write_feature(t, b, fb, neg(n), out, third)
        marker = CORNERS_OF_B + FACE * (fa + 2)
        points = clip_features(sides, count, n, rb, margin, out, row, marker)
    elif on_b:
        fa, na, ca = facing(t, a, n)
        sides = write_feature(t, b, fb, neg(n), out, 0)
        count = write_feature(t, a, fa, n, out, third)
        marker = FACE * (fb + 2)
        points = clip_features(sides, count, neg(n), ra, margin, out, row, marker)
    elif is_line(t, a, n) and is_line(t, b, neg(n)):
        write_feature(t, a, fa, n, out, 0)
        write_feature(t, b, fb, neg(n), out, third)
        points = crossing_lines(n, ra, rb, margin, out, row)
    if points == 0 and not forced:
        if on_a or on_b:
            gap = separation_along(t, a, b, d, n)
        gap = gap - ra - rb
        if gap > margin:
            return 0, n
        middle = add(pa, scale(0.5, add(axpy(ra, n, qa), axpy(-rb, n, qb))))
        put_point(out, row, middle, gap, 1)
        points = 1
    return points, n


@kernel
def plane_contact(t: Solids, a: int, b: int, margin: float, out: Points, row: int) -> tuple[int, Vec]:
    """Plane A against polyhedron B: the corners of the face through the deepest corner that looks most at the plane."""
    up = (t.pose[a, 5], t.pose[a, 8], t.pose[a, 11])
    face, _, _ = facing(t, b, neg(up))
    store3(out.polygon, 0, 0, load3(t.pose, a, 0))
    count = write_feature(t, b, face, neg(up), out, out.polygon.shape[0] // 3)
    marker = CORNERS_OF_B + FACE * (face + 2)
    return clip_features(0, count, up, 0.0, margin, out, row, marker), up
