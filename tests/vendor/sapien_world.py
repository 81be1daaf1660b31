"""Worlds and bodies of PhysX, in sapien's own words."""

import warnings
from typing import Any

import pytest

with warnings.catch_warnings():
    warnings.simplefilter("ignore")
    sapien = pytest.importorskip("sapien", reason="installed when it is asked for")
    physx = pytest.importorskip("sapien.physx")

G = 9.81


def world(gravity: tuple[float, float, float] = (0.0, 0.0, -G), dt: float = 1 / 240, **scene: Any) -> tuple[Any, Any]:
    physx.set_scene_config(gravity=list(gravity), **scene)
    physx.set_body_config(solver_position_iterations=10, solver_velocity_iterations=1, sleep_threshold=0.0)
    physx.set_shape_config(contact_offset=0.01)
    system = physx.PhysxCpuSystem()
    system.timestep = dt
    return sapien.Scene([system]), system


def put(scene: Any, component: Any, p: tuple[float, float, float], mass: float = 1.0, moments: float = 0.01) -> Any:
    entity = sapien.Entity()
    entity.add_component(component)
    if hasattr(component, "mass"):
        component.mass, component.inertia = mass, [moments] * 3
        component.linear_damping = component.angular_damping = 0.0
    entity.pose = sapien.Pose(list(p))
    scene.add_entity(entity)
    return entity


def weightless(shape: Any) -> Any:
    shape.density = 0.0
    return shape
