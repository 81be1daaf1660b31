"""The first hit of each ray among the shapes with closed forms, in tiles of neighbouring rays.

Shapes that the cone of a tile misses are left out; the others are tried from near to far, until all rays of the tile end before
the next.

Source: as for `engine.rays.cones` and `engine.rays.nearest`.
"""

from typing import NamedTuple

import numpy as np

from plumbline.engine.broad.bounds import put_pose
from plumbline.engine.compile.jit import entry, inlined, kernel
from plumbline.engine.maths.rows import Floats, Ints, load3, load4, load9
from plumbline.engine.memory import arena as at
from plumbline.engine.memory.carve import floats_of, ints_of
from plumbline.engine.rays.cones import candidates, cone_around, cull, reach_planes
from plumbline.engine.rays.hits import Hits
from plumbline.engine.rays.nearest import any_beyond, clear, label, meet_shape, pack, picked, scatter, start_search
from plumbline.engine.rays.streams import Primitive, normals_of
from plumbline.engine.rays.tiling import TILE, Bundle, TileHits, Tiling, answer, load_tile, tiling_of


class Primitives(NamedTuple):
    """The shapes with closed forms: their rows in the table of shapes; position and rotation matrix in W (k, 12); centres and
    radii of their bounding balls (4, k).
    """

    row: Ints
    pose: Floats
    ball: Floats


@kernel
def pose_primitives(floats: Floats, ints: Ints) -> Primitives:
    """The shapes with closed forms where they are now."""
    state, shape = floats_of(floats, ints, at.STATE), floats_of(floats, ints, at.SHAPE)
    shape_kind = ints_of(ints, at.SHAPE_KIND)
    shapes, found = ints_of(ints, at.COUNT)[0, at.SHAPES], 0
    who = np.zeros(shapes + 1, np.int64)
    for s in range(shapes):
        if shape_kind[s, at.TYPE] < at.HULL:
            who[found] = s
            found += 1
    pose, ball = np.empty((found, 12)), np.empty((4, found))
    for k in range(found):
        s = who[k]
        b = shape_kind[s, at.OWNER]
        put_pose(shape, s, load3(state, b, at.P), load4(state, b, at.Q), pose, k)
        for c in range(3):
            ball[c, k] = pose[k, c]
        ball[3, k] = shape[s, at.BALL_RADIUS]
    return Primitives(who, pose, ball)


@inlined
def primitive_of(p: int, shape: Floats, shape_kind: Ints, posed: Primitives) -> Primitive:
    """One of the shapes with closed forms."""
    s = posed.row[p]
    kind, owner, part = shape_kind[s, at.TYPE], shape_kind[s, at.OWNER], shape_kind[s, at.PART]
    centre, axes = load3(posed.pose, p, 0), load9(posed.pose, p, 3)
    return Primitive(p, kind, owner, part, centre, axes, load3(shape, s, at.SIZE), posed.ball[3, p])


@kernel
def cast_tile_range(
    floats: Floats, ints: Ints, bundle: Bundle, tiling: Tiling, first_tile: int, last_tile: int, hits: Hits
) -> bool:
    """As `cast_tiles`, for the tiles from first_tile up to, but not with, last_tile."""
    shape, shape_kind = floats_of(floats, ints, at.SHAPE), ints_of(ints, at.SHAPE_KIND)
    posed = pose_primitives(floats, ints)
    rows_of, pose, ball = posed
    origins, directions, max_range = bundle
    k = len(pose)
    reach, order = np.empty(k), np.empty(k + 1, np.int64)
    a, places = np.empty((21, TILE)), np.empty((4, TILE), np.int64)
    rays, packed = (a[0], a[1], a[2], a[3], a[4], a[5]), (a[6], a[7], a[8], a[9], a[10], a[11])
    here, packed_normal = TileHits(a[18], places[2], places[3], (a[12], a[13], a[14])), (a[15], a[16], a[17])
    best, own, role, normal = here
    t, length, who, pick = a[19], a[20], places[0], places[1]
    row, wide = tiling.row, tiling.wide
    high, across, rows = TILE // wide, (row + wide - 1) // wide, directions.shape[0] // max(row, 1)
    for tile in range(first_tile, last_tile):
        top, left = tile // across * high, tile % across * wide
        tall, broad = min(high, rows - top), min(wide, row - left)
        n, start = tall * broad, top * row + left
        if not load_tile(origins, directions, start, row, broad, tall, rays, length):
            return False
        cone = cone_around(n, broad, rays)
        cull(k, ball, cone, reach)
        reach_planes(k, rows_of, shape_kind, pose, cone, reach)
        count, winners = candidates(k, reach, order), 0
        start_search(n, np.nextafter(max_range, np.inf), best, who)
        for c in range(count):
            p = order[c]
            if not any_beyond(n, best, reach[p]):
                break
            if meet_shape(n, rays, primitive_of(p, shape, shape_kind, posed), best, who, packed, pick, t):
                order[winners] = p
                winners += 1
        clear(n, who, here)
        for c in range(winners):
            p = order[c]
            some, met = picked(n, who, p, pick), primitive_of(p, shape, shape_kind, posed)
            if some == n:
                normals_of(n, rays, best, met, normal)
                label(n, met.owner, met.part, own, role)
            elif some > 0:
                pack(some, pick, rays, best, packed, t)
                normals_of(some, packed, t, met, packed_normal)
                scatter(some, pick, met.owner, met.part, packed_normal, here)
        for line in range(tall):
            answer(broad, start + line * row, line * broad, here, hits)
    return True


@entry
def cast_tiles(floats: Floats, ints: Ints, origins: Floats, directions: Floats, max_range: float, hits: Hits) -> bool:
    """Write distance [m], body, shape of the body and outward normal in W of each ray's first hit; inf, -1, -1 and 0 without.

    Args: origins (r, 3) m, or (1, 3) for all rays; directions (r, 3), of any length; max_range [m].
    Returns: False, with the answers unfinished, where an origin is not finite or a direction not finite or zero.
    """
    tiling = tiling_of(directions)
    return cast_tile_range(floats, ints, Bundle(origins, directions, max_range), tiling, 0, tiling.tiles, hits)
