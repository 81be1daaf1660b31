"""Springs and drives: the coordinate of a joint that they act on, and the laws by which the adapter sets them."""

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from plumbline.harness.adapter import Notice
from plumbline.harness.scene import Drive, Spring
from plumbline.harness.trajectory import Floats

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
    rotor: float = 0.0
    """Armature over a step [N m s/rad or N s/m], which is a damper of DART (`rotors`)."""

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
        self.joint.setDampingCoefficient(0, spring.damping + (drive.damping if shared else 0.0) + self.rotor)
        self.push = force - k * rest


class Laws:
    """Springs and drives of one skeleton as arrays (2, n), springs first, one column a coordinate, zero where there is none: a
    force [N m or N] is that at v = 0 less slope * v, v the velocity at the end of a step.

    Terms:
        places: of the motors' coordinates (m,). limit: of the forces, infinite where there is none. loss: what dry friction
        takes [N m or N], (n,).
    """

    def __init__(self, skeleton: Any, motors: Sequence[Motor]) -> None:
        self.skeleton, self._motors = skeleton, motors
        self._indices = [int(m.joint.getIndexInSkeleton(0)) for m in motors]
        self.places = np.array(self._indices, dtype=np.int64)
        # Of springs and drives the stiffness, damping, place of rest and push besides; what dry friction takes is apart.
        self._k, self._c, self._rest, self._push = np.zeros((4, 2, skeleton.getNumDofs()))
        self.limit, self.loss = np.full_like(self._k, np.inf), np.zeros(self._k.shape[1])
        self._rotors = np.array([m.rotor for m in motors])
        for i, motor in zip(self._indices, motors, strict=True):
            spring, drive = motor.spring, motor.drive
            self._k[:, i], self._c[:, i] = (spring.stiffness, drive.stiffness), (spring.damping, drive.damping)
            self._rest[0, i] = spring.rest
            self._push[1, i] = drive.damping * drive.target_velocity + (drive.feedforward or 0.0)
            self.limit[1, i] = math.inf if drive.limit is None else drive.limit
            self.loss[i] = motor.joint.getCoulombFriction(0)

    def forces(self, dt: float) -> tuple[Floats, Floats]:
        """What springs and drives exert from here, without a limit, at v = 0, and the slopes over a step of dt [s]."""
        self._rest[1, self.places] = [m.target for m in self._motors]
        return self._k * (self._rest - self.skeleton.getPositions()) + self._push, self._c + dt * self._k

    def pushes(self) -> Floats:
        """What the motors push beside [N m or N], (m,)."""
        return np.array([m.push for m in self._motors])

    def set(self, commands: Floats) -> None:
        """The commands (m,) of the motors for the coming step, beside what their rotors' dampers would brake."""
        if self._rotors.any():
            commands = commands + self._rotors * self.skeleton.getVelocities()[self.places]
        if self._indices:
            self.skeleton.setCommands(self._indices, commands)


def by_skeleton(motors: Iterable[Motor]) -> list[Laws]:
    """The laws of these motors, those of a skeleton together."""
    groups: dict[str, list[Motor]] = {}
    for motor in motors:
        groups.setdefault(motor.skeleton.getName(), []).append(motor)
    return [Laws(group[0].skeleton, group) for group in groups.values()]


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
                motor.joint.setCommand(0, motor.push + motor.rotor * motor.joint.getVelocity(0))
        for laws in self._servos:
            # The velocities at the end of the step under which the drives push no more.
            force, slope = laws.forces(dt)
            laws.set(force[1, laws.places] / slope[1, laws.places])
        for laws in self._limited:
            _set_within_limits(laws, dt)


def _set_within_limits(laws: Laws, dt: float) -> None:
    """Limited drives: f = k (t - x') + c (u - v') + b with x' = x + dt v', v' = v + dt (a + M^-1 f), then cut off;
    b is the feedforward.

    a is the acceleration without them, M the mass matrix augmented by DART's implicit springs and dampers.
    """
    skeleton, places = laws.skeleton, laws.places
    skeleton.computeForwardDynamics()
    v, a = (f()[places] for f in (skeleton.getVelocities, skeleton.getAccelerations))
    mobility = np.linalg.inv(skeleton.getAugMassMatrix())[np.ix_(places, places)]
    # What dry friction holds does not move within the step, unless the drive can tear it loose where it stands.
    loss, limit = laws.loss[places], laws.limit[1, places]
    held = (loss > 0) & (np.abs(v) < AT_REST)
    force, slope = (both[1, places] for both in laws.forces(dt))
    push = force - slope * np.where(held, 0.0, v + dt * (a - mobility @ np.where(held, 0.0, np.copysign(loss, v))))
    gain = np.where(held, 0.0, dt * slope)
    f = np.linalg.solve(np.eye(len(places)) + gain[:, None] * mobility, push)
    laws.set(laws.pushes() + np.clip(f, -limit, limit))
