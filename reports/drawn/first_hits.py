"""What parallel rays meet first: depth, normal and paint at each pixel of a view, over all solids."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from plumbline.reports.drawn.convex import entered
from plumbline.reports.drawn.meshes import splatted
from plumbline.reports.drawn.solids import DrawnSolid
from plumbline.reports.drawn.view import View
from plumbline.reports.recordings.rotation import Floats


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
