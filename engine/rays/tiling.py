"""Rays as they are given, in tiles of neighbours: which rays are a tile, copied in, and their answers copied out.

Neighbours are taken as they come, in rows of a given width: another order costs time and changes nothing else.
"""

import math
from typing import NamedTuple

import numpy as np

from plumbline.engine.compile.jit import kernel, stream
from plumbline.engine.maths.rows import Floats, Ints, Vec, load3
from plumbline.engine.maths.vec import norm, sub
from plumbline.engine.rays.hits import Hits
from plumbline.engine.rays.streams import Rays, Triple

TILE = 128
"""Rays of a tile: enough to share the cost of culling, few enough that all of them stay in the first-level cache."""
WIDTH = 32
"""Rays of a tile in one row of the pattern: four cache lines of each answer, which memory takes faster than fewer."""


class Bundle(NamedTuple):
    """Rays as given: origins (r, 3) m, or (1, 3) for all rays; directions (r, 3), of any length; the greatest range [m]."""

    origins: Floats
    directions: Floats
    max_range: float


class Tiling(NamedTuple):
    """Rays in a row of the pattern, rays of a tile in one row, and how many tiles there are."""

    row: int
    wide: int
    tiles: int


class TileHits(NamedTuple):
    """As `Hits`, for the rays of a tile, with an array for each coordinate of the normals."""

    distance: Floats
    body: Ints
    shape: Ints
    normal: Triple


@kernel
def row_of(directions: Floats) -> int:
    """Rays in a row of the pattern: up to the first whose step from its neighbour differs by half from the step before.

    All of them where this does not divide their number, or gives rows shorter than a tile is wide.
    """
    count: int = directions.shape[0]
    for i in range(2, count):
        a, b, c = load3(directions, i - 2, 0), load3(directions, i - 1, 0), load3(directions, i, 0)
        before = sub(b, a)
        if not norm(sub(sub(c, b), before)) <= 0.5 * norm(before):
            return i if i >= WIDTH and count % i == 0 else count
    return count


@kernel
def tiling_of(directions: Floats) -> Tiling:
    """How rays with these directions (r, 3) are laid out in tiles."""
    row, count = row_of(directions), directions.shape[0]
    if row == count:
        return Tiling(row, TILE, (count + TILE - 1) // TILE)
    high = TILE // WIDTH
    return Tiling(row, WIDTH, ((row + WIDTH - 1) // WIDTH) * ((count // row + high - 1) // high))


@stream
def load_row(n: int, at: int, to: int, source: Floats, x: Floats, y: Floats, z: Floats) -> None:
    """Take rows of three numbers apart. Unsigned places spare the compiler the question whether they count from the end."""
    first, place = np.uint64(at), np.uint64(to)
    for i in range(np.uint64(n)):
        x[place + i] = source[first + i, 0]
        y[place + i] = source[first + i, 1]
        z[place + i] = source[first + i, 2]


@stream
def fill(n: int, v: Vec, x: Floats, y: Floats, z: Floats) -> None:
    """The same vector in every place."""
    for i in range(n):
        x[i], y[i], z[i] = v[0], v[1], v[2]


@stream
def make_unit(n: int, rays: Rays, length: Floats) -> bool:
    """Divide the directions by their lengths. Returns: whether all rays are finite and have a direction."""
    ox, oy, oz, dx, dy, dz = rays
    good, unit = 0, 0
    for i in range(n):
        length[i] = math.sqrt(dx[i] * dx[i] + dy[i] * dy[i] + dz[i] * dz[i])
    for i in range(n):
        good += (length[i] >= 1e-12) & (length[i] < math.inf) & (abs(ox[i]) + abs(oy[i]) + abs(oz[i]) < math.inf)
        unit += abs(length[i] - 1.0) < 1e-15
    if unit < n:
        for i in range(n):
            dx[i], dy[i], dz[i] = dx[i] / length[i], dy[i] / length[i], dz[i] / length[i]
    return good == n


@kernel
def load_tile(
    origins: Floats, directions: Floats, start: int, row: int, wide: int, high: int, rays: Rays, length: Floats
) -> bool:
    """Copy `high` runs of `wide` rays, `row` apart, and make the directions unit. Returns: whether all are finite and not 0."""
    ox, oy, oz, dx, dy, dz = rays
    one = origins.shape[0] == 1
    for k in range(high):
        at, to = start + k * row, k * wide
        load_row(wide, at, to, directions, dx, dy, dz)
        if not one:
            load_row(wide, at, to, origins, ox, oy, oz)
    if one:
        fill(wide * high, load3(origins, 0, 0), ox, oy, oz)
    return make_unit(wide * high, rays, length)


@stream
def answer(n: int, at: int, to: int, here: TileHits, hits: Hits) -> None:
    """Copy the hits of a run of n rays from place `to` of the tile to place `at` of all rays."""
    best, own, role, (x, y, z) = here
    distance, body, shape, normal = hits
    there, place = np.uint64(at), np.uint64(to)
    for i in range(np.uint64(n)):
        distance[there + i] = best[place + i]
        body[there + i] = own[place + i]
        shape[there + i] = role[place + i]
    for i in range(np.uint64(n)):
        normal[there + i, 0], normal[there + i, 1], normal[there + i, 2] = x[place + i], y[place + i], z[place + i]
