"""The first hit of each ray among convex hulls and triangles, where it comes before the hits already found.

A ray that starts inside a hull hits its exit. Triangles are hit from both sides; their normal follows from their winding.

Source: Ericson, Real-Time Collision Detection, sections 5.3.8 (polyhedron) and 5.3.6 (triangle); Cyrus, Beck, Generalized Two-
and Three-Dimensional Clipping, 1978; Kay, Kajiya, Ray Tracing Complex Scenes, 1986 (a tree of bounds, nearer ones first).
"""

import math

import numpy as np

from plumbline.engine.compile.jit import entry, kernel
from plumbline.engine.maths.rows import Floats, Ints, Vec, load3, load4, load9, store3
from plumbline.engine.maths.vec import add, axpy, cross, dot, mat_vec, norm, quat_mat, scale, sub, tmat_vec
from plumbline.engine.memory import arena as at
from plumbline.engine.memory.carve import floats_of, ints_of
from plumbline.engine.rays.hits import Hits
from plumbline.engine.rays.tree import RayTree

MISS = math.inf
UP = (0.0, 0.0, 1.0)
DEPTH = 128
"""Room of the stack: two nodes for each level of a tree that halves at most 2^60 solids."""
TINY = 1e-200
"""Component of a direction [1] below which a ray runs along a plane of the boxes."""
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


@kernel
def box_entry(o: Vec, inverse: Vec, node: Floats, k: int, best: float) -> float:
    """Distance [m] to the box of node k, or infinity where the ray misses it or enters beyond `best`."""
    enter, leave = 0.0, best
    for axis in range(3):
        one, two = (node[k, axis] - o[axis]) * inverse[axis], (node[k, axis + 3] - o[axis]) * inverse[axis]
        near, far = (one, two) if one < two else (two, one)
        enter, leave = (near if near > enter else enter), (far if far < leave else leave)
    return enter if enter <= leave else MISS


@entry
def cast_on_polyhedra(
    floats: Floats, ints: Ints, tree: RayTree, origins: Floats, directions: Floats, max_range: float, hits: Hits
) -> None:
    """As `engine.rays.tiles.cast_tiles`, whose answers it takes and improves."""
    root, node, link, solid, frame = tree
    distance, body, part, normal = hits
    state, shape = floats_of(floats, ints, at.STATE), floats_of(floats, ints, at.SHAPE)
    vertex, face = floats_of(floats, ints, at.VERTEX), floats_of(floats, ints, at.FACE)
    shape_kind, polyhedron = ints_of(ints, at.SHAPE_KIND), ints_of(ints, at.POLYHEDRON)
    span, loop = ints_of(ints, at.SPAN), ints_of(ints, at.LOOP)
    stack, reach = np.empty(DEPTH, np.int64), np.empty(DEPTH)
    one = origins.shape[0] == 1
    limit = np.nextafter(max_range, math.inf)
    for b in range(root.shape[0]):
        owner, top = root[b, 0], root[b, 1]
        m, centre = quat_mat(load4(state, owner, at.Q)), load3(state, owner, at.P)
        low, high = load3(node, top, 0), load3(node, top, 3)
        middle, bound = scale(0.5, add(low, high)), 0.5 * norm(sub(high, low))
        middle = add(centre, mat_vec(m, middle))
        for r in range(directions.shape[0]):
            d = load3(directions, r, 0)
            d = scale(1.0 / norm(d), d)
            start = load3(origins, 0 if one else r, 0)
            best, chosen = (distance[r] if body[r] >= 0 else limit), -1
            away = sub(start, middle)
            along = dot(away, d)
            miss2 = dot(away, away) - along * along
            if miss2 > bound * bound * (1.0 + 1e-9) + 1e-12 * dot(away, away) or -along - bound > best or along > bound:
                continue
            o, d = tmat_vec(m, sub(start, centre)), tmat_vec(m, d)
            # A number too large for any box stands for 1 / 0, which would make NaN of a box that begins at the ray.
            inverse = (
                1.0 / d[0] if abs(d[0]) > TINY else 1.0 / TINY,
                1.0 / d[1] if abs(d[1]) > TINY else 1.0 / TINY,
                1.0 / d[2] if abs(d[2]) > TINY else 1.0 / TINY,
            )
            facing = UP
            stack[0], reach[0], depth = top, box_entry(o, inverse, node, top, best), 1
            while depth > 0:
                depth -= 1
                k = stack[depth]
                if not reach[depth] <= best:
                    continue
                first, count = link[k, 0], link[k, 1]
                if count == 0:
                    near, far = box_entry(o, inverse, node, first, best), box_entry(o, inverse, node, first + 1, best)
                    swap = near > far
                    stack[depth], reach[depth] = (first, near) if swap else (first + 1, far)
                    stack[depth + 1], reach[depth + 1] = (first + 1, far) if swap else (first, near)
                    depth += 2 if min(near, far) < MISS else 0
                for leaf in range(first, first + count):
                    s = solid[leaf]
                    turn = load9(frame, leaf, 3)
                    lo, ld = tmat_vec(turn, sub(o, load3(frame, leaf, 0))), tmat_vec(turn, d)
                    if shape_kind[s, at.TYPE] == at.HULL:
                        t, n = ray_hull(lo, ld, vertex, face, span, loop, polyhedron[s, at.FIRST_FACE], polyhedron[s, at.FACES])
                    else:
                        t, n = ray_triangle(lo, ld, vertex, polyhedron[s, at.FIRST_VERTEX], shape[s, at.BALL_RADIUS])
                    if t < best or (t == best and s < chosen):
                        best, chosen, facing = t, s, mat_vec(turn, n)
            if chosen >= 0:
                distance[r], body[r], part[r] = best, owner, shape_kind[chosen, at.PART]
                store3(normal, r, 0, mat_vec(m, facing))
