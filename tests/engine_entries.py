"""Compiled functions that only tests call: kernels of the engine for many arguments at once."""

import math

from plumbline.engine.compile.jit import entry
from plumbline.engine.islands.islands import connect, number_islands, start_islands
from plumbline.engine.maths.rows import Floats, Ints, load3, load9, store3
from plumbline.engine.maths.vec import axpy, sub
from plumbline.engine.memory import arena as at
from plumbline.engine.memory.tables import Contacts
from plumbline.engine.narrow.convex import part_cores
from plumbline.engine.narrow.gjk import simplex_of
from plumbline.engine.narrow.support import core_radius, solids_of
from plumbline.engine.narrow.triangle_triangle import triangle_triangle
from plumbline.engine.steps.stages import near_blows

__all__ = ["connected_components", "list_near_blows", "measure_convex", "measure_triangles"]


@entry
def measure_convex(floats: Floats, ints: Ints, a: int, b: int, pose_a: Floats, pose_b: Floats, out: Floats) -> None:
    """Write gap [m], normal from A to B, and the closest points of A and of B [m] in W.

    Args: a, b: shapes; pose_a, pose_b (k, 12): position and rotation matrix by rows in W; out (k, 10).
    """
    t, simplex = solids_of(floats, ints), simplex_of(floats, ints)
    ra, rb = core_radius(t, a), core_radius(t, b)
    size = t.shape[a, at.BALL_RADIUS] + t.shape[b, at.BALL_RADIUS]
    for k in range(pose_a.shape[0]):
        for c in range(12):
            t.pose[a, c], t.pose[b, c] = pose_a[k, c], pose_b[k, c]
        pa = load3(pose_a, k, 0)
        gap, n, qa, qb = part_cores(t, a, b, sub(load3(pose_b, k, 0), pa), size, math.inf, simplex)
        out[k, 0] = gap - ra - rb
        store3(out, k, 1, n)
        store3(out, k, 4, axpy(1.0, pa, axpy(ra, n, qa)))
        store3(out, k, 7, axpy(1.0, pa, axpy(-rb, n, qb)))


@entry
def measure_triangles(one: Floats, two: Floats, kind: Ints, ends: Floats) -> None:
    """Write how each pair meets, with the edges on which the ends of its segment lie, and these ends [m].

    Args: one, two (k, 9): corners by rows [m]; kind (k, 3), ends (k, 6): as `triangle_triangle` returns them.
    """
    for k in range(one.shape[0]):
        met, first, last, begins, stops = triangle_triangle(load9(one, k, 0), load9(two, k, 0))
        kind[k, 0], kind[k, 1], kind[k, 2] = met, begins, stops
        store3(ends, k, 0, first)
        store3(ends, k, 3, last)


@entry
def connected_components(links: Ints, kind: Ints, island: Ints) -> int:
    """Number the islands of bodies under links alone.

    Args: links (k, 2): pairs of bodies; kind (n, 4) as BODY_KIND; island (n, 8) as ISLAND, whose column NUMBER is written.
    Returns: how many islands there are.
    """
    start_islands(island, kind.shape[0])
    for k in range(links.shape[0]):
        connect(island, kind, links[k, 0], links[k, 1])
    return number_islands(island, kind, kind.shape[0])


@entry
def list_near_blows(kind: Ints, manifold: Floats, key: Ints, order: Ints, room: Ints, step: int) -> int:
    """`near_blows` of contacts in this order. Returns: how many there are, the first rows of `room`."""
    return int(near_blows(kind, Contacts(manifold, manifold, key, key, order), room, step))
