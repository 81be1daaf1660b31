"""Bodies, surfaces and worlds that the tests of MuJoCo's adapter share."""

import numpy as np
import pytest

from plumbline.adapters.mujoco import ADAPTER
from plumbline.adapters.mujoco.simulation import MujocoSimulation
from plumbline.harness.adapter import Settings
from plumbline.harness.scene import (
    Body,
    Box,
    PlacedShape,
    Revolute,
    Scene,
    Shape,
    Surface,
    Vector3,
    box_inertia,
    rotation_matrix,
    sphere_inertia,
)
from plumbline.harness.trajectory import Floats, State

__all__ = [
    "BOTH",
    "DEFAULT",
    "G",
    "TUNED",
    "built",
    "ground_body",
    "hinge_at",
    "matrix",
    "on_ground",
    "shaped_body",
    "stack",
    "state_of",
]

G = 9.81
DEFAULT, TUNED = ADAPTER.tracks["default"], ADAPTER.tracks["tuned"]
BOTH = pytest.mark.parametrize("settings", [DEFAULT, TUNED], ids=["default", "tuned"])


def built(scene: Scene, settings: Settings = DEFAULT, dt: float = 1e-3) -> MujocoSimulation:
    return ADAPTER.build(scene, settings.with_dt(dt))


def state_of(simulation: MujocoSimulation, scene: Scene) -> State:
    out = State.empty(len(scene.bodies))
    simulation.state(out)
    return out


def matrix(q: Floats) -> Floats:
    w, x, y, z = (float(c) for c in q)
    return np.array(rotation_matrix((w, x, y, z)))


def shaped_body(
    name: str, shape: Shape, p: Vector3, material: str = "block", mass: float = 1.0, v: Vector3 = (0.0, 0.0, 0.0)
) -> Body:
    inertia = box_inertia(mass, shape.half_extents) if isinstance(shape, Box) else sphere_inertia(mass, 0.1)
    return Body(name=name, mass=mass, inertia=inertia, p_WB=p, v_WB=v, material=material, collision=(PlacedShape(shape=shape),))


def ground_body(shape: Shape | None = None, p: Vector3 = (0.0, 0.0, -0.5)) -> Body:
    placed = PlacedShape(shape=shape or Box(half_extents=(20.0, 20.0, 0.5)))
    return Body(name="ground", motion="static", material="ground", p_WB=p, collision=(placed,))


def on_ground(*bodies: Body, mu: float = 0.0, e: float = 0.0) -> Scene:
    pairs = [("ground", "block")] + ([("block", "block")] if len(bodies) > 1 else [])
    return Scene(
        bodies=(ground_body(), *bodies),
        surfaces=tuple(Surface(between=pair, static_friction=mu, kinetic_friction=mu, restitution=e) for pair in pairs),
    )


def stack(n: int, mu: float = 0.5) -> Scene:
    half = (0.1, 0.1, 0.1)
    return on_ground(*(shaped_body(f"box{k}", Box(half_extents=half), (0.0, 0.0, 0.1 + 0.2 * k)) for k in range(n)), mu=mu)


def hinge_at(name: str, parent: str, child: str, p: Vector3, **extra: object) -> Revolute:
    return Revolute(name=name, parent=parent, child=child, anchor_W=p, axis_W=(0.0, 1.0, 0.0), **extra)  # type: ignore[arg-type]
