"""Bodies, surfaces and worlds that the tests of Bullet's adapter share."""

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from plumbline.adapters.bullet import ADAPTER
from plumbline.harness.adapter import Settings, Simulation
from plumbline.harness.conformance.frames import rotation
from plumbline.harness.scene import (
    Body,
    Box,
    PlacedShape,
    Scene,
    Shape,
    Sphere,
    Surface,
    axis_angle,
    box_inertia,
    multiply,
    sphere_inertia,
)
from plumbline.harness.trajectory import State

__all__ = [
    "COORDINATES",
    "DEFAULT",
    "G",
    "GROUND",
    "MAXIMAL",
    "MULTIBODY",
    "NOWHERE",
    "TUNED",
    "TURNED",
    "ball",
    "built",
    "law",
    "solid",
    "state_of",
    "tensor",
    "with_options",
]

G = 9.81
NOWHERE = (0.0, 0.0, 0.0)
TURNED = multiply(axis_angle((0.0, 0.0, 1.0), 0.7), axis_angle((1.0, 2.0, 3.0), 1.1))
DEFAULT, TUNED = ADAPTER.tracks["default"], ADAPTER.tracks["tuned"]


def with_options(settings: Settings, **options: Any) -> Settings:
    return replace(settings, options={**settings.options, **options})


MULTIBODY, MAXIMAL = with_options(TUNED, coordinates="multibody"), with_options(TUNED, coordinates="maximal")
COORDINATES = pytest.mark.parametrize("settings", [MULTIBODY, MAXIMAL], ids=["multibody", "maximal"])


@contextmanager
def built(scene: Scene, settings: Settings) -> Iterator[Simulation]:
    simulation = ADAPTER.build(scene, settings)
    try:
        yield simulation
    finally:
        simulation.close()


def state_of(simulation: Simulation, scene: Scene) -> State:
    state = State.empty(len(scene.bodies))
    simulation.state(state)
    return state


def tensor(*moments: float) -> Any:
    """A tensor with these principal moments about axes that no axis of B lies along: all products count."""
    R = rotation(axis_angle((3.0, 1.0, 2.0), 0.8))
    return tuple(map(tuple, (R @ np.diag(moments) @ R.T).tolist()))


def solid(shape: Shape, name: str = "body", mass: float = 2.0, **more: Any) -> Body:
    inertia = more.pop("inertia", box_inertia(mass, (0.2, 0.15, 0.1)))
    return Body(name=name, mass=mass, inertia=inertia, material="solid", collision=(PlacedShape(shape=shape),), **more)


def ball(radius: float = 0.1, **more: Any) -> Body:
    return solid(Sphere(radius=radius), mass=1.0, inertia=sphere_inertia(1.0, radius), **more)


GROUND = Body(
    name="ground",
    motion="static",
    material="ground",
    p_WB=(0.0, 0.0, -0.5),
    collision=(PlacedShape(shape=Box(half_extents=(20.0, 20.0, 0.5))),),
)


def law(friction: float = 0.0, restitution: float = 0.0, pair: tuple[str, str] = ("ground", "solid"), **more: float) -> Surface:
    return Surface(between=pair, static_friction=friction, kinetic_friction=friction, restitution=restitution, **more)
