"""Triangles of a mesh into the same pixels: small ones all at once, large ones one by one, nearest last."""

import numpy as np

from plumbline.reports.drawn.solids import DrawnSolid
from plumbline.reports.drawn.view import View
from plumbline.reports.recordings.rotation import Floats

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
