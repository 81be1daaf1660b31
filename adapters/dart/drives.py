"""Springs and drives: the coordinate of a joint that they act on, and the law by which limited ones push."""

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from harness.adapter import Notice
from harness.scene import Drive, Spring

__all__ = ["AT_REST", "SERVO_NOTICE", "Motor", "drive_within_limits"]

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
    def held(self) -> bool:
        """Does dry friction hold the joint since the last step?"""
        return bool(self.joint.getCoulombFriction(0) > 0 and abs(self.joint.getVelocity(0)) < AT_REST)

    @property
    def rubbed(self) -> float:
        """What dry friction takes of a joint that moves [N m or N], against what the drive pushes."""
        return 0.0 if self.held else math.copysign(self.joint.getCoulombFriction(0), self.joint.getVelocity(0))

    @property
    def works(self) -> bool:
        """Is there something to be worked out in every step?"""
        return self.stable or self.servo or self.limited or self.push != 0.0

    def pace(self, dt: float) -> float:
        """The velocity [rad/s or m/s] at the end of a step under which the drive pushes no more, which the servo holds."""
        k, c = self.drive.stiffness, self.drive.damping
        return (c * self.drive.target_velocity + k * (self.target - float(self.joint.getPosition(0)))) / (c + dt * k)

    def forces(self, v: float, dt: float) -> tuple[float, float]:
        """What spring and drive exert [N m or N], without a limit, where a step at the velocity v leads."""
        x = self.joint.getPosition(0) + dt * v
        spring, drive = self.spring, self.drive
        return (
            spring.stiffness * (spring.rest - x) - spring.damping * v,
            drive.stiffness * (self.target - x) + drive.damping * (drive.target_velocity - v) + (drive.feedforward or 0.0),
        )

    def inertia(self, dt: float, saturated: bool) -> float:
        """What the joint's inertia seems to grow by [kg m2 or kg], as the forces fall while its velocity grows."""
        drive = Drive() if saturated else self.drive
        return dt * (self.spring.damping + drive.damping) + dt**2 * (self.spring.stiffness + drive.stiffness)

    def cut(self, force: float) -> float:
        """The drive's force within its limit."""
        limit = self.drive.limit if self.drive.limit is not None else math.inf
        return float(min(max(force, -limit), limit))

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


def drive_within_limits(motors: list[Motor], dt: float) -> None:
    """Limited drives: f = k (t - x') + c (u - v') + b with x' = x + dt v', v' = v + dt (a + M^-1 f), then cut off;
    b is the feedforward.

    a is the acceleration without them, M the mass matrix augmented by DART's implicit springs and dampers.
    """
    skeleton = motors[0].skeleton
    skeleton.computeForwardDynamics()
    places = [m.joint.getIndexInSkeleton(0) for m in motors]
    x, v, a = (np.asarray(f())[places] for f in (skeleton.getPositions, skeleton.getVelocities, skeleton.getAccelerations))
    mobility = np.linalg.inv(np.asarray(skeleton.getAugMassMatrix()))[np.ix_(places, places)]
    k, c = (np.array([getattr(m.drive, name) for m in motors]) for name in ("stiffness", "damping"))
    wanted = np.array([m.target for m in motors]), np.array([m.drive.target_velocity for m in motors])
    v_free = v + dt * (a - mobility @ [m.rubbed for m in motors])
    push = k * (wanted[0] - x - dt * v_free) + c * (wanted[1] - v_free)
    push += np.array([m.drive.feedforward or 0.0 for m in motors])
    gain = dt * (c + dt * k)
    # What dry friction holds does not move within the step, unless the drive can tear it loose where it stands.
    held = np.array([m.held for m in motors])
    push = np.where(held, k * (wanted[0] - x) + c * (wanted[1] - v), push)
    gain = np.where(held, 0.0, gain)
    f = np.linalg.solve(np.eye(len(motors)) + gain[:, None] * mobility, push)
    for motor, force in zip(motors, f, strict=True):
        motor.joint.setCommand(0, motor.push + motor.cut(float(force)))
