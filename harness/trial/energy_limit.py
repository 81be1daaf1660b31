"""The kinetic energy beyond which a run has blown up: finite numbers that nothing in the scene can have paid for.

What can: the kinetic energy and that of springs at the start, a fall for the whole of the run, and drives that push with their
limit in one direction all the time. A drive without a limit, an effort, a body that is led and a force from outside can give
anything; what they ask for at the start is counted, and they leave more room. Engines err by shares of what is in play, not by
a million times it.
"""

from dataclasses import dataclass

import numpy as np

from plumbline.harness.adapter import Diverged
from plumbline.harness.scene import WORLD, Body, Prismatic, Revolute, Scene
from plumbline.harness.trajectory import Floats, Integers, State
from plumbline.harness.trajectory.kinematics import movable, rotate_back

TIMES, TIMES_UNLIMITED = 1e6, 1e12
"""Of the energy that can be there: where all sources are limited, and where one has no limit."""


@dataclass(frozen=True, slots=True)
class EnergyLimit:
    """Terms: bodies (m,): places of those that a force moves, with their mass (m,) kg and inertia (m, 3, 3) kg m2. payable [J]:
    the energy that can be there. most [J]: beyond it a run has diverged; infinite where nothing is in play."""

    bodies: Integers
    mass: Floats
    inertia: Floats
    payable: float
    most: float

    @classmethod
    def of(cls, scene: Scene, duration: float, *, pushed: bool = False) -> "EnergyLimit":
        """Of a scene that runs for `duration` [s]. Args: pushed: does a force from outside act on it?"""
        places = movable(scene)
        mass = np.array([scene.bodies[index].mass for index in places])
        inertia = np.array([scene.bodies[index].inertia for index in places]).reshape(-1, 3, 3)
        start = State.initial(scene)
        payable = float(np.sum(_kinetic(start, places, mass, inertia)))
        fall = np.linalg.norm(start.v_WB[places], axis=1) + np.linalg.norm(scene.gravity) * duration
        payable += float(np.sum(mass * fall**2)) / 2
        unlimited = pushed
        for joint in scene.joints:
            spring = getattr(joint, "spring", None)
            if spring is not None and isinstance(joint, Revolute | Prismatic):
                payable += spring.stiffness * (joint.position - spring.rest) ** 2 / 2
            elif spring is not None:
                length = float(np.linalg.norm(np.subtract(joint.anchor_W, joint.child_anchor_W)))  # type: ignore[union-attr]
                payable += spring.stiffness * (length - spring.rest) ** 2 / 2
            if isinstance(joint, Revolute | Prismatic) and joint.effort is not None:
                unlimited = True
            if isinstance(joint, Revolute | Prismatic) and joint.drive is not None:
                energy, limited = _of_drive(scene, joint, duration)
                payable, unlimited = payable + energy, unlimited or not limited
        for body in scene.bodies:
            if body.motion == "kinematic":
                v_WB, w_WB = body.velocity_at_start
                unlimited, payable = True, payable + float(mass.sum()) * float(np.dot(v_WB, v_WB) + np.dot(w_WB, w_WB)) / 2
        times = TIMES_UNLIMITED if unlimited else TIMES
        return cls(places, mass, inertia, payable, times * payable if payable > 0 else np.inf)

    def check(self, state: State) -> None:
        """Raises: Diverged, where a state has more."""
        energy = float(np.sum(_kinetic(state, self.bodies, self.mass, self.inertia)))
        if energy > self.most:
            raise Diverged(
                f"kinetic energy {energy:.3g} J, more than {self.most / self.payable:.0e} times the {self.payable:.3g} J that "
                "the scene can give"
            )


def _kinetic(state: State, places: Integers, mass: Floats, inertia: Floats) -> Floats:
    """Of each body, (m,) J."""
    with np.errstate(over="ignore", invalid="ignore"):
        w_B = rotate_back(state.q_WB[places], state.w_WB[places])
        energy: Floats = (mass * np.sum(state.v_WB[places] ** 2, axis=1) + np.einsum("bi,bij,bj->b", w_B, inertia, w_B)) / 2
    return energy


def _of_drive(scene: Scene, joint: Revolute | Prismatic, duration: float) -> tuple[float, bool]:
    """What a drive may give [J], and whether that is all: a force F on a mass m for a time T gives F^2 T^2 / (2 m)."""
    drive = joint.drive
    assert drive is not None
    ends = [scene.body(name) for name in (joint.parent, joint.child) if name != WORLD and scene.body(name).movable]
    yields = sum(1 / felt for body in ends if (felt := _felt(body, joint)) > 0)
    constant = drive.feedforward is not None and not (drive.stiffness or drive.damping)
    limit = abs(drive.feedforward or 0.0) if constant and drive.limit is None else drive.limit
    if limit is not None:
        return (limit * duration) ** 2 * yields / 2, True
    pulled = drive.stiffness * (drive.target - joint.position) ** 2 / 2
    return pulled + (drive.target_velocity**2 / (2 * yields) if yields else 0.0), False


def _felt(body: Body, joint: Revolute | Prismatic) -> float:
    """The least that a joint may feel of a body: its mass [kg], or its moment [kg m2] about the axis through its centre."""
    if isinstance(joint, Prismatic):
        return body.mass
    axis_B = rotate_back(np.array(body.q_WB), np.array(joint.axis_W))
    return float(axis_B @ np.array(body.inertia) @ axis_B)
