"""Rotations as unit quaternions (w, x, y, z) that map a body frame B to the world frame W."""

import math

from plumbline.harness.scene.values import Matrix3, Quaternion, Vector3


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
