"""The solids of a picture: shapes of a scene file placed in the world, each with its paint."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from plumbline.reports.recordings.rotation import Floats, product, rotate
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
