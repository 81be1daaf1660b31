"""Rigid poses as a matrix and a vector: a frame B in a frame A by R_AB, shape (3, 3), and p_AB [m], shape (3,)."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Annotated, TypeAlias

import numpy as np
import numpy.typing as npt
from pydantic import PlainSerializer, PlainValidator

from plumbline.harness.scene.values import Quaternion, Vector3

Array: TypeAlias = Annotated[
    npt.NDArray[np.float64],
    PlainValidator(lambda rows: np.array(rows, dtype=np.float64)),
    PlainSerializer(lambda array: array.tolist()),
]
"""Numbers, as JSON lists of lists between processes."""


@dataclass(frozen=True, slots=True, eq=False)
class Pose:
    """The pose of B in A. Terms: R (3, 3), p (3,) m."""

    R: Array
    p: Array

    def __matmul__(self, other: "Pose") -> "Pose":
        """X_AC = X_AB X_BC."""
        return Pose(self.R @ other.R, self.p + self.R @ other.p)

    def inverse(self) -> "Pose":
        """X_BA."""
        return Pose(self.R.T, -self.R.T @ self.p)

    def of(self, point: Array) -> Array:
        """A point of B in A [m]."""
        moved: Array = self.R @ point + self.p
        return moved


IDENTITY = Pose(np.eye(3), np.zeros(3))


def matrix(q: "Quaternion | Array") -> Array:
    """The rotation of a quaternion (w, x, y, z), normalised first; (3, 3)."""
    w, x, y, z = map(float, q)
    norm = math.sqrt(w * w + x * x + y * y + z * z)
    w, x, y, z = w / norm, x / norm, y / norm, z / norm
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    )


def pose(p: "Vector3 | Array", q: "Quaternion | Array" = (1.0, 0.0, 0.0, 0.0)) -> Pose:
    """The pose with a position [m] and a quaternion (w, x, y, z)."""
    return Pose(matrix(q), np.asarray(p, dtype=np.float64))


def quaternion(R: Array) -> Quaternion:
    """The quaternion (w, x, y, z) of a rotation, with w >= 0.

    Source: Shepperd, Quaternion from Rotation Matrix, J. Guidance and Control 1 (1978) 223: the largest component divides.
    """
    r = R.tolist()  # numbers of Python: sums of a few of NumPy's take many times as long
    t = r[0][0] + r[1][1] + r[2][2]
    squares = (t, r[0][0], r[1][1], r[2][2])
    k = squares.index(max(squares))
    if k == 0:
        q = [1 + t, r[2][1] - r[1][2], r[0][2] - r[2][0], r[1][0] - r[0][1]]
    else:
        i = k - 1
        j, m = (i + 1) % 3, (i + 2) % 3
        q = [r[m][j] - r[j][m], 0.0, 0.0, 0.0]
        q[1 + i] = 1 + 2 * r[i][i] - t
        q[1 + j] = r[j][i] + r[i][j]
        q[1 + m] = r[m][i] + r[i][m]
    s = (-1.0 if q[0] < 0 else 1.0) / math.sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3])
    return (q[0] * s, q[1] * s, q[2] * s, q[3] * s)


def rolled(angles: "Sequence[float] | Array") -> Array:
    """R = Rz(yaw) Ry(pitch) Rx(roll) of roll, pitch and yaw [rad] about fixed axes, (3, 3), without negative zeros."""
    (sr, sp, sy), (cr, cp, cy) = np.sin(angles), np.cos(angles)
    R = [
        [cp * cy, sp * (sr * cy) - cr * sy, sp * (cr * cy) + sr * sy],
        [cp * sy, sp * (sr * sy) + cr * cy, sp * (cr * sy) - sr * cy],
        [-sp, cp * sr, cp * cr],
    ]
    return np.array(R) + 0.0


def vector(v: Array) -> Vector3:
    """Three numbers as a scene holds them, without negative zeros."""
    return (float(v[0]) + 0.0, float(v[1]) + 0.0, float(v[2]) + 0.0)


def cross(v: Array) -> Array:
    """The matrix of v x, (3, 3)."""
    return np.array([[0.0, -v[2], v[1]], [v[2], 0.0, -v[0]], [-v[1], v[0], 0.0]])


def crossed(a: Array, b: Array) -> Array:
    """a x b of two vectors: the sums of `numpy.cross` to the bit, without its search for axes, which outweighs them."""
    return np.array([a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]])


def turn(axis: Array, angle: float) -> Array:
    """The rotation by an angle [rad] about a unit axis (Rodrigues), (3, 3)."""
    K = cross(axis)
    rotation: Array = np.eye(3) + np.sin(angle) * K + (1 - np.cos(angle)) * (K @ K)
    return rotation


def screw(axis: Array, anchor: Array, angle: float, way: float) -> Pose:
    """The motion of a body that turns by an angle [rad] about a line and slides by a way [m] along it."""
    R = turn(axis, angle)
    return Pose(R, anchor - R @ anchor + way * axis)
