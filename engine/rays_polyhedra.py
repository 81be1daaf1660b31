"""The first hit of each ray among convex hulls and triangles, where it comes before the hits already found.

A ray that starts inside a hull hits its exit. Triangles are hit from both sides; their normal follows from their winding.

Source: Ericson, Real-Time Collision Detection, sections 5.3.8 (polyhedron) and 5.3.6 (triangle); Cyrus, Beck, Generalized Two-
and Three-Dimensional Clipping, 1978.
"""

import math

from engine.arena import (
    BALL_RADIUS,
    COUNT,
    FACE,
    FACES,
    FIRST_FACE,
    FIRST_VERTEX,
    HULL,
    LOOP,
    OWNER,
    POLYHEDRON,
    POSE,
    SHAPE,
    SHAPE_KIND,
    SHAPES,
    SPAN,
    STATE,
    TYPE,
    VERTEX,
)  # fmt: skip
from engine.broad_phase import pose_shapes
from engine.carve import floats_of, ints_of
from engine.jit import entry, kernel
from engine.vec import Floats, Ints, Vec, axpy, cross, dot, load3, load9, mat_vec, norm, store3, sub, tmat_vec

__all__ = ["cast_on_polyhedra"]

MISS = math.inf
UP = (0.0, 0.0, 1.0)
SEAM = 1e-12
"""Share of the triangle's size [1] by which it reaches over its edges, so that no ray slips between two triangles."""


@kernel
def ray_hull(o: Vec, d: Vec, vertex: Floats, face: Floats, span: Ints, loop: Ints, first: int, count: int) -> tuple[float, Vec]:
    """The last entry through the planes of the faces, or the first exit from inside."""
    enter, leave, into, out = -math.inf, math.inf, UP, UP
    for f in range(first, first + count):
        n = load3(face, f, 0)
        height = dot(n, sub(o, load3(vertex, loop[span[f, 0], 0], 0)))
        fall = dot(n, d)
        if fall == 0.0:
            if height > 0.0:
                return MISS, UP
        elif fall < 0.0:
            if -height / fall > enter:
                enter, into = -height / fall, n
        elif -height / fall < leave:
            leave, out = -height / fall, n
    if enter > leave or leave < 0.0:
        return MISS, UP
    return (enter, into) if enter >= 0.0 else (leave, out)


@kernel
def ray_triangle(o: Vec, d: Vec, vertex: Floats, first: int, size: float) -> tuple[float, Vec]:
    """The triangle in the plane z = 0."""
    if d[2] == 0.0:
        return MISS, UP
    t = -o[2] / d[2]
    if t < 0.0:
        return MISS, UP
    x = axpy(t, d, o)
    for k in range(3):
        a, b = load3(vertex, first + k, 0), load3(vertex, first + (k + 1) % 3, 0)
        e = sub(b, a)
        if dot(sub(x, a), cross(UP, e)) < -SEAM * size * norm(e):
            return MISS, UP
    return t, UP


@entry
def cast_on_polyhedra(
    floats: Floats,
    ints: Ints,
    origins: Floats,
    directions: Floats,
    max_range: float,
    distance: Floats,
    normal: Floats,
    who: Ints,
) -> None:
    """As `cast_rays`, whose answers it takes and improves."""
    state, shape, pose = floats_of(floats, ints, STATE), floats_of(floats, ints, SHAPE), floats_of(floats, ints, POSE)
    vertex, face = floats_of(floats, ints, VERTEX), floats_of(floats, ints, FACE)
    shape_kind, count, polyhedron = ints_of(ints, SHAPE_KIND), ints_of(ints, COUNT), ints_of(ints, POLYHEDRON)
    span, loop = ints_of(ints, SPAN), ints_of(ints, LOOP)
    shapes = count[0, SHAPES]
    pose_shapes(state, shape, shape_kind, shapes, pose)
    for s in range(shapes):
        kind = shape_kind[s, TYPE]
        if kind < HULL:
            continue
        bound, centre, m = shape[s, BALL_RADIUS], load3(pose, s, 0), load9(pose, s, 3)
        for r in range(origins.shape[0]):
            d = load3(directions, r, 0)
            away = sub(load3(origins, r, 0), centre)
            along = dot(away, d)
            best = distance[0, r] if who[r, 0] >= 0 else max_range
            miss2 = dot(away, away) - along * along
            if miss2 > bound * bound * (1.0 + 1e-9) + 1e-12 * dot(away, away) or -along - bound > best or along > bound:
                continue
            lo, ld = tmat_vec(m, away), tmat_vec(m, d)
            if kind == HULL:
                t, n = ray_hull(lo, ld, vertex, face, span, loop, polyhedron[s, FIRST_FACE], polyhedron[s, FACES])
            else:
                t, n = ray_triangle(lo, ld, vertex, polyhedron[s, FIRST_VERTEX], bound)
            if t < MISS and (t < best or (t == best and who[r, 0] < 0)):
                distance[0, r] = t
                store3(normal, r, 0, mat_vec(m, n))
                who[r, 0], who[r, 1] = shape_kind[s, OWNER], s
