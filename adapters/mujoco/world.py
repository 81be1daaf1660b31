"""A compiled scene: model, state, and where the scene's bodies, drives and sensors stand in them."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from plumbline.harness.adapter.between import MasslessChain
from plumbline.harness.scene import Scene
from plumbline.harness.trajectory import Floats, Integers


@dataclass(frozen=True, slots=True)
class Hung:
    """A joint by which a body hangs.

    Terms: body: the place in the scene of the body with mass that it moves. native: MuJoCo's joint, -1 of a weld. turned: is it
    the scene's parent? anchor_M (3,): the anchor in the principal frame M of the scene's child [m], None where that has no
    mass.
    """

    body: int
    native: int
    turned: bool
    anchor_M: Floats | None


@dataclass(frozen=True, slots=True)
class Indices:
    """Where the scene's bodies, drives and sensors stand in the compiled model.

    Terms:
        body (n,): MuJoCo's body of each body of the scene, of one without mass that of the body behind it. chains: of these.
        owner (ngeom,): the body of the scene that a geom is a shape of. q_MB (n, 4): from B to the principal frame M, or None
        where all of them agree. single: no body hangs on another one. drives: actuator by joint. hung: the native joints and
        welds, by name. inertial: indices of accelerometer and gyroscope in the sensor data, by sensor.
    """

    body: Integers
    owner: Integers
    q_MB: Floats | None
    single: bool
    drives: Mapping[str, int]
    hung: Mapping[str, Hung]
    inertial: Mapping[str, tuple[int, int]]
    chains: Sequence[MasslessChain]


@dataclass(frozen=True, slots=True)
class World:
    """The vendor's module, an `MjModel`, its `MjData`, the scene and its indices in both."""

    mj: Any
    model: Any
    state: Any
    scene: Scene
    indices: Indices

    def renew_poses(self) -> None:
        """Poses and velocities of the present coordinates; `mj_step` leaves those of before the step and computes them anew."""
        self.mj.mj_kinematics(self.model, self.state)
        self.mj.mj_comPos(self.model, self.state)
        self.mj.mj_comVel(self.model, self.state)
