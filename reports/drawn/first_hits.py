"""What parallel rays meet first: depth, normal and paint at each pixel of a view, over all solids.

Where parallel rays enter a convex shape: the first hit with its normal, in closed form, for all rays at once.

Rays start at o (n, 3) in the axes of the shape and go along one direction d (3,); a hit is a distance t (n,), infinite where
there is none, with a normal (n, 3).  Source: A. S. Glassner (ed.), An Introduction to Ray Tracing (1989), chapters 2 and 3.

Triangles of a mesh into the same pixels: small ones all at once, large ones one by one, nearest last.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from plumbline.reports.drawn.solids import DrawnSolid
from plumbline.reports.drawn.view import View
from plumbline.reports.recordings.layout import Floats

TINY = 1e-12


def entered(shape: Mapping[str, Any], o: Floats, d: Floats) -> tuple[Floats, Floats] | None:
    """The first hit of each ray; None for a shape that is not convex or has no end."""
    match shape["type"]:
        case "sphere":
            return _ellipsoid(np.full(3, float(shape["radius"])), o, d)
        case "ellipsoid":
            return _ellipsoid(np.asarray(shape["semi_axes"], dtype=np.float64), o, d)
        case "box":
            half = np.asarray(shape["half_extents"], dtype=np.float64)
            return _polyhedron(np.concatenate([np.eye(3), -np.eye(3)]), np.concatenate([half, half]), o, d)
        case "cylinder":
            return _cylinder(float(shape["radius"]), float(shape["half_length"]), o, d)
        case "capsule":
            return _capsule(float(shape["radius"]), float(shape["half_length"]), o, d)
        case "convex_hull":
            return _polyhedron(*half_spaces(shape), o, d)
    return None


def half_spaces(shape: Mapping[str, Any]) -> tuple[Floats, Floats]:
    """Outward normals (m, 3) and distances (m,) m of a hull's faces."""
    from scipy.spatial import ConvexHull  # late: only hulls need it

    faces = np.unique(ConvexHull(np.asarray(shape["vertices"], dtype=np.float64)).equations.round(12), axis=0)
    return faces[:, :3], -faces[:, 3]


def _quadratic(a: Any, b: Floats, c: Floats) -> tuple[Floats, Floats]:
    """Both roots of a t^2 + 2 b t + c, infinities where there are none: plus before minus, so that nothing lies between."""
    inside = b * b - a * c
    root = np.sqrt(np.maximum(inside, 0.0))
    missed = inside < 0
    return np.where(missed, np.inf, (-b - root) / a), np.where(missed, -np.inf, (-b + root) / a)


def _ellipsoid(axes: Floats, o: Floats, d: Floats) -> tuple[Floats, Floats]:
    u, v = o / axes, d / axes
    t, _ = _quadratic(v @ v, u @ v, np.einsum("ij,ij->i", u, u) - 1.0)
    normal = (u + np.where(np.isfinite(t), t, 0.0)[:, None] * v) / axes
    return t, normal


def _polyhedron(normals: Floats, distances: Floats, o: Floats, d: Floats) -> tuple[Floats, Floats]:
    """Enters through the last of the faces that are turned towards the rays, before it leaves by the first of the others."""
    rate = normals @ d
    facing, leaving = rate < -TINY, rate > TINY
    if not facing.any() or not leaving.any():
        return np.full(len(o), np.inf), np.zeros_like(o)
    reach = (distances - o @ normals.T) / np.where(np.abs(rate) > TINY, rate, 1.0)
    first = reach[:, facing].argmax(axis=1)
    t = reach[:, facing][np.arange(len(o)), first]
    missed = t > reach[:, leaving].min(axis=1)
    aside = ~facing & ~leaving
    missed |= (o @ normals[aside].T > distances[aside]).any(axis=1)
    return np.where(missed, np.inf, t), normals[facing][first]


def _side(radius: float, o: Floats, d: Floats) -> tuple[Floats, Floats]:
    """In and out of an endless cylinder about z."""
    a, c = d[0] ** 2 + d[1] ** 2, o[:, 0] ** 2 + o[:, 1] ** 2 - radius**2
    if a < TINY:
        return np.where(c < 0, -np.inf, np.inf), np.where(c < 0, np.inf, -np.inf)
    return _quadratic(a, o[:, 0] * d[0] + o[:, 1] * d[1], c)


