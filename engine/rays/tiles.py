"""The first hit of each ray among the shapes with closed forms, in tiles of neighbouring rays.

A tile's rays lie in a cone about a ball that holds their origins. A shape whose bounding ball lies off the cone meets none of
them; the others are tried from near to far, until all rays of the tile end before the next. Neighbours are taken as they come,
in rows of a given width: another order costs time and changes nothing else, since the cone is always measured.

Source: Amanatides, Ray Tracing with Cones, 1984 (bounding cones); Wald, Boulos, Shirley, Ray Tracing Deformable Scenes using
Dynamic Bounding Volume Hierarchies, 2007 (tests for groups of rays).
"""

import math

import numpy as np

from engine.compile.jit import entry, kernel, stream
from engine.maths.vec import (
    Floats,
    Ints,
    Mat,
    Vec,
    add,
    along,
    dot,
    load3,
    load4,
    load9,
    mat_vec,
    norm,
    quat_mat,
    quat_mul,
    store3,
    store9,
    sub,
)
from engine.memory.arena import (
    BALL_RADIUS,
    BOX,
    CAPSULE,
    COUNT,
    HULL,
    OFFSET,
    OWNER,
    PART,
    PLANE,
    SHAPE,
    SHAPE_KIND,
    SHAPES,
    SIZE,
    SPHERE,
    STATE,
    TURN,
    TYPE,
    P,
    Q,
)  # fmt: skip
from engine.memory.carve import floats_of, ints_of
from engine.rays.streams import (
    Rays,
    meet_box,
    meet_capsule,
    meet_cylinder,
    meet_plane,
    meet_sphere,
    near_ball,
    normals_of,
)

__all__ = ["cast_tile_range", "cast_tiles", "layout"]

