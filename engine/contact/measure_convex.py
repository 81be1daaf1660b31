"""Signed distances of two shapes at many poses, by the same GJK and EPA as the contacts."""

import math

from engine.compile.jit import entry
from engine.maths.rows import Floats, Ints, load3, store3
from engine.maths.vec import axpy, sub
from engine.memory import arena as at
from engine.narrow.convex import part_cores
from engine.narrow.gjk import simplex_of
from engine.narrow.support import core_radius, solids_of


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
