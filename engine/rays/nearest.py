"""The nearest shape of each ray of a tile, tried shape by shape, and what the rays say of it.

Source: Wald, Boulos, Shirley, Ray Tracing Deformable Scenes using Dynamic Bounding Volume Hierarchies, 2007 (tests for groups
of rays).
"""

import math

from plumbline.engine.compile.jit import kernel, stream
from plumbline.engine.maths.rows import Floats, Ints
from plumbline.engine.memory import arena as at
from plumbline.engine.rays.streams import Primitive, Rays, Triple, meet, near_ball
from plumbline.engine.rays.tiling import TileHits


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
def picked(n: int, wanted: Ints, value: int, pick: Ints) -> int:
    """Write the places where wanted[i] = value, which may be where they are wanted. Returns: how many."""
    count = 0
    for i in range(n):
        found = wanted[i] == value
        pick[count] = i
        count += found
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
def meet_shape(n: int, rays: Rays, shape: Primitive, best: Floats, who: Ints, packed: Rays, pick: Ints, t: Floats) -> int:
    """Try one shape on all rays of a tile; packed, pick, t: room. Returns: for how many it is the nearest so far."""
    if shape.kind in (at.PLANE, at.SPHERE):
        meet(n, rays, shape, t)
        return keep_nearer(n, t, shape.number, best, who)
    near_ball(n, rays, shape.centre, shape.ball, best, pick)
    some = picked(n, pick, 1, pick)
    chosen = rays
    if some < n:
        pack(some, pick, rays, best, packed, t)
        chosen = packed
    meet(some, chosen, shape, t)
    return keep_nearer_picked(some, pick, t, shape.number, best, who)


@stream
def clear(n: int, who: Ints, hits: TileHits) -> None:
    """The answers of rays that meet nothing; those of the others are written next."""
    best, body, shape, (x, y, z) = hits
    for i in range(n):
        best[i] = best[i] if who[i] >= 0 else math.inf
        body[i], shape[i] = -1, -1
        x[i], y[i], z[i] = 0.0, 0.0, 0.0


@stream
def label(n: int, owner: int, part: int, body: Ints, shape: Ints) -> None:
    """The same shape for all rays."""
    for i in range(n):
        body[i], shape[i] = owner, part


@stream
def scatter(n: int, pick: Ints, owner: int, part: int, normal: Triple, hits: TileHits) -> None:
    """Shape and normals to the rays `pick`."""
    u, v, w = normal
    _, body, shape, (x, y, z) = hits
    for j in range(n):
        i = pick[j]
        body[i], shape[i] = owner, part
        x[i], y[i], z[i] = u[j], v[j], w[j]