Triple = tuple[Floats, Floats, Floats]
TILE = 128
"""Rays of a tile: enough to share the cost of culling, few enough that all of them stay in the first-level cache."""
WIDTH = 32
"""Rays of a tile in one row of the pattern: four cache lines of each answer, which memory takes faster than fewer."""
WIDE = 0.1
"""Cosine of the half angle [1] of a cone below which nothing is culled by it."""
SLACK = 1e-7
"""Share of the distance [1] by which bounding balls are widened: the root of the rounding of a squared distance."""


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
def layout(directions: Floats) -> tuple[int, int, int]:
    """Rays in a row, the width of tiles, and their number."""
    row, count = row_of(directions), directions.shape[0]
    if row == count:
        return row, TILE, (count + TILE - 1) // TILE
    high = TILE // WIDTH
    return row, WIDTH, ((row + WIDTH - 1) // WIDTH) * ((count // row + high - 1) // high)


@kernel
def pose_primitives(floats: Floats, ints: Ints) -> tuple[Ints, Floats, Floats]:
    """The shapes with closed forms: their rows in the table of shapes; position and rotation matrix in W (k, 12); centres and
    radii of their bounding balls (4, k).
    """
    state, shape, shape_kind = floats_of(floats, ints, STATE), floats_of(floats, ints, SHAPE), ints_of(ints, SHAPE_KIND)
    shapes, found = ints_of(ints, COUNT)[0, SHAPES], 0
    who = np.zeros(shapes + 1, np.int64)
    for s in range(shapes):
        if shape_kind[s, TYPE] < HULL:
            who[found] = s
            found += 1
    pose, ball = np.empty((found, 12)), np.empty((4, found))
    for k in range(found):
        s = who[k]
        b = shape_kind[s, OWNER]
        q = load4(state, b, Q)
        store3(pose, k, 0, add(load3(state, b, P), mat_vec(quat_mat(q), load3(shape, s, OFFSET))))
        store9(pose, k, 3, quat_mat(quat_mul(q, load4(shape, s, TURN))))
        for c in range(3):
            ball[c, k] = pose[k, c]
        ball[3, k] = shape[s, BALL_RADIUS]
    return who, pose, ball


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


@stream
def cull(k: int, ball: Floats, apex: Vec, spread: float, axis: Vec, cosine: float, reach: Floats) -> None:
    """reach[s]: least distance [m] at which a ray of the cone may meet the ball of shape s, or infinity if none does.

    With phi the angle of the centre off the axis and theta the cone's half angle, the centre lies |v| sin(phi - theta) off it.
    """
    cx, cy, cz, radius = ball[0], ball[1], ball[2], ball[3]
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
def reach_planes(k: int, rows_of: Ints, shape_kind: Ints, pose: Floats, apex: Vec, spread: float, reach: Floats) -> None:
    """As `cull`, for planes, which no ball bounds: nothing is nearer than their distance."""
    for p in range(k):
        if shape_kind[rows_of[p], TYPE] == PLANE:
            normal = (pose[p, 5], pose[p, 8], pose[p, 11])
            height = abs(dot(normal, sub(apex, load3(pose, p, 0))))
            reach[p] = max(0.0, height * (1.0 - SLACK) - spread)


@stream
def start_search(n: int, limit: float, best: Floats, who: Ints) -> None:
    """Nothing met so far."""
    for i in range(n):
        best[i], who[i] = limit, -1


@stream
def any_beyond(n: int, best: Floats, reach: float) -> bool:
    """Whether a ray is still open at `reach` [m]."""
    count = 0
    for i in range(n):
        count += best[i] >= reach
    return count > 0


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


@kernel
def picked(n: int, wanted: Ints, value: int, pick: Ints) -> int:
    """Write the places where wanted[i] = value. Returns: how many."""
    count = 0
    for i in range(n):
        pick[count] = i
        count += wanted[i] == value
    return count


@stream
def keep_nearer(n: int, t: Floats, s: int, best: Floats, who: Ints) -> int:
    """Take t where it is nearer, or as near and of a shape with a lower number: the order of trying must not show.

    Returns: how often.
    """
    count = 0
    for i in range(n):
        nearer = (t[i] < best[i]) | ((t[i] == best[i]) & (s < who[i]))
        best[i] = t[i] if nearer else best[i]
        who[i] = s if nearer else who[i]
        count += nearer
    return count


@stream
def keep_nearer_picked(n: int, pick: Ints, t: Floats, s: int, best: Floats, who: Ints) -> int:
    """As `keep_nearer`, t[j] belonging to ray pick[j]."""
    count = 0
    for j in range(n):
        i = pick[j]
        b, w = best[i], who[i]
        nearer = (t[j] < b) | ((t[j] == b) & (s < w))
        best[i] = t[j] if nearer else b
        who[i] = s if nearer else w
        count += nearer
    return count


@stream
def pack(n: int, pick: Ints, rays: Rays, t: Floats, packed: Rays, packed_t: Floats) -> None:
    """Copy the rays `pick` and their distances to the front."""
    ox, oy, oz, dx, dy, dz = rays
    px, py, pz, ux, uy, uz = packed
    for j in range(n):
        i = pick[j]
        px[j], py[j], pz[j], ux[j], uy[j], uz[j] = ox[i], oy[i], oz[i], dx[i], dy[i], dz[i]
        packed_t[j] = t[i]


@kernel
def meet_shape(
    n: int, rays: Rays, packed: Rays, kind: int, c: Vec, m: Mat, size: Vec, ball: float, s: int, best: Floats, who: Ints,
    pick: Ints, near: Ints, t: Floats,
) -> int:  # fmt: skip
    """Try one shape on all rays of a tile. Returns: for how many it is the nearest so far."""
    if kind == PLANE:
        meet_plane(n, rays, c, (m[2], m[5], m[8]), t)
        return keep_nearer(n, t, s, best, who)
    if kind == SPHERE:
        meet_sphere(n, rays, c, size[0], t)
        return keep_nearer(n, t, s, best, who)
    near_ball(n, rays, c, ball, best, near)
    some = picked(n, near, 1, pick)
    chosen = rays
    if some < n:
        pack(some, pick, rays, best, packed, t)
        chosen = packed
    if kind == BOX:
        meet_box(some, chosen, c, m, size, t)
    elif kind == CAPSULE:
        meet_capsule(some, chosen, c, m, size, t)
    else:
        meet_cylinder(some, chosen, c, m, size, t)
    return keep_nearer_picked(some, pick, t, s, best, who)


@stream
def clear(n: int, who: Ints, best: Floats, body: Ints, part: Ints, facing: Triple) -> None:
    """The answers of rays that meet nothing; those of the others are written next."""
    x, y, z = facing
    for i in range(n):
        best[i] = best[i] if who[i] >= 0 else math.inf
        body[i], part[i] = -1, -1
        x[i], y[i], z[i] = 0.0, 0.0, 0.0


@stream
def label(n: int, owner: int, place: int, body: Ints, part: Ints) -> None:
    """The same shape for all rays."""
    for i in range(n):
        body[i], part[i] = owner, place


@stream
def scatter(n: int, pick: Ints, owner: int, place: int, packed: Triple, body: Ints, part: Ints, facing: Triple) -> None:
    """Shape and normals to the rays `pick`."""
    u, v, w = packed
    x, y, z = facing
    for j in range(n):
        i = pick[j]
        body[i], part[i] = owner, place
        x[i], y[i], z[i] = u[j], v[j], w[j]


@stream
def answer(
    n: int, at: int, to: int, best: Floats, own: Ints, role: Ints, facing: Triple, distance: Floats, body: Ints, part: Ints,
    normal: Floats,
) -> None:  # fmt: skip
    """Copy the answers of a row of rays."""
    x, y, z = facing
    there, here = np.uint64(at), np.uint64(to)
    for i in range(np.uint64(n)):
        distance[there + i] = best[here + i]
        body[there + i] = own[here + i]
        part[there + i] = role[here + i]
    for i in range(np.uint64(n)):
        normal[there + i, 0], normal[there + i, 1], normal[there + i, 2] = x[here + i], y[here + i], z[here + i]


@kernel
def cast_tile_range(
    floats: Floats, ints: Ints, origins: Floats, directions: Floats, row: int, wide: int, first_tile: int, last_tile: int,
    max_range: float, distance: Floats, body: Ints, part: Ints, normal: Floats,
) -> bool:  # fmt: skip
    """As `cast_tiles`, for the tiles from first_tile up to, but not with, last_tile."""
    shape, shape_kind = floats_of(floats, ints, SHAPE), ints_of(ints, SHAPE_KIND)
    rows_of, pose, ball = pose_primitives(floats, ints)
    k = len(pose)
    reach, order = np.empty(k), np.empty(k + 1, np.int64)
    a, places = np.empty((21, TILE)), np.empty((5, TILE), np.int64)
    rays, packed = (a[0], a[1], a[2], a[3], a[4], a[5]), (a[6], a[7], a[8], a[9], a[10], a[11])
    facing, packed_facing = (a[12], a[13], a[14]), (a[15], a[16], a[17])
    best, t, length = a[18], a[19], a[20]
    who, pick, near, own, role = places[0], places[1], places[2], places[3], places[4]
    high, across, rows = TILE // wide, (row + wide - 1) // wide, directions.shape[0] // max(row, 1)
    for tile in range(first_tile, last_tile):
        top, left = tile // across * high, tile % across * wide
        tall, broad = min(high, rows - top), min(wide, row - left)
        n, start = tall * broad, top * row + left
        if not load_tile(origins, directions, start, row, broad, tall, rays, length):
            return False
        apex, spread = origin_ball(n, rays)
        axis = middle_of(n, broad, rays)
        cull(k, ball, apex, spread, axis, narrowest(n, rays, axis), reach)
        reach_planes(k, rows_of, shape_kind, pose, apex, spread, reach)
        count, winners = candidates(k, reach, order), 0
        start_search(n, np.nextafter(max_range, math.inf), best, who)
        for c in range(count):
            p = order[c]
            if not any_beyond(n, best, reach[p]):
                break
            s = rows_of[p]
            if meet_shape(
                n, rays, packed, shape_kind[s, TYPE], load3(pose, p, 0), load9(pose, p, 3), load3(shape, s, SIZE), ball[3, p],
                p, best, who, pick, near, t,
            ):  # fmt: skip
                order[winners] = p
                winners += 1
        clear(n, who, best, own, role, facing)
        for c in range(winners):
            p = order[c]
            s, some = rows_of[p], picked(n, who, p, pick)
            kind, centre, m, size = shape_kind[s, TYPE], load3(pose, p, 0), load9(pose, p, 3), load3(shape, s, SIZE)
            if some == n:
                normals_of(n, rays, best, kind, centre, m, size, facing)
                label(n, shape_kind[s, OWNER], shape_kind[s, PART], own, role)
            elif some > 0:
                pack(some, pick, rays, best, packed, t)
                normals_of(some, packed, t, kind, centre, m, size, packed_facing)
                scatter(some, pick, shape_kind[s, OWNER], shape_kind[s, PART], packed_facing, own, role, facing)
        for line in range(tall):
            answer(broad, start + line * row, line * broad, best, own, role, facing, distance, body, part, normal)
    return True


@entry
def cast_tiles(
    floats: Floats, ints: Ints, origins: Floats, directions: Floats, max_range: float,
    distance: Floats, body: Ints, part: Ints, normal: Floats,
) -> bool:  # fmt: skip
    """Write distance [m], body, shape of the body and outward normal in W of each ray's first hit; inf, -1, -1 and 0 without.

    Args:
        origins (r, 3) m, or (1, 3) for all rays; directions (r, 3), of any length; distance, body, part (r,); normal (r, 3).
    Returns: False, with the answers unfinished, where an origin is not finite or a direction not finite or zero.
    """
    row, wide, tiles = layout(directions)
    return cast_tile_range(
        floats, ints, origins, directions, row, wide, 0, tiles, max_range, distance, body, part, normal
    )  # fmt: skip
