"""What one difference is worth: the torque that makes up for it.

A with B's value in the one place is another robot: its residual torques are those that have to be exerted on A's motion. So the
differences of a pair are told apart.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from plumbline.harness.scene.importers.poses import Array
from plumbline.harness.scene.parity.facts import JointFacts, MassFacts, RobotFacts
from plumbline.harness.scene.parity.motion import Configuration, first_rates, passive

Change = Callable[[RobotFacts], RobotFacts]
_UNITS = {"revolute": "N m", "prismatic": "N", "ball": "N m", "free": "N m or N"}


@dataclass(frozen=True, slots=True, eq=False)
class Reference:
    """A robot at its states. Terms: accelerations: of its passive motion, one a state."""

    robot: RobotFacts
    gravity: Array
    states: tuple[Configuration, ...]
    accelerations: tuple[Array, ...]


def reference(robot: RobotFacts, gravity: Array, states: Sequence[Configuration]) -> Reference | None:
    """The robot's own passive motion; None where one of its coordinates has no inertia."""
    try:
        accelerations: list[Array] = []
        for state in states:
            M, forces = passive(robot, state, gravity)
            accelerations.append(np.asarray(np.linalg.solve(M, -forces), dtype=np.float64))
    except np.linalg.LinAlgError:
        return None
    return Reference(robot, gravity, tuple(states), tuple(accelerations))


def worth(of: Reference, change: Change) -> tuple[float, str]:
    """The largest torque that makes up for a change, at the worst of the states and joints, and its unit."""
    changed = change(of.robot)
    residuals = []
    for state, acceleration in zip(of.states, of.accelerations, strict=True):
        M, forces = passive(changed, state, of.gravity)
        residuals.append(np.abs(M @ acceleration + forces))
    most = np.max(residuals, axis=0)
    worst = int(np.searchsorted(first_rates(of.robot), int(np.argmax(most)), side="right")) - 1
    return float(most.max()), _UNITS[of.robot.joints[worst].kind]


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
