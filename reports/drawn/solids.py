"""The solids of a picture: shapes of a scene file placed in the world, each with its paint.

A container that moves is drawn without the walls towards the eye, so that what is in it can be seen.

What of a scene never moves, as far as a picture shows it: the ground, and solids that do not stand in the way.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from plumbline.harness.trajectory.kinematics import product, rotate
from plumbline.reports.drawn.view import View
from plumbline.reports.recordings.layout import Floats
from plumbline.reports.recordings.shapes import placed_shapes

STATED = (0.8, 0.8, 0.8)
"""What a scene file has where no colour is stated."""
FIXED = (0.42, 0.46, 0.52)
MOVING = (
    (0.16, 0.40, 0.66),
    (0.86, 0.44, 0.13),
    (0.16, 0.53, 0.42),
    (0.62, 0.32, 0.55),
    (0.80, 0.62, 0.16),
    (0.34, 0.55, 0.74),
)
"""Linear light. Colours of bodies whose scene states none, in turn."""
PALE = 0.55
"""How far earlier instants of one picture fade to white."""


@dataclass(frozen=True, slots=True, eq=False)
class DrawnSolid:
    """A shape in W. Terms: shape: as in a scene file. p (3,) m, R (3, 3): where it is. paint (3,): linear light."""

    shape: Mapping[str, Any]
    p: Floats
    R: Floats
    paint: Floats


def solids_of(
    bodies: Sequence[Mapping[str, Any]], p_WB: Floats, q_WB: Floats, *, fade: float = 0.0, larger: float = 1.0
) -> list[DrawnSolid]:
    """Shapes of what moves, at poses (n, 3) m and (n, 4). Args: fade: 0 as they are, 1 palest; larger: how many times."""
    moving = [k for k, body in enumerate(bodies) if body["motion"] != "static"]
    paints = [_paint(bodies[k], k) for k in moving]
    paints = [paint + fade * PALE * (1.0 - paint) for paint in paints]
    return _placed([bodies[k] for k in moving], p_WB[moving], q_WB[moving], paints, larger)


def fixed_solids(bodies: Sequence[Mapping[str, Any]]) -> list[DrawnSolid]:
    """Bounded shapes of what never moves."""
    places = [k for k, body in enumerate(bodies) if body["motion"] == "static"]
    fixed, paints = [bodies[k] for k in places], [_paint(bodies[k], k) for k in places]
    p_WB = np.array([body.get("p_WB", (0.0, 0.0, 0.0)) for body in fixed], dtype=np.float64)
    q_WB = np.array([body.get("q_WB", (1.0, 0.0, 0.0, 0.0)) for body in fixed], dtype=np.float64)
    return _placed(fixed, p_WB, q_WB, paints, 1.0)


def _placed(
    bodies: Sequence[Mapping[str, Any]], p_WB: Floats, q_WB: Floats, paints: Sequence[Floats], larger: float
) -> list[DrawnSolid]:
    """The shapes of bodies (n) with an end, at poses (n, 3) m and (n, 4), all turned at once."""
    found = [(k, s) for k, body in enumerate(bodies) for s in placed_shapes(body) if s["shape"]["type"] != "plane"]
    if not found:
        return []
    of = [k for k, _ in found]
    p_BS = np.array([shape.get("p_BS", (0.0, 0.0, 0.0)) for _, shape in found], dtype=np.float64)
    q_BS = np.array([shape.get("q_BS", (1.0, 0.0, 0.0, 0.0)) for _, shape in found], dtype=np.float64)
    q_WS = product(q_WB[of], q_BS)
    p_WS = p_WB[of] + rotate(q_WB[of], larger * p_BS)
    axes = rotate(np.broadcast_to(q_WS[:, None], (len(found), 3, 4)), np.eye(3))
    return [
        DrawnSolid(_scaled(shape["shape"], larger), p_WS[k], axes[k].T, paints[body]) for k, (body, shape) in enumerate(found)
    ]


def _paint(body: Mapping[str, Any], place: int) -> Floats:
    stated = tuple(body.get("appearance", {}).get("colour", STATED))
    if stated != STATED:
        return np.clip(np.array(stated, dtype=np.float64), 0.0, 1.0)
    return np.array(FIXED if body["motion"] == "static" else MOVING[place % len(MOVING)])


def _scaled(shape: Mapping[str, Any], factor: float) -> Mapping[str, Any]:
    if factor == 1.0:
        return shape
    lengths = ("radius", "half_length", "half_extents", "semi_axes", "vertices")
    return {name: (factor * np.asarray(value)).tolist() if name in lengths else value for name, value in shape.items()}


WALLS = 4
"""A body of fewer shapes encloses nothing."""
NEAR = 0.15
"""Of the distance of the farthest wall from the middle: a wall nearer to the eye than this stands in the way."""
CONJUGATE = np.array([1.0, -1.0, -1.0, -1.0])


def opened(bodies: Sequence[Mapping[str, Any]], p_WB: Floats, q_WB: Floats, towards: Floats) -> list[Mapping[str, Any]]:
    """The bodies at poses (n, 3) m and (n, 4); one that holds most of what else moves has its far walls alone.

    Args: towards (3,): the direction from the scene to the eye, of unit length.
    """
    moving = [k for k, body in enumerate(bodies) if body["motion"] != "static"]
    shown = list(bodies)
    for k in moving:
        shapes, others = placed_shapes(bodies[k]), [other for other in moving if other != k]
        if len(shapes) < WALLS or not others:
            continue
        walls = np.array([shape.get("p_BS", (0.0, 0.0, 0.0)) for shape in shapes], dtype=np.float64)
        back = q_WB[k] * CONJUGATE
        held = rotate(np.broadcast_to(back, (len(others), 4)), p_WB[others] - p_WB[k])
        if np.mean(((held > walls.min(axis=0)) & (held < walls.max(axis=0))).all(axis=1)) <= 0.5:
            continue
        out = walls - walls.mean(axis=0)
        near = out @ rotate(back, towards) > NEAR * np.linalg.norm(out, axis=1).max()
        shown[k] = {**bodies[k], "visual": [shape for shape, hides in zip(shapes, near, strict=True) if not hides]}
    return shown


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