def _cylinder(radius: float, half: float, o: Floats, d: Floats) -> tuple[Floats, Floats]:
    into, out = _side(radius, o, d)
    sign = -1.0 if d[2] > 0 else 1.0
    if abs(d[2]) < TINY:
        inside = np.abs(o[:, 2]) < half
        cap, leave = np.where(inside, -np.inf, np.inf), np.where(inside, np.inf, -np.inf)
    else:
        cap, leave = (sign * half - o[:, 2]) / d[2], (-sign * half - o[:, 2]) / d[2]
    t = np.maximum(into, cap)
    t = np.where((t < np.minimum(out, leave)) & np.isfinite(t), t, np.inf)
    at = o + np.where(np.isfinite(t), t, 0.0)[:, None] * d
    round_normal = at * [1.0, 1.0, 0.0]
    return t, np.where((into >= cap)[:, None], round_normal, np.array([0.0, 0.0, sign]))


def _capsule(radius: float, half: float, o: Floats, d: Floats) -> tuple[Floats, Floats]:
    into, _ = _side(radius, o, d)
    z = o[:, 2] + np.where(np.isfinite(into), into, 0.0) * d[2]
    t = np.where(np.isfinite(into) & (np.abs(z) <= half), into, np.inf)
    at = o + np.where(np.isfinite(t), t, 0.0)[:, None] * d
    normal = at * [1.0, 1.0, 0.0]
    for end in (-half, half):
        s, n = _ellipsoid(np.full(3, radius), o - [0.0, 0.0, end], d)
        nearer = s < t
        t, normal = np.where(nearer, s, t), np.where(nearer[:, None], n, normal)
    return t, normal


SMALL = 6
"""Pixels: triangles within a square of this side are filled together."""


def splatted(view: View, solid: DrawnSolid, height: Floats, normal: Floats, paint: Floats) -> None:
    """Fill depth (h, w) m, normals (h, w, 3) and paint (h, w, 3) where the mesh lies nearer than what is there."""
    vertices = view.seen(np.asarray(solid.shape["vertices"], dtype=np.float64) @ solid.R.T + solid.p)
    corners = vertices[np.asarray(solid.shape["faces"], dtype=np.int64)]
    across = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    facing = across[:, 2] > 0
    corners, across = corners[facing], across[facing] / np.linalg.norm(across[facing], axis=1, keepdims=True)
    x, y = corners[..., 0] / view.pixel + view.width / 2, view.height / 2 - corners[..., 1] / view.pixel
    left, top = np.floor(x.min(axis=1) - 0.5).astype(int), np.floor(y.min(axis=1) - 0.5).astype(int)
    wide, high = np.ceil(x.max(axis=1)).astype(int) - left + 1, np.ceil(y.max(axis=1)).astype(int) - top + 1
    small = (wide <= SMALL) & (high <= SMALL)
    batches: list[tuple[Floats, tuple[int, int]]] = [(np.flatnonzero(small), (SMALL, SMALL))]
    batches += [(np.array([k]), (int(high[k]), int(wide[k]))) for k in np.flatnonzero(~small)]
    for chosen, side in batches:
        if len(chosen):
            _fill(x[chosen], y[chosen], corners[chosen, :, 2], across[chosen], left[chosen], top[chosen], side,
                  solid.paint, height, normal, paint)  # fmt: skip


def _fill(
    x: Floats, y: Floats, z: Floats, across: Floats, left: Floats, top: Floats, side: tuple[int, int],
    colour: Floats, height: Floats, normal: Floats, paint: Floats,
) -> None:  # fmt: skip
    """Triangles (m, 3) in pixels, each within `side` rows and columns from its top left corner."""
    rows, columns = np.arange(side[0]), np.arange(side[1])
    u = (left[:, None, None] + columns[None, None, :]).astype(int)
    v = (top[:, None, None] + rows[None, :, None]).astype(int)
    px, py = u + 0.5, v + 0.5
    (ax, bx, cx), (ay, by, cy), (az, bz, cz) = ([a[:, k, None, None] for k in range(3)] for a in (x, y, z))
    area = (bx - ax) * (cy - ay) - (cx - ax) * (by - ay)
    area = np.where(area == 0, np.inf, area)
    beta = ((px - ax) * (cy - ay) - (cx - ax) * (py - ay)) / area
    gamma = ((bx - ax) * (py - ay) - (px - ax) * (by - ay)) / area
    inside = (beta >= 0) & (gamma >= 0) & (beta + gamma <= 1) & np.isfinite(area)
    inside &= (u >= 0) & (u < height.shape[1]) & (v >= 0) & (v < height.shape[0])
    near = az + beta * (bz - az) + gamma * (cz - az)
    which, r, c = np.nonzero(inside)
    near, u, v = near[which, r, c], u[which, 0, c], v[which, r, 0]
    ahead = near > height[v, u]
    order = np.argsort(near[ahead], kind="stable")  # of several in one pixel the last written stays: the nearest
    u, v, near, which = u[ahead][order], v[ahead][order], near[ahead][order], which[ahead][order]
    height[v, u], normal[v, u], paint[v, u] = near, across[which], colour


