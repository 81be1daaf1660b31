"""Rotations between the frames of a scene and those of an engine: quaternions (w, x, y, z), matrices, principal axes.

In plain numbers, which a command that starts and a state that is read back have to pay for: SciPy's `Rotation` takes part of a
second to import.
"""

from collections.abc import Sequence

import numpy as np

from plumbline.harness.scene import Body, Quaternion, Vector3, rotation_matrix
from plumbline.harness.trajectory import Floats

IDENTITY: Quaternion = (1.0, 0.0, 0.0, 0.0)


def conjugate(q: Quaternion) -> Quaternion:
    """The inverse of a unit quaternion."""
    return (q[0], -q[1], -q[2], -q[3])


def matrix(q: Sequence[float] | Floats) -> Floats:
    """The rotation matrix (3, 3) of a unit quaternion."""
    w, x, y, z = (float(c) for c in q)
    return np.array(rotation_matrix((w, x, y, z)))


def products(a: Floats, b: Floats) -> Floats:
    """Hamilton products of quaternions, row by row, shapes (n, 4): first b, then a."""
    aw, ax, ay, az = a.T
    bw, bx, by, bz = b.T
    rows = [
        aw * bw - ax * bx - ay * by - az * bz,
        aw * bx + ax * bw + ay * bz - az * by,
        aw * by - ax * bz + ay * bw + az * bx,
        aw * bz + ax * by - ay * bx + az * bw,
    ]
    return np.stack(rows, axis=1)


def principal_frame(body: Body) -> tuple[Vector3, Quaternion]:
    """Principal moments [kg m2] of a body and q_BP, which turns the principal frame P into B.

    A tensor that is diagonal already is left as it stands.
    """
    tensor = np.asarray(body.inertia)
    moments, turn = np.diag(tensor), IDENTITY
    if (tensor - np.diag(moments)).any():
        moments, axes = np.linalg.eigh((tensor + tensor.T) / 2)
        if np.linalg.det(axes) < 0:
            axes[:, 0] *= -1
        turn = _quaternion(axes)
    return (float(moments[0]), float(moments[1]), float(moments[2])), turn


def _quaternion(R: Floats) -> Quaternion:
    """The unit quaternion of a rotation matrix.

    Source: Shepperd, Quaternion from rotation matrix, J. Guidance and Control 1 (1978) 223: divide by the largest component.
    """
    trace = float(np.trace(R))
    squares = np.array([trace, R[0, 0], R[1, 1], R[2, 2]])
    largest = int(np.argmax(squares))
    q = np.empty(4)
    if largest == 0:
        q[:] = 1 + trace, R[2, 1] - R[1, 2], R[0, 2] - R[2, 0], R[1, 0] - R[0, 1]
    else:
        i, j, k = largest - 1, largest % 3, (largest + 1) % 3
        q[0] = R[k, j] - R[j, k]
        q[1 + i] = 1 + R[i, i] - R[j, j] - R[k, k]
        q[1 + j], q[1 + k] = R[j, i] + R[i, j], R[k, i] + R[i, k]
    w, x, y, z = (q / np.linalg.norm(q)).tolist()
    return (w, x, y, z)
