"""The motion of a kinematic body as a law of time: along directions, about an axis, or both."""

from typing import Annotated

import numpy as np
from pydantic import Field
from pydantic.dataclasses import dataclass

from plumbline.harness.scene.motion import Motion
from plumbline.harness.scene.rotation import axis_angle, multiply, rotate
from plumbline.harness.scene.values import FROZEN, Axis, Quaternion, Vector3


@dataclass(frozen=True, slots=True, kw_only=True, config=FROZEN)
class Shift:
    """The way [m] along `axis_W`, a direction in W, by a motion of time."""

    axis_W: Axis
    motion: Motion


@dataclass(frozen=True, slots=True, kw_only=True, config=FROZEN)
class Turn:
    """The angle [rad] about `axis_W` through `anchor_W` [m], both in W at time 0, by a motion of time."""

    anchor_W: Vector3
    axis_W: Axis
    motion: Motion


@dataclass(frozen=True, slots=True, kw_only=True, config=FROZEN)
class Prescribed:
    """A turn about an axis, which the shifts and the body's v_WB carry along. What a motion says at time 0 is where it starts.

    Equation: p_WB(t) = a + R(t) (p_WB(0) - a) + v_WB t + sum of axis (x(t) - x(0)), q_WB(t) = R(t) q_WB(0), a the anchor.
    """

    shifts: Annotated[tuple[Shift, ...], Field(max_length=16)] = ()
    turn: Turn | None = None

    def __post_init__(self) -> None:
        if not self.shifts and self.turn is None:
            raise ValueError("prescribed: neither shifts nor a turn, expected at least one of them")

    def angle(self, time: float) -> float:
        """How far the body has turned [rad] at a time [s]."""
        return 0.0 if self.turn is None else _since_start(self.turn.motion, time)

    def pose(self, p_WB: Vector3, q_WB: Quaternion, v_WB: Vector3, time: float) -> tuple[Vector3, Quaternion]:
        """The pose at a time [s] of a body with this one at time 0. Args: v_WB [m/s]: its uniform velocity beside."""
        x, y, z = p_WB
        if self.turn is not None:
            turn = axis_angle(self.turn.axis_W, self.angle(time))
            a = self.turn.anchor_W
            dx, dy, dz = rotate(turn, (x - a[0], y - a[1], z - a[2]))
            x, y, z, q_WB = a[0] + dx, a[1] + dy, a[2] + dz, multiply(turn, q_WB)
        x, y, z = x + v_WB[0] * time, y + v_WB[1] * time, z + v_WB[2] * time
        for shift in self.shifts:
            way, axis = _since_start(shift.motion, time), shift.axis_W
            x, y, z = x + way * axis[0], y + way * axis[1], z + way * axis[2]
        return (x, y, z), q_WB

    def velocity(self, p_WB: Vector3, q_WB: Quaternion, v_WB: Vector3, time: float, dt: float) -> tuple[Vector3, Vector3]:
        """The uniform v [m/s] and w [rad/s] in W that take the body from its pose at a time [s] to that dt [s] later.

        Args: as of `pose`.
        """
        here, there = (self.pose(p_WB, q_WB, v_WB, at)[0] for at in (time, time + dt))
        v = ((there[0] - here[0]) / dt, (there[1] - here[1]) / dt, (there[2] - here[2]) / dt)
        if self.turn is None:
            return v, (0.0, 0.0, 0.0)
        rate, axis = (self.angle(time + dt) - self.angle(time)) / dt, self.turn.axis_W
        return v, (rate * axis[0], rate * axis[1], rate * axis[2])

    def velocity_at_start(self, p_WB: Vector3, v_WB: Vector3) -> tuple[Vector3, Vector3]:
        """v [m/s] and w [rad/s] in W at time 0 of a body that is there. Args: v_WB [m/s]: its uniform velocity beside."""
        v, w = np.array(v_WB), np.zeros(3)
        if self.turn is not None:
            w = self.turn.motion.rate_at_start() * np.array(self.turn.axis_W)
            v = v + np.cross(w, np.subtract(p_WB, self.turn.anchor_W))
        for shift in self.shifts:
            v = v + shift.motion.rate_at_start() * np.array(shift.axis_W)
        return (float(v[0]), float(v[1]), float(v[2])), (float(w[0]), float(w[1]), float(w[2]))


def _since_start(motion: Motion, time: float) -> float:
    return motion.at(time, 0.0) - motion.at(0.0, 0.0)
