"""Triangles drawn as pixels: an orthographic view with a depth buffer, each triangle in one shade by how it faces the light."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from reports.recordings.rotation import Floats

__all__ = ["View", "drawn", "view_of"]

LIGHT = np.array([0.35, -0.55, 0.76])
"""Towards the light, in W."""
AMBIENT = 0.45
"""Of what faces away from the light."""


@dataclass(frozen=True, slots=True, eq=False)
class View:
    """Where a picture is taken from. Terms: R (3, 3): right, up and towards the eye in W. middle (3,) m; scale [pixels/m]."""

    R: Floats
    middle: Floats
    scale: float
    width: int
    height: int


def view_of(points: Floats, width: int, height: int, eye: tuple[float, float, float] = (0.8, -1.0, 0.45)) -> View:
    """The view from a direction that shows all points (n, 3) m."""
    towards = np.asarray(eye) / np.linalg.norm(eye)
    right = np.cross([0.0, 0.0, 1.0], towards)
    right /= np.linalg.norm(right)
    R = np.stack([right, np.cross(towards, right), towards])
    seen = points @ R.T
    low, high = seen.min(axis=0), seen.max(axis=0)
    wide = np.maximum(high - low, 1e-9)
    scale = 0.9 * min(width / wide[0], height / wide[1])
    return View(R, R.T @ ((low + high) / 2), float(scale), width, height)


def drawn(view: View, triangles: Floats, colours: Floats, background: tuple[int, int, int]) -> NDArray[np.uint8]:
    """A picture (h, w, 3) of triangles (m, 3, 3) m in W with colours (m, 3) of 0..1 for screens; back faces are left out."""
    pixels = np.empty((view.height, view.width, 3), dtype=np.uint8)
    pixels[:] = background
    depth = np.full((view.height, view.width), -np.inf)
    normal = np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0])
    length = np.linalg.norm(normal, axis=1)
    facing = (length > 0) & (normal @ view.R[2] > 0)
    normal, shown = normal[facing] / length[facing, None], triangles[facing]
    bright = AMBIENT + (1 - AMBIENT) * np.clip(normal @ LIGHT, 0.0, 1.0)
    paint = np.rint(255 * np.clip(colours[facing] * bright[:, None], 0.0, 1.0)).astype(np.uint8)
    seen = (shown - view.middle) @ view.R.T
    x, y = view.width / 2 + view.scale * seen[..., 0], view.height / 2 - view.scale * seen[..., 1]
    first_x, last_x = np.floor(x.min(axis=1)).astype(int), np.ceil(x.max(axis=1)).astype(int)
    first_y, last_y = np.floor(y.min(axis=1)).astype(int), np.ceil(y.max(axis=1)).astype(int)
    for k in range(len(shown)):
        left, right = max(first_x[k], 0), min(last_x[k], view.width - 1)
        top, bottom = max(first_y[k], 0), min(last_y[k], view.height - 1)
        if left > right or top > bottom:
            continue
        (ax, bx, cx), (ay, by, cy), (az, bz, cz) = x[k], y[k], seen[k, :, 2]
        area = (bx - ax) * (cy - ay) - (cx - ax) * (by - ay)
        if area == 0:
            continue
        px, py = np.arange(left, right + 1) + 0.5, (np.arange(top, bottom + 1) + 0.5)[:, None]
        beta = ((px - ax) * (cy - ay) - (cx - ax) * (py - ay)) / area
        gamma = ((bx - ax) * (py - ay) - (px - ax) * (by - ay)) / area
        z = az + beta * (bz - az) + gamma * (cz - az)
        room = np.s_[top : bottom + 1, left : right + 1]
        inside = (beta >= 0) & (gamma >= 0) & (beta + gamma <= 1) & (z > depth[room])
        depth[room][inside] = z[inside]
        pixels[room][inside] = paint[k]
    return pixels
