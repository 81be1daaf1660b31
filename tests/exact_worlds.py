"""Boxes and balls on a ground for tests of the exact contact solver, and what is called exact."""

from typing import Any

import numpy as np

from plumbline import engine

__all__ = ["G", "DT", "DEFAULT", "GROUND", "EXACT", "surface", "cube", "ball", "world_of", "residual"]


G, DT = 9.81, 1 / 240
DEFAULT = ("default", "default")
GROUND = engine.Body(name="ground", motion="static", shapes=[engine.Placed(engine.Plane())])
EXACT = 1e-10
"""What is called exact: round-off, 1e-16, times the largest ratio of masses, 1e4, times a hundred for sums."""


def surface(friction: float = 0.0, restitution: float = 0.0) -> engine.Surface:
    return engine.Surface(static_friction=friction, kinetic_friction=friction, restitution=restitution)


def cube(name: str = "cube", mass: float = 1.0, half: float = 0.1, **state: Any) -> engine.Body:
    inertia = mass * (2 * half) ** 2 / 6 * np.eye(3)
    return engine.Body(name=name, mass=mass, inertia=inertia, shapes=[engine.Placed(engine.Box((half,) * 3))], **state)


def ball(name: str = "ball", mass: float = 1.0, radius: float = 0.1, **state: Any) -> engine.Body:
    inertia = 0.4 * mass * radius**2 * np.eye(3)
    return engine.Body(name=name, mass=mass, inertia=inertia, shapes=[engine.Placed(engine.Sphere(radius))], **state)


def world_of(
    bodies: list[engine.Body], law: engine.Surface, gravity: tuple[float, float, float] = (0, 0, -G), **chosen: Any
) -> engine.World:
    options = engine.Options(solver="exact", substeps=1, **chosen)
    return engine.World([GROUND, *bodies], surfaces={DEFAULT: law}, gravity=gravity, options=options)


def residual(world: engine.World) -> float:
    assert world.certificate is not None
    assert world.certificate.solves > 0
    return world.certificate.residual
