"""Directions, orientations and vectors as checks write and compare them."""

from typing import Any

import numpy as np

from plumbline.harness.conformance.check import Compared, near
from plumbline.harness.scene import Matrix3, Quaternion, Vector3, axis_angle, multiply, rotation_matrix
from plumbline.harness.trajectory import Floats, kinematics


def rotation(q: Any) -> Floats:
    """The matrix R_WB of a quaternion (w, x, y, z), shape (3, 3)."""
    w, x, y, z = (float(c) for c in q)
    return np.array(rotation_matrix((w, x, y, z)))


def angle_between(a: Any, b: Any) -> float:
    """The angle [rad] of the rotation between two quaternions, which may differ in sign and length; NaN stays NaN."""
    return float(kinematics.angle_between(np.asarray(a, dtype=np.float64), np.asarray(b, dtype=np.float64)))


def aligned(what: str, got: Any, expected: Any, within: float, because: str = "") -> Compared:
    """Are the angles [rad] between orientations (4,) or (k, 4) within `within`? NaN is near to nothing."""
    off = kinematics.angle_between(np.asarray(got, dtype=np.float64), np.asarray(expected, dtype=np.float64))
    return near(what, off, np.zeros_like(off), within, because)


def turned_by(q: Quaternion, w: Any, t: float) -> Floats:
    """The orientation after turning with the constant angular velocity w [rad/s, in W] for t [s]."""
    speed = float(np.linalg.norm(w))
    axis = np.asarray(w) / speed
    x, y, z = (float(c) for c in np.sin(speed * t / 2) * axis)
    return np.array(multiply((float(np.cos(speed * t / 2)), x, y, z), q), dtype=np.float64)


ORIGIN: Vector3 = (0.0, 0.0, 0.0)
X: Vector3 = (1.0, 0.0, 0.0)
Y: Vector3 = (0.0, 1.0, 0.0)
Z: Vector3 = (0.0, 0.0, 1.0)
UPRIGHT: Quaternion = (1.0, 0.0, 0.0, 0.0)
TURNED: Quaternion = multiply(axis_angle((0.0, 0.0, 1.0), 0.7), axis_angle((1.0, 2.0, 3.0), 1.1))
"""A rotation without any symmetry: four different components, none of them zero."""


def vector(row: Any) -> Vector3:
    """The numbers of a row (3,), as a scene takes them."""
    x, y, z = (float(c) for c in row)
    return x, y, z


def symmetric(matrix: Floats) -> Matrix3:
    """A matrix (3, 3) made symmetric to the last bit, as a scene takes an inertia."""
    a, b, c = (vector(row) for row in (matrix + matrix.T) / 2)
    return a, b, c
