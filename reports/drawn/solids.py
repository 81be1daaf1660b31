"""The solids of a picture: shapes of a scene file placed in the world, each with its paint."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from reports.recordings.rotation import Floats, product, rotate
from reports.recordings.shapes import placed_shapes

__all__ = ["Solid", "fixed_solids", "solids_of"]

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
class Solid:
    """A shape in W. Terms: shape: as in a scene file. p (3,) m, R (3, 3): where it is. paint (3,): linear light."""

    shape: Mapping[str, Any]
    p: Floats
    R: Floats
    paint: Floats


def solids_of(
    bodies: Sequence[Mapping[str, Any]], p_WB: Floats, q_WB: Floats, *, fade: float = 0.0, larger: float = 1.0
) -> list[Solid]:
    """Shapes of what moves, at poses (n, 3) m and (n, 4). Args: fade: 0 as they are, 1 palest; larger: how many times."""
    placed: list[Solid] = []
    for k, body in enumerate(bodies):
        if body["motion"] != "static":
            paint = _paint(body, k)
            placed += _placed(body, p_WB[k], q_WB[k], paint + fade * PALE * (1.0 - paint), larger)
    return placed


def fixed_solids(bodies: Sequence[Mapping[str, Any]]) -> list[Solid]:
    """Bounded shapes of what never moves."""
    return [
        solid
        for k, body in enumerate(bodies)
        if body["motion"] == "static"
        for solid in _placed(body, np.asarray(body.get("p_WB", (0.0, 0.0, 0.0))), np.asarray(body.get("q_WB", (1.0, 0, 0, 0))),
                             _paint(body, k), 1.0)
    ]  # fmt: skip


def _placed(body: Mapping[str, Any], p_WB: Floats, q_WB: Floats, paint: Floats, larger: float) -> list[Solid]:
    placed: list[Solid] = []
    for shape in placed_shapes(body):
        if shape["shape"]["type"] != "plane":
            q = product(q_WB, np.asarray(shape.get("q_BS", (1.0, 0.0, 0.0, 0.0)), dtype=np.float64))
            p = p_WB + rotate(q_WB, larger * np.asarray(shape.get("p_BS", (0.0, 0.0, 0.0)), dtype=np.float64))
            placed.append(Solid(_scaled(shape["shape"], larger), p, rotate(np.broadcast_to(q, (3, 4)), np.eye(3)).T, paint))
    return placed


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
