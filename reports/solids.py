"""Shapes of a scene file as triangles, for pictures that are drawn on a page."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from reports.recordings.rotation import Floats, rotate
from reports.recordings.shapes import facets, frame, placed_shapes

__all__ = ["triangles_of"]

AROUND, ALONG = 20, 8
"""Faces about the axis of a round shape, and from pole to pole of a ball."""


def triangles_of(body: Mapping[str, Any]) -> Floats:
    """The triangles (m, 3, 3) m of what is drawn of a body, in B, counter-clockwise from outside; planes are left out."""
    surfaces = []
    for placed in placed_shapes(body):
        shape = placed["shape"]
        if shape["type"] == "plane":
            continue
        corners = _triangles(shape)
        turned = rotate(np.broadcast_to(frame(placed), (*corners.shape[:2], 4)), corners)
        surfaces.append(turned + np.asarray(placed.get("p_BS", (0.0, 0.0, 0.0))))
    return np.concatenate(surfaces) if surfaces else np.zeros((0, 3, 3))


def _triangles(shape: Mapping[str, Any]) -> Floats:
    match shape["type"]:
        case "sphere":
            return _turned(shape["radius"], 0.0)
        case "ellipsoid":
            ball: Floats = _turned(1.0, 0.0) * np.asarray(shape["semi_axes"], dtype=np.float64)
            return ball
        case "capsule":
            return _turned(shape["radius"], shape["half_length"])
        case "cylinder":
            r, h = shape["radius"], shape["half_length"]
            return _about(np.array([(0.0, -h), (r, -h), (r, h), (0.0, h)]))
        case "box":
            signs = [(x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]
            corners = np.array(signs) * np.asarray(shape["half_extents"], dtype=np.float64)
            return facets({"type": "convex_hull", "vertices": corners})[0].reshape(-1, 3, 3)
        case _:
            return facets(shape)[0].reshape(-1, 3, 3)


def _turned(radius: float, half_length: float) -> Floats:
    """A ball whose halves are drawn apart along z."""
    angles = np.linspace(-np.pi / 2, np.pi / 2, ALONG + 1)
    lift = np.where(angles < 0, -half_length, half_length)
    profile = np.stack([radius * np.cos(angles), radius * np.sin(angles) + lift], axis=1)
    if half_length > 0:
        middle = ALONG // 2
        low = np.array([[radius, -half_length]])
        profile = np.concatenate([profile[:middle], low, profile[middle:]])
    return _about(profile)


def _about(profile: Floats) -> Floats:
    """The surface that a line of (r, z) sweeps about z, from the bottom to the top."""
    angles = np.linspace(0.0, 2 * np.pi, AROUND + 1)
    r, z = profile[:, 0, None], profile[:, 1, None]
    ring = np.stack([r * np.cos(angles), r * np.sin(angles), np.broadcast_to(z, (len(profile), AROUND + 1))], axis=-1)
    a, b, c, d = ring[:-1, :-1], ring[:-1, 1:], ring[1:, 1:], ring[1:, :-1]
    both = np.concatenate([np.stack([a, b, c], axis=2).reshape(-1, 3, 3), np.stack([a, c, d], axis=2).reshape(-1, 3, 3)])
    area = np.linalg.norm(np.cross(both[:, 1] - both[:, 0], both[:, 2] - both[:, 0]), axis=1)
    faces: Floats = both[area > 0]
    return faces
