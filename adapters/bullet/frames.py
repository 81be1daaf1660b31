"""Frames: quaternions and vectors as Bullet takes them."""

import numpy as np

from plumbline.harness.scene import Quaternion, Vector3
from plumbline.harness.trajectory import Floats


def xyzw(q: Quaternion) -> list[float]:
    """A quaternion (w, x, y, z) in Bullet's order."""
    return [q[1], q[2], q[3], q[0]]


def minus(a: Vector3, b: Vector3) -> Vector3:
    """a - b."""
    return (a[0] - b[0], a[1] - b[1], a[2] - b[2])


def plus(a: Vector3, b: Vector3) -> Vector3:
    """a + b."""
    return (a[0] + b[0], a[1] + b[1], a[2] + b[2])


def matrices(q: Floats) -> Floats:
    """Rotation matrices (n, 3, 3) of unit quaternions (x, y, z, w), shape (n, 4)."""
    x, y, z, w = q.T
    rows = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
    ]
    return np.array(rows).transpose(2, 0, 1)
