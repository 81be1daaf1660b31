"""Bullets, a wall and a mesh for tests of swept continuous collision, and the worlds that they fly in."""

from collections.abc import Sequence

import numpy as np

from plumbline import engine

__all__ = ["DT", "DEFAULT", "ROCK", "SHAPES", "WALL", "RING", "FAN", "SHEET", "bullet_of", "world_of"]


DT = 1 / 240
DEFAULT = ("default", "default")
ROCK = np.random.default_rng(11).normal(size=(24, 3)) * (0.05, 0.03, 0.04)
SHAPES: dict[str, engine.Shape] = {
    "sphere": engine.Sphere(0.05),
    "capsule": engine.Capsule(0.02, 0.06),
    "box": engine.Box((0.05, 0.03, 0.02)),
    "cylinder": engine.Cylinder(0.04, 0.05),
    "hull": engine.ConvexHull(ROCK.tolist()),
}
WALL = engine.Body(name="wall", motion="static", shapes=[engine.Placed(engine.Box((0.005, 1, 1)))])
RING = [(0, -1, -1), (0, 1, -1), (0, 1, 1), (0, -1, 1), (0, 0, 0)]
FAN = engine.TriangleMesh(RING, [(1, 0, 4), (2, 1, 4), (3, 2, 4), (0, 3, 4)])
SHEET = engine.Body(name="sheet", motion="static", shapes=[engine.Placed(FAN)])
"""A mesh of four triangles without thickness, whose outer side looks to -x."""


def bullet_of(shape: engine.Shape, name: str = "bullet", **state: object) -> engine.Body:
    """A body of 1 kg with the inertia of its size, and not the same about every axis."""
    return engine.Body(name=name, inertia=np.diag([2.0, 2.5, 1.2]) * 1e-3, shapes=[engine.Placed(shape)], **state)  # type: ignore[arg-type]


def world_of(
    bodies: Sequence[engine.Body], law: engine.Surface | None = None, gravity: Sequence[float] = (0, 0, 0), **options: object
) -> engine.World:
    chosen = engine.Options(**({"continuous": "swept"} | options))  # type: ignore[arg-type]
    return engine.World(bodies, surfaces={DEFAULT: law or engine.Surface()}, gravity=gravity, options=chosen)
