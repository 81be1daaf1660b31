"""What one difference is worth: the torque that makes up for it, and where the robot is after a second with it.

A with B's value in the one place is another robot: its residual torques are those that have to be exerted on A's motion, and
its passive motion is followed beside A's from the same state. So the differences of a pair are told apart.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from harness.scene.importers.poses import Array
from harness.scene.parity.facts import JointFacts, MassFacts, RobotFacts
from harness.scene.parity.motion import Configuration, after, first_rates, motion_size, passive

Change = Callable[[RobotFacts], RobotFacts]
_UNITS = {"revolute": ("N m", "rad"), "prismatic": ("N", "m"), "ball": ("N m", "rad"), "free": ("N m or N", "rad")}


@dataclass(frozen=True, slots=True, eq=False)
class Reference:
    """A robot at its states. Terms: accelerations: of its passive motion, one a state. end: a second after the first one."""

    robot: RobotFacts
    gravity: Array
    states: tuple[Configuration, ...]
    accelerations: tuple[Array, ...]
    end: Configuration | None


@dataclass(frozen=True, slots=True, kw_only=True)
class Effect:
    """Terms: as in Difference."""

    torque: float | None = None
    torque_unit: str = ""
    motion: float | None = None
    motion_unit: str = ""


def reference(robot: RobotFacts, gravity: Array, states: Sequence[Configuration]) -> Reference | None:
    """The robot's own passive motion; None where one of its coordinates has no inertia."""
    try:
        accelerations: list[Array] = []
        for state in states:
            M, forces = passive(robot, state, gravity)
            accelerations.append(np.asarray(np.linalg.solve(M, -forces), dtype=np.float64))
    except np.linalg.LinAlgError:
        return None
    end = after(robot, states[0], gravity) if states else None
    return Reference(robot, gravity, tuple(states), tuple(accelerations), end)


def worth(of: Reference, change: Change, follow: bool) -> Effect:
    """The effect of a change. Args: follow: is the motion followed too?"""
    changed = change(of.robot)
    residuals = []
    for state, acceleration in zip(of.states, of.accelerations, strict=True):
        M, forces = passive(changed, state, of.gravity)
        residuals.append(np.abs(M @ acceleration + forces))
    most = np.max(residuals, axis=0)
    starts = first_rates(of.robot)
    worst = int(np.searchsorted(starts, int(np.argmax(most)), side="right")) - 1
    effect = Effect(torque=float(most.max()), torque_unit=_UNITS[of.robot.joints[worst].kind][0])
    if not follow or of.end is None:
        return effect
    end = after(changed, of.states[0], of.gravity)
    if end is None:
        return effect
    sizes = motion_size(of.robot, of.end, end)
    farthest = int(np.argmax(sizes))
    return replace(effect, motion=sizes[farthest], motion_unit=_UNITS[of.robot.joints[farthest].kind][1])


def joint_changed(name: str, **fields: object) -> Change:
    """A change of one joint's fields."""

    def change(robot: RobotFacts) -> RobotFacts:
        joints: tuple[JointFacts, ...] = tuple(
            replace(joint, **fields) if joint.name == name else joint  # type: ignore[arg-type]
            for joint in robot.joints
        )
        return replace(robot, joints=joints)

    return change


def mass_changed(name: str, **fields: object) -> Change:
    """A change of the fields of what one joint moves."""

    def change(robot: RobotFacts) -> RobotFacts:
        solid = robot.masses.get(name) or MassFacts(
            joint=name, members=(), mass=0.0, centre=np.zeros(3), inertia=np.zeros((3, 3))
        )
        return replace(robot, masses={**robot.masses, name: replace(solid, **fields)})  # type: ignore[arg-type]

    return change
