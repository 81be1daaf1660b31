"""What one difference is worth: the torque that makes up for it.

A with B's value in the one place is another robot: its residual torques are those that have to be exerted on A's motion. So the
differences of a pair are told apart.
"""

from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace

import numpy as np

from plumbline.harness.scene.importers.poses import Array
from plumbline.harness.scene.parity.facts import JointFacts, MassFacts, RobotFacts
from plumbline.harness.scene.parity.motion import Configuration, first_rates, passive

Change = Callable[[RobotFacts], RobotFacts]
_UNITS = {"revolute": "N m", "prismatic": "N", "ball": "N m", "free": "N m or N"}


SWEEP = 2 * np.pi
"""Angular frequency [rad/s] of the motion that excites what has to do with accelerations."""


@dataclass(frozen=True, slots=True, eq=False)
class Reference:
    """A robot in motion. Terms: motions: states, each with the accelerations of all its rates and the forces that they take."""

    robot: RobotFacts
    gravity: Array
    motions: tuple[tuple[Configuration, Array, Array], ...]


def reference(robot: RobotFacts, gravity: Array, states: Sequence[Configuration], seed: int = 0) -> Reference:
    """The robot as it moves by itself, where all its coordinates have inertia, and in a sweep of all its joints.

    In the sweep each joint is anywhere within a sine of SWEEP whose rate comes to 1 rad/s or m/s, or its bound: what gravity
    alone does not excite, a rotor about an upright axis say, counts too.
    """
    rng = np.random.default_rng(seed)
    speeds = np.repeat([min(1.0, joint.speed or 1.0) for joint in robot.joints], np.diff(first_rates(robot)))
    motions = []
    for state in states:
        M, forces = passive(robot, state, gravity)
        with suppress(np.linalg.LinAlgError):
            free = np.asarray(np.linalg.solve(M, -forces), dtype=np.float64)
            motions.append((state, free, M @ free + forces))
        for swing in (0.0, np.pi / 2):
            phase = rng.choice((0.0, np.pi), len(speeds)) + swing
            swept = Configuration(state.q, state.turned, speeds * np.cos(phase))
            M, forces = passive(robot, swept, gravity)
            pushed: Array = SWEEP * speeds * np.sin(phase)
            motions.append((swept, pushed, M @ pushed + forces))
    return Reference(robot, gravity, tuple(motions))


def worth(of: Reference, change: Change) -> tuple[float, str]:
    """The largest torque that a change takes, at the worst of the motions and joints, and its unit."""
    changed = change(of.robot)
    residuals = []
    for state, acceleration, taken in of.motions:
        M, forces = passive(changed, state, of.gravity)
        residuals.append(np.abs(M @ acceleration + forces - taken))
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
