"""Where rays enter convex shapes: on the surface, from outside, with the normal of the surface, and never where they miss."""

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
import pytest

from plumbline.reports.drawn.first_hits import entered, half_spaces
from plumbline.reports.recordings.layout import Floats

CUBE = [(x, y, z) for x in (-1.0, 1.0) for y in (-1.0, 1.0) for z in (-1.0, 1.0)]
HULL = {"type": "convex_hull", "vertices": [*CUBE, (0.0, 0.0, 2.0)]}
AXES = np.array([0.3, 0.5, 0.8])


def rim(points: Floats) -> Floats:
    return np.hypot(points[:, 0], points[:, 1])


def in_hull(points: Floats) -> Floats:
    normals, distances = half_spaces(HULL)
    return (points @ normals.T - distances).max(axis=1)


SHAPES: dict[str, tuple[Mapping[str, Any], Callable[[Floats], Floats]]] = {
    # Each with a function that is negative inside, zero on the surface and positive outside.
    "sphere": ({"type": "sphere", "radius": 0.7}, lambda p: np.linalg.norm(p, axis=1) - 0.7),
    "ellipsoid": ({"type": "ellipsoid", "semi_axes": AXES.tolist()}, lambda p: np.linalg.norm(p / AXES, axis=1) - 1.0),
    "box": ({"type": "box", "half_extents": AXES.tolist()}, lambda p: (np.abs(p) - AXES).max(axis=1)),
    "cylinder": (
        {"type": "cylinder", "radius": 0.4, "half_length": 0.9},
        lambda p: np.maximum(rim(p) - 0.4, np.abs(p[:, 2]) - 0.9),
    ),
    "capsule": (
        {"type": "capsule", "radius": 0.4, "half_length": 0.6},
        lambda p: np.hypot(rim(p), np.maximum(np.abs(p[:, 2]) - 0.6, 0.0)) - 0.4,
    ),
    "convex_hull": (HULL, in_hull),
}


@pytest.mark.parametrize("name", list(SHAPES))
def test_rays_enter_where_the_surface_is_and_miss_what_they_miss(name: str) -> None:
    shape, depth = SHAPES[name]
    rng = np.random.default_rng(5)
    for d in (np.array([0.0, 0.0, -1.0]), np.array([1.0, 0.0, 0.0]), np.array([0.6, -0.48, 0.64])):
        side = np.linalg.svd(d[None])[2][1:]
        o = rng.uniform(-1.6, 1.6, (400, 2)) @ side - 5.0 * d
        t, normal = entered(shape, o, d)
        hit = np.isfinite(t)
        assert 10 < hit.sum() < 390
        at = o[hit] + t[hit, None] * d
        # Roots of a quadratic from 5 m away: 1e-16 x 25 m2 of rounding over the smallest root that is cut here.
        assert np.abs(depth(at)).max() < 1e-6
        assert (depth(at - 1e-3 * d) > 0).all()
        assert (normal[hit] @ d < 1e-9).all()
        steps = o[~hit, None] + np.linspace(0.0, 10.0, 2001)[:, None] * d
        # A ray that misses lies outside all along, but for one that grazes: 5 mm between the samples.
        assert (depth(steps.reshape(-1, 3)) > -5e-3).all()


def test_what_has_no_end_or_is_not_convex_is_left_to_others() -> None:
    assert entered({"type": "plane"}, np.zeros((1, 3)), np.array([0.0, 0.0, 1.0])) is None
    assert entered({"type": "triangle_mesh", "vertices": [], "faces": []}, np.zeros((1, 3)), np.array([0.0, 0.0, 1.0])) is None
