"""What of a scene never moves, as far as a picture shows it: the ground, and solids that do not stand in the way."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from plumbline.reports.drawn.solids import DrawnSolid, fixed_solids
from plumbline.reports.drawn.view import View
from plumbline.reports.recordings.rotation import Floats, product, rotate

UNTURNED = (1.0, 0.0, 0.0, 0.0)
LARGE = 0.7
"""Of the diagonal of a picture: a solid beyond this is scenery, a floor or a wall."""


@dataclass(frozen=True, slots=True, eq=False)
class GroundPlane:
    """An endless plane through p (3,) m with its normal (3,) in W."""

    p: Floats
    normal: Floats


def stage_set(bodies: Sequence[Mapping[str, Any]], view: View) -> tuple[list[DrawnSolid], GroundPlane | None]:
    """The fixed solids that are drawn, and the ground: the first plane, or the top of a large box that all stands on."""
    ground = _plane(bodies)
    shown: list[DrawnSolid] = []
    diagonal = view.pixel * float(np.hypot(view.width, view.height))
    for solid in fixed_solids(bodies):
        if _reach(solid) < LARGE * diagonal:
            shown.append(solid)
            continue
        top = _top(solid)
        below = top is not None and top[2] <= view.middle[2] + 0.25 * diagonal and _holds(solid, view.middle)
        if below and top is not None:
            ground = ground or GroundPlane(
                top, solid.R[:, int(np.abs(solid.R[2]).argmax())] * np.sign(solid.R[2][np.abs(solid.R[2]).argmax()])
            )
        elif float(view.R[2] @ (solid.p - view.middle)) < -0.2 * diagonal and not _holds(solid, view.middle):
            shown.append(solid)
    return shown, ground


def _reach(solid: DrawnSolid) -> float:
    shape = solid.shape
    if "vertices" in shape:
        return float(np.linalg.norm(np.asarray(shape["vertices"]), axis=1).max())
    sizes = [
        *shape.get("half_extents", ()),
        *shape.get("semi_axes", ()),
        shape.get("radius", 0.0) + shape.get("half_length", 0.0),
    ]
    return float(max(sizes))


def _top(solid: DrawnSolid) -> Floats | None:
    """The middle of the face of a box that looks up; None for other shapes."""
    if solid.shape["type"] != "box":
        return None
    axis = int(np.abs(solid.R[2]).argmax())
    middle: Floats = solid.p + np.sign(solid.R[2, axis]) * solid.R[:, axis] * solid.shape["half_extents"][axis]
    return middle


def _holds(solid: DrawnSolid, point: Floats) -> bool:
    """Does a point lie within the sides of a box, seen from above?"""
    if solid.shape["type"] != "box":
        return False
    axis = int(np.abs(solid.R[2]).argmax())
    inside = np.abs((point - solid.p) @ solid.R) <= np.asarray(solid.shape["half_extents"])
    return bool(np.delete(inside, axis).all())


def _plane(bodies: Sequence[Mapping[str, Any]]) -> GroundPlane | None:
    for body in bodies:
        for placed in body.get("collision", []):
            if placed["shape"]["type"] == "plane" and body["motion"] == "static":
                q = np.asarray(body.get("q_WB", UNTURNED), dtype=np.float64)
                turned = product(q, np.asarray(placed.get("q_BS", UNTURNED), dtype=np.float64))
                normal = rotate(turned, np.asarray(placed["shape"].get("normal", (0.0, 0.0, 1.0)), dtype=np.float64))
                offset = rotate(q, np.asarray(placed.get("p_BS", (0.0, 0.0, 0.0)), dtype=np.float64))
                return GroundPlane(np.asarray(body.get("p_WB", (0.0, 0.0, 0.0)), dtype=np.float64) + offset, normal)
    return None
