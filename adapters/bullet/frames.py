"""Frames: quaternions and vectors as Bullet takes them, and the principal frame of a body."""

import numpy as np

from harness.scene import Body, Quaternion, Vector3
from harness.trajectory import Floats

__all__ = ["IDENTITY", "conjugate", "matrices", "minus", "plus", "principal_frame", "products", "xyzw"]

IDENTITY: Quaternion = (1.0, 0.0, 0.0, 0.0)


def conjugate(q: Quaternion) -> Quaternion:
    """The inverse of a unit quaternion (w, x, y, z)."""
    return (q[0], -q[1], -q[2], -q[3])


def xyzw(q: Quaternion) -> list[float]:
    """A quaternion (w, x, y, z) in Bullet's order."""
    return [q[1], q[2], q[3], q[0]]


def minus(a: Vector3, b: Vector3) -> Vector3:
    """a - b."""
    return (a[0] - b[0], a[1] - b[1], a[2] - b[2])


def plus(a: Vector3, b: Vector3) -> Vector3:
    """a + b."""
    return (a[0] + b[0], a[1] + b[1], a[2] + b[2])


def _from_matrix(R: Floats) -> Quaternion:
    """The unit quaternion of a rotation matrix (Shepperd's method: divide by the largest component)."""
    trace = float(np.trace(R))
    squares = np.array([trace, R[0, 0], R[1, 1], R[2, 2]])
    k = int(np.argmax(squares))
    if k == 0:
        q = np.array([1 + trace, R[2, 1] - R[1, 2], R[0, 2] - R[2, 0], R[1, 0] - R[0, 1]])
    else:
        i = k - 1
        j, m = (i + 1) % 3, (i + 2) % 3
        q = np.zeros(4)
        q[0] = R[m, j] - R[j, m]
        q[1 + i] = 1 + R[i, i] - R[j, j] - R[m, m]
        q[1 + j] = R[j, i] + R[i, j]
        q[1 + m] = R[m, i] + R[i, m]
    w, x, y, z = (q / np.linalg.norm(q)).tolist()
    return (w, x, y, z)


def principal_frame(body: Body) -> tuple[Vector3, Quaternion]:
    """Principal moments [kg m2] of a body and q_BI, which turns the principal frame I into B."""
    tensor = np.asarray(body.inertia)
    if not (tensor - np.diag(np.diag(tensor))).any():
        return (float(tensor[0, 0]), float(tensor[1, 1]), float(tensor[2, 2])), IDENTITY
    moments, axes = np.linalg.eigh(tensor)
    if np.linalg.det(axes) < 0:
        axes[:, 0] *= -1
    return (float(moments[0]), float(moments[1]), float(moments[2])), _from_matrix(axes)


def matrices(q: Floats) -> Floats:
    """Rotation matrices (n, 3, 3) of unit quaternions (x, y, z, w), shape (n, 4)."""
    x, y, z, w = q.T
    rows = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
    ]
    return np.array(rows).transpose(2, 0, 1)


def products(a: Floats, b: Floats) -> Floats:
    """Hamilton products of quaternions (w, x, y, z), row by row, shapes (n, 4)."""
    aw, ax, ay, az = a.T
    bw, bx, by, bz = b.T
    rows = [
        aw * bw - ax * bx - ay * by - az * bz,
        aw * bx + ax * bw + ay * bz - az * by,
        aw * by - ax * bz + ay * bw + az * bx,
        aw * bz + ax * by - ay * bx + az * bw,
    ]
    return np.stack(rows, axis=1)