@dataclass(frozen=True, slots=True, eq=False)
class FirstHits:
    """Terms: height (h, w) m towards the eye, -inf where nothing is met. normal (h, w, 3) in the view. paint (h, w, 3)."""

    height: Floats
    normal: Floats
    paint: Floats


def first_hits(view: View, solids: Sequence[DrawnSolid], shaded: bool = True) -> FirstHits:
    """All solids through the middles of the pixels. Args: shaded: without, normals and paints stay zero: for shadows."""
    size = (view.height, view.width)
    hits = FirstHits(np.full(size, -np.inf), np.zeros((*size, 3)), np.zeros((*size, 3)))
    across = (np.arange(view.width) + 0.5 - view.width / 2) * view.pixel
    up = (view.height / 2 - np.arange(view.height) - 0.5) * view.pixel
    for solid in solids:
        if solid.shape["type"] == "triangle_mesh":
            splatted(view, solid, hits.height, hits.normal, hits.paint)
        else:
            _cast(view, solid, across, up, hits, shaded)
    return hits


def _cast(view: View, solid: DrawnSolid, across: Floats, up: Floats, hits: FirstHits, shaded: bool) -> None:
    centre, R_VS = view.seen(solid.p), view.R @ solid.R
    left, right, top, bottom = _window(solid, centre, R_VS, across, up)
    if left >= right or top >= bottom:
        return
    room = np.s_[top:bottom, left:right]
    x, y = across[left:right] - centre[0], up[top:bottom, None] - centre[1]
    met = _ball(float(solid.shape["radius"]), x, y) if solid.shape["type"] == "sphere" else _entered(solid, R_VS, x, y)
    if met is None:
        return
    t, normal = met
    height = centre[2] - t
    nearer = height > hits.height[room]
    hits.height[room][nearer] = height[nearer]
    if shaded:
        turned = normal(nearer)
        turned /= np.maximum(np.sqrt(np.einsum("ij,ij->i", turned, turned))[:, None], 1e-300)
        hits.normal[room][nearer] = turned
        hits.paint[room][nearer] = solid.paint


_Met = tuple[Floats, Callable[[Floats], Floats]]
"""Distances (h, w) m from the plane of the middle, and what gives normals (k, 3) in the view at chosen places (h, w)."""


def _ball(radius: float, x: Floats, y: Floats) -> _Met:
    """A sphere looks the same from everywhere: what lies over (x, y) m of its middle, x (w,) and y (h, 1)."""
    over = radius * radius - x * x - y * y
    high = np.sqrt(np.maximum(over, 0.0))

    def normal(at: Floats) -> Floats:
        return np.stack([np.broadcast_to(x, at.shape)[at], np.broadcast_to(y, at.shape)[at], high[at]], axis=1)

    return np.where(over < 0, np.inf, -high), normal


def _entered(solid: DrawnSolid, R_VS: Floats, x: Floats, y: Floats) -> _Met | None:
    """Any other convex solid."""
    size = (len(y), len(x))
    o = np.empty((*size, 3))
    o[..., 0], o[..., 1], o[..., 2] = x, y, 0.0
    met = entered(solid.shape, o.reshape(-1, 3) @ R_VS, -R_VS[2])
    if met is None:
        return None
    t, normal = met
    return t.reshape(size), lambda at: normal[at.ravel()] @ R_VS.T


def _window(solid: DrawnSolid, centre: Floats, R_VS: Floats, across: Floats, up: Floats) -> tuple[int, int, int, int]:
    """The columns and rows [left, right), [top, bottom) in which a solid can be met."""
    shape = solid.shape
    if shape["type"] == "box":
        low_high = np.abs(R_VS[:2]) @ np.asarray(shape["half_extents"], dtype=np.float64)
        x0, x1, y0, y1 = -low_high[0], low_high[0], -low_high[1], low_high[1]
    elif shape["type"] == "convex_hull":
        seen = np.asarray(shape["vertices"], dtype=np.float64) @ R_VS[:2].T
        (x0, y0), (x1, y1) = seen.min(axis=0), seen.max(axis=0)
    else:
        reach = max([shape.get("radius", 0.0) + shape.get("half_length", 0.0), *shape.get("semi_axes", ())])
        x0, x1, y0, y1 = -reach, reach, -reach, reach
    left, right = np.searchsorted(across, (centre[0] + x0, centre[0] + x1))
    top, bottom = np.searchsorted(-up, (-(centre[1] + y1), -(centre[1] + y0)))
    return int(left), int(right), int(top), int(bottom)
