"""Springs and drives: the coordinate of a joint that they act on, and the laws by which the adapter sets them."""

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

import numpy as np

from harness.adapter import Notice
from harness.scene import Drive, Spring
from harness.trajectory import Floats

__all__ = ["AT_REST", "SERVO_NOTICE", "Laws", "Motor", "Pushes", "by_skeleton"]

SERVO_NOTICE = Notice(
    "drives: DART's own servo holds the velocity (c u + k (target - x))/(c + dt k) by whatever force within the limit: another "
    "law than the scene's k (target - x) + c (u - x')"
)


AT_REST = 1e-9
"""The rate [rad/s or m/s] below which dry friction holds a joint: what DART's solver leaves of one is 1e-11."""


@dataclass(slots=True)
class Motor:
    """A joint coordinate with its spring and drive: what the adapter sets, or works out in every step."""

    joint: Any
    skeleton: Any
    spring: Spring
    drive: Drive
    target: float
    stable: bool = False
    servo: bool = False
    push: float = 0.0

    @property
    def limited(self) -> bool:
        """Has the drive a limit?"""
        return self.drive.limit is not None

    @property
    def works(self) -> bool:
        """Is there something to be worked out in every step?"""
        return self.stable or self.servo or self.limited or self.push != 0.0

    def rest(self) -> None:
        """Let spring and unlimited drive share DART's joint spring; what its rest cannot hold becomes a constant push."""
        if self.stable:
            return
        spring, drive = self.spring, self.drive
        shared = not (self.limited or self.servo)
        k = spring.stiffness + (drive.stiffness if shared else 0.0)
        force = spring.stiffness * spring.rest
        if shared:
            force += drive.stiffness * self.target + drive.damping * drive.target_velocity
            force += drive.feedforward or 0.0
        # DART refuses a rest position outside of the limits and says so on the console only.
        rest = min(max(force / k, self.joint.getPositionLowerLimit(0)), self.joint.getPositionUpperLimit(0)) if k > 0 else 0.0
        if k > 0:
            self.joint.setSpringStiffness(0, k)
            self.joint.setRestPosition(0, rest)
            rest = float(self.joint.getRestPosition(0))
        self.joint.setDampingCoefficient(0, spring.damping + (drive.damping if shared else 0.0))
        self.push = force - k * rest


class Laws:
    """Springs and drives of one skeleton as arrays (2, m), springs first, one column a motor: a force [N m or N] is `still` less
    slope * v, v the velocity at the end of a step.

    Terms:
        places: of the motors' coordinates in the skeleton. limit: of the forces, infinite where there is none. loss: what dry
        friction takes [N m or N], (m,).
    """

    def __init__(self, motors: list[Motor]) -> None:
        self.skeleton, self._motors = motors[0].skeleton, motors
        self._indices = [int(m.joint.getIndexInSkeleton(0)) for m in motors]
        self.places = np.array(self._indices)
        self.loss = np.array([float(m.joint.getCoulombFriction(0)) for m in motors])
        parts = [(m.spring, m.drive) for m in motors]
        self._k, self._c = (np.array([[getattr(part, name) for part in two] for two in parts]).T for name in ("stiffness", "damping"))
        self._rest = np.array([(spring.rest, 0.0) for spring, _ in parts]).T
        self._push = np.array([(0.0, d.damping * d.target_velocity + (d.feedforward or 0.0)) for _, d in parts]).T
        self.limit = np.array([(np.inf, np.inf if d.limit is None else d.limit) for _, d in parts]).T

    def forces(self, x: Floats, dt: float) -> tuple[Floats, Floats]:
        """What springs and drives exert, without a limit, at coordinates x (m,) and v = 0, and the slopes over a step of dt [s]."""
        self._rest[1] = [m.target for m in self._motors]
        return self._k * (self._rest - x) + self._push, self._c + dt * self._k

    def paces(self, x: Floats, dt: float) -> Floats:
        """The velocities [rad/s or m/s] at the end of a step under which the drives push no more, which servos hold."""
        (_, still), (_, slope) = self.forces(x, dt)
        paces: Floats = still / slope
        return paces

    def pushes(self) -> Floats:
        """What the motors push beside [N m or N]."""
        return np.array([m.push for m in self._motors])

    def set(self, commands: Floats) -> None:
        """The motors' commands for the coming step."""
        self.skeleton.setCommands(self._indices, commands)


def by_skeleton(motors: Iterable[Motor]) -> list[Laws]:
    """The laws of these motors, those of a skeleton together."""
    groups: dict[str, list[Motor]] = {}
    for motor in motors:
        groups.setdefault(motor.skeleton.getName(), []).append(motor)
    return [Laws(group) for group in groups.values()]


class Pushes:
    """What motors need in every step that are not foreseen: constant pushes, paces of servos, forces within limits."""

    def __init__(self, motors: Iterable[Motor]) -> None:
        told = [m for m in motors if not m.stable]
        self._servos = by_skeleton(m for m in told if m.servo)
        self._others = [m for m in told if not m.servo]
        self._limited = by_skeleton(m for m in self._others if m.limited)

    def set(self, dt: float) -> None:
        """Set the motors' commands for the coming step of dt [s]."""
        for motor in self._others:
            if motor.push != 0.0:
                motor.joint.setCommand(0, motor.push)
        for laws in self._servos:
            laws.set(laws.paces(np.asarray(laws.skeleton.getPositions())[laws.places], dt))
        for laws in self._limited:
            _set_within_limits(laws, dt)


def _set_within_limits(laws: Laws, dt: float) -> None:
    """Limited drives: f = k (t - x') + c (u - v') + b with x' = x + dt v', v' = v + dt (a + M^-1 f), then cut off;
    b is the feedforward.

    a is the acceleration without them, M the mass matrix augmented by DART's implicit springs and dampers.
    """
    skeleton, places = laws.skeleton, laws.places
    skeleton.computeForwardDynamics()
    x, v, a = (np.asarray(f())[places] for f in (skeleton.getPositions, skeleton.getVelocities, skeleton.getAccelerations))
    mobility = np.linalg.inv(np.asarray(skeleton.getAugMassMatrix()))[np.ix_(places, places)]
    # What dry friction holds does not move within the step, unless the drive can tear it loose where it stands.
    held = (laws.loss > 0) & (np.abs(v) < AT_REST)
    rubbed = np.where(held, 0.0, np.copysign(laws.loss, v))
    (_, still), (_, slope) = laws.forces(x, dt)
    push = still - slope * np.where(held, 0.0, v + dt * (a - mobility @ rubbed))
    gain = np.where(held, 0.0, dt * slope)
    f = np.linalg.solve(np.eye(len(places)) + gain[:, None] * mobility, push)
    laws.set(laws.pushes() + np.clip(f, -laws.limit[1], laws.limit[1]))
