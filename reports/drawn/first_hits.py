"""What parallel rays meet first: depth, normal and paint at each pixel of a view, over all solids."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from reports.drawn.convex import entered
from reports.drawn.meshes import splatted
from reports.drawn.solids import Solid
from reports.drawn.view import View
from reports.recordings.rotation import Floats

__all__ = ["Hits", "first_hits"]


@dataclass(frozen=True, slots=True, eq=False)
class Hits:
    """Terms: height (h, w) m towards the eye, -inf where nothing is met. normal (h, w, 3) in the view. paint (h, w, 3)."""

    height: Floats
    normal: Floats
    paint: Floats


def first_hits(view: View, solids: Sequence[Solid]) -> Hits:
    """All solids through the middles of the pixels."""
    size = (view.height, view.width)
    hits = Hits(np.full(size, -np.inf), np.zeros((*size, 3)), np.zeros((*size, 3)))
    across = (np.arange(view.width) + 0.5 - view.width / 2) * view.pixel
    up = (view.height / 2 - np.arange(view.height) - 0.5) * view.pixel
    for solid in solids:
        if solid.shape["type"] == "triangle_mesh":
            splatted(view, solid, hits.height, hits.normal, hits.paint)
        else:
            _cast(view, solid, across, up, hits)
    return hits


def _cast(view: View, solid: Solid, across: Floats, up: Floats, hits: Hits) -> None:
    centre, R_VS = view.seen(solid.p), view.R @ solid.R
    left, right, top, bottom = _window(solid, centre, R_VS, across, up)
    if left >= right or top >= bottom:
        return
    x, y = np.meshgrid(across[left:right] - centre[0], up[top:bottom] - centre[1])
    o = np.stack([x.ravel(), y.ravel(), np.zeros(x.size)], axis=1) @ R_VS
    met = entered(solid.shape, o, -R_VS[2])
    if met is None:
        return
    t, normal = met
    height = (centre[2] - t).reshape(x.shape)
    room = np.s_[top:bottom, left:right]
    nearer = height > hits.height[room]
    turned = normal @ R_VS.T
    turned /= np.maximum(np.linalg.norm(turned, axis=1, keepdims=True), 1e-300)
    hits.height[room][nearer] = height[nearer]
    hits.normal[room][nearer] = turned.reshape(*x.shape, 3)[nearer]
    hits.paint[room][nearer] = solid.paint


def _window(solid: Solid, centre: Floats, R_VS: Floats, across: Floats, up: Floats) -> tuple[int, int, int, int]:
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
