"""Which shapes the rays of a tile can meet at all, from near to far.

A tile's rays lie in a cone about a ball that holds their origins. A shape whose bounding ball lies off the cone meets none.

Source: Amanatides, Ray Tracing with Cones, 1984 (bounding cones).
"""

import math
from typing import NamedTuple

from plumbline.engine.compile.jit import kernel, stream
from plumbline.engine.maths.rows import Floats, Ints, Vec, load3
from plumbline.engine.maths.vec import add, along, dot, norm, sub
from plumbline.engine.memory import arena as at
from plumbline.engine.rays.streams import Rays

WIDE = 0.1
"""Cosine of the half angle [1] of a cone below which nothing is culled by it."""
SLACK = 1e-7
"""Share of the distance [1] by which bounding balls are widened: the root of the rounding of a squared distance."""


class Cone(NamedTuple):
    """A ball around origins, its centre and radius [m], and the directions: an axis, and the least cosine of angles to it."""

    apex: Vec
    spread: float
    axis: Vec
    cosine: float


@kernel
def origin_ball(n: int, rays: Rays) -> tuple[Vec, float]:
    """A ball around the origins [m]; radius 0 where they are all the same."""
    ox, oy, oz = rays[0], rays[1], rays[2]
    first = (ox[0], oy[0], oz[0])
    same = 0
    for i in range(n):
        same += (ox[i] == first[0]) & (oy[i] == first[1]) & (oz[i] == first[2])
    if same == n:
        return first, 0.0
    low, high = first, first
    for i in range(n):
        low = (min(low[0], ox[i]), min(low[1], oy[i]), min(low[2], oz[i]))
        high = (max(high[0], ox[i]), max(high[1], oy[i]), max(high[2], oz[i]))
    half = (0.5 * (high[0] - low[0]), 0.5 * (high[1] - low[1]), 0.5 * (high[2] - low[2]))
    return add(low, half), norm(half) * (1.0 + 1e-9)


@kernel
def narrowest(n: int, rays: Rays, axis: Vec) -> float:
    """The least cosine [1] between the axis and the rays; four running minima, since one would wait for itself."""
    dx, dy, dz = rays[3], rays[4], rays[5]
    a, b, c, d = 1.0, 1.0, 1.0, 1.0
    for q in range(n // 4):
        i = 4 * q
        u = axis[0] * dx[i] + axis[1] * dy[i] + axis[2] * dz[i]
        v = axis[0] * dx[i + 1] + axis[1] * dy[i + 1] + axis[2] * dz[i + 1]
        w = axis[0] * dx[i + 2] + axis[1] * dy[i + 2] + axis[2] * dz[i + 2]
        x = axis[0] * dx[i + 3] + axis[1] * dy[i + 3] + axis[2] * dz[i + 3]
        a, b, c, d = (u if u < a else a), (v if v < b else b), (w if w < c else c), (x if x < d else d)
    for i in range(n - n % 4, n):
        u = axis[0] * dx[i] + axis[1] * dy[i] + axis[2] * dz[i]
        a = u if u < a else a
    a, c = (a if a < b else b), (c if c < d else d)
    return a if a < c else c


@kernel
def middle_of(n: int, wide: int, rays: Rays) -> Vec:
    """The axis of the cone: the middle of the directions at the corners of the tile. Any unit vector would do."""
    sum_of = (0.0, 0.0, 0.0)
    for i in (0, wide - 1, n - wide, n - 1):
        sum_of = add(sum_of, (rays[3][i], rays[4][i], rays[5][i]))
    return along(sum_of, (0.0, 0.0, 1.0))


@kernel
def cone_around(n: int, wide: int, rays: Rays) -> Cone:
    """The cone that holds the first n rays of a tile, `wide` in a row."""
    apex, spread = origin_ball(n, rays)
    axis = middle_of(n, wide, rays)
    return Cone(apex, spread, axis, narrowest(n, rays, axis))


@stream
def cull(k: int, ball: Floats, cone: Cone, reach: Floats) -> None:
    """reach[s]: least distance [m] at which a ray of the cone may meet the ball of shape s, or infinity if none does.

    With phi the angle of the centre off the axis and theta the cone's half angle, the centre lies |v| sin(phi - theta) off it.
    """
    cx, cy, cz, radius = ball[0], ball[1], ball[2], ball[3]
    apex, spread, axis, cosine = cone.apex, cone.spread, cone.axis, cone.cosine
    sine = math.sqrt(max(0.0, 1.0 - cosine * cosine))
    wide = cosine < WIDE
    for s in range(k):
        x, y, z = cx[s] - apex[0], cy[s] - apex[1], cz[s] - apex[2]
        far2 = x * x + y * y + z * z
        far = math.sqrt(far2)
        r = radius[s] + spread + SLACK * far
        on = x * axis[0] + y * axis[1] + z * axis[2]
        rest = far2 - on * on
        off = math.sqrt(rest if rest > 0.0 else 0.0)
        meets = (off * cosine - on * sine <= r) & (on * cosine + off * sine >= 0.0)
        reach[s] = (far - r if far > r else 0.0) if wide | meets | (far <= r) else math.inf


@kernel
def reach_planes(k: int, rows_of: Ints, shape_kind: Ints, pose: Floats, cone: Cone, reach: Floats) -> None:
    """As `cull`, for planes, which no ball bounds: nothing is nearer than their distance."""
    for p in range(k):
        if shape_kind[rows_of[p], at.TYPE] == at.PLANE:
            normal = (pose[p, 5], pose[p, 8], pose[p, 11])
            height = abs(dot(normal, sub(cone.apex, load3(pose, p, 0))))
            reach[p] = max(0.0, height * (1.0 - SLACK) - cone.spread)


@kernel
def candidates(k: int, reach: Floats, order: Ints) -> int:
    """The shapes with a finite reach from near to far (Shell's sort), equal ones by number. Returns: how many."""
    count = 0
    for s in range(k):
        order[count] = s
        count += reach[s] < math.inf
    gap = 1
    while gap < count // 3:
        gap = 3 * gap + 1
    while gap > 0:
        for i in range(gap, count):
            s = order[i]
            j = i
            while j >= gap and (reach[order[j - gap]] > reach[s] or (reach[order[j - gap]] == reach[s] and order[j - gap] > s)):
                order[j] = order[j - gap]
                j -= gap
            order[j] = s
        gap //= 3
    return count
