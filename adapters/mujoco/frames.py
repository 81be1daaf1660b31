"""Frames: the principal frame M of a body, which MuJoCo's bodies are given, and vectors row by row."""

import numpy as np

from plumbline.harness.adapter.rotations import principal_frame
from plumbline.harness.scene import Body, Quaternion, Vector3
from plumbline.harness.trajectory import Floats


def principal(body: Body) -> tuple[Vector3, Quaternion]:
    """Principal moments [kg m2] and q_BM; a tensor that is diagonal already is left as it stands."""
    moments, q_BM = principal_frame(body)
    # The scene grants rounding in the triangle inequality; MuJoCo's compiler grants none.
    bounded = np.array(moments)
    largest = int(np.argmax(bounded))
    bounded[largest] = min(bounded[largest], float(bounded.sum() - bounded[largest]))
    return (float(bounded[0]), float(bounded[1]), float(bounded[2])), q_BM


def upright(normal: Vector3) -> Quaternion:
    """The rotation that turns z into `normal`."""
    n = np.array(normal)
    if n[2] < -1 + 1e-12:
        return (0.0, 1.0, 0.0, 0.0)
    q = np.array([1 + n[2], -n[1], n[0], 0.0])
    q /= np.linalg.norm(q)
    return (float(q[0]), float(q[1]), float(q[2]), float(q[3]))


def cross(a: Floats, b: Floats) -> Floats:
    """Row by row the cross product, shapes (n, 3); several times faster than numpy's for short arrays."""
    return a[:, [1, 2, 0]] * b[:, [2, 0, 1]] - a[:, [2, 0, 1]] * b[:, [1, 2, 0]]
