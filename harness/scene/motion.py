"""How a drive's target or a kinematic body moves: a sinusoid, or straight lines between samples. Both are signals of time.

Rotations are unit quaternions (w, x, y, z) that map a body frame B to the world frame W.
"""

import math
from bisect import bisect_right
from collections.abc import Callable
from typing import Annotated, Literal

import numpy as np
from pydantic import Field
from pydantic.dataclasses import dataclass

from plumbline.harness.scene.values import FROZEN, Axis, Finite, Matrix3, NonNegative, Quaternion, Vector3


def axis_angle(axis: Vector3, angle: float) -> Quaternion:
    """The rotation by `angle` [rad] about `axis` (any length but zero), right-handed."""
    norm = math.sqrt(sum(c * c for c in axis))
    s = math.sin(angle / 2) / norm
    return (math.cos(angle / 2), axis[0] * s, axis[1] * s, axis[2] * s)


def multiply(a: Quaternion, b: Quaternion) -> Quaternion:
    """The Hamilton product a b: first b, then a."""
    aw, ax, ay, az = a
    bw, bx, by, bz = b
    return (
        aw * bw - ax * bx - ay * by - az * bz,
        aw * bx + ax * bw + ay * bz - az * by,
        aw * by - ax * bz + ay * bw + az * bx,
        aw * bz + ax * by - ay * bx + az * bw,
    )


def rotation_matrix(q: Quaternion) -> Matrix3:
    """The matrix R with R v = q v q*, shape (3, 3), row by row."""
    w, x, y, z = q
    return (
        (1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)),
        (2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)),
        (2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)),
    )


def rotate(q: Quaternion, v: Vector3) -> Vector3:
    """The vector R v."""
    m = rotation_matrix(q)
    return (
        m[0][0] * v[0] + m[0][1] * v[1] + m[0][2] * v[2],
        m[1][0] * v[0] + m[1][1] * v[1] + m[1][2] * v[2],
        m[2][0] * v[0] + m[2][1] * v[1] + m[2][2] * v[2],
    )


MOST_SAMPLES = 100_000
"""Samples of one joint: 100 s at a kilohertz."""


@dataclass(frozen=True, slots=True, kw_only=True, config=FROZEN)
class Sinusoid:
    """amplitude sin(2 pi frequency t + phase), added to the drive's own target.

    Terms:
        amplitude [rad or m]; frequency [Hz]; phase [rad].
    """

    amplitude: Finite
    frequency: NonNegative
    phase: Finite = 0.0
    type: Literal["sinusoid"] = "sinusoid"

    def at(self, time: float, target: float) -> float:
        """The target [rad or m] at a time [s], of a drive with its own `target`."""
        return target + self.amplitude * math.sin(2 * math.pi * self.frequency * time + self.phase)

    def rate_at_start(self) -> float:
        """How fast the target moves at time 0 [rad/s or m/s]."""
        return self.amplitude * 2 * math.pi * self.frequency * math.cos(self.phase)


@dataclass(frozen=True, slots=True, kw_only=True, config=FROZEN)
class Samples:
    """Targets at times, joined by straight lines, in place of the drive's own; before the first and after the last they stay.

    Terms:
        time [s], rising; target [rad or m], as many; of an effort [N m or N]. held: each stays until the next one, without
        lines between them; None: no.
    """

    time: Annotated[tuple[Finite, ...], Field(min_length=1, max_length=MOST_SAMPLES)]
    target: Annotated[tuple[Finite, ...], Field(min_length=1, max_length=MOST_SAMPLES)]
    held: bool | None = None
    type: Literal["samples"] = "samples"

    def __post_init__(self) -> None:
        if len(self.time) != len(self.target):
            raise ValueError(f"samples: {len(self.time)} times and {len(self.target)} targets, expected as many")
        for k in range(1, len(self.time)):
            if self.time[k] <= self.time[k - 1]:
                raise ValueError(f"samples: time[{k}] is {self.time[k]:g} s after {self.time[k - 1]:g} s, expected later times")

    def at(self, time: float, target: float) -> float:  # noqa: ARG002  both kinds of motion are asked alike
        """The target [rad or m] at a time [s]."""
        after = bisect_right(self.time, time)
        if after in (0, len(self.time)):
            return self.target[0 if after == 0 else -1]
        t, x = self.time, self.target
        if self.held:
            return x[after - 1]
        return x[after - 1] + (x[after] - x[after - 1]) * (time - t[after - 1]) / (t[after] - t[after - 1])

    def rate_at_start(self) -> float:
        """How fast the target moves from time 0 on [rad/s or m/s]."""
        after = bisect_right(self.time, 0.0)
        if self.held or after in (0, len(self.time)):
            return 0.0
        return (self.target[after] - self.target[after - 1]) / (self.time[after] - self.time[after - 1])


Motion = Annotated[Sinusoid | Samples, Field(discriminator="type")]


def sampled(law: Callable[[float], float], end: float, every: float = 1e-3) -> Samples:
    """The samples of a law of time up to `end` [s], one each `every` [s]: any function of one's own as a drive's motion.

    What is between two samples is a straight line, whatever the time step of a run, so that all engines and steps follow one
    signal. Raises: ValueError, for more than MOST_SAMPLES or where the law gives what is no finite number.
    """
    if not (0 < every <= end < math.inf) or end / every >= MOST_SAMPLES:
        raise ValueError(
            f"sampled: every {every!r} s up to {end!r} s, expected 0 < every <= end and at most {MOST_SAMPLES} samples"
        )
    count = math.ceil(end / every - 1e-9)
    times = tuple(every * k for k in range(count + 1))
    return Samples(time=times, target=tuple(float(law(t)) for t in times))


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
