"""A model of MuJoCo as far as it is written, before it is compiled."""

from dataclasses import dataclass, field
from typing import Any


@dataclass(slots=True)
class Draft:
    """An `MjSpec` with what the functions of the builder have put into it; each adds its own.

    Terms:
        bodies: MuJoCo's body of each body, by its place in the scene. planted: the shapes that stand in the world's own body,
        with the place of theirs, by name. meshes: how many there are. drives: actuator by joint. inertial: the sensors with
        MuJoCo's accelerometer and gyroscope, by name. rebounds: has some pair restitution? pressed: the pairs of
        materials that take `fast_steps`. damped_joints: is the damping of drives the joints'?
    """

    mj: Any
    spec: Any
    bodies: dict[int, Any] = field(default_factory=dict)
    planted: dict[str, int] = field(default_factory=dict)
    meshes: int = 0
    drives: dict[str, int] = field(default_factory=dict)
    inertial: list[str] = field(default_factory=list)
    rebounds: bool = False
    pressed: frozenset[frozenset[str]] = frozenset()
    damped_joints: bool = False
