"""The path of a body through one span of time: from its first pose to its last, by a parabola and a uniform turn.

A path is a row laid out as a state, with one more vector: pose at the start, velocity at the start, angular velocity and
acceleration. The acceleration is that of gravity and loads where nothing touches the body, else none; the rest leads to the
end. Of all turns with the same end, that is taken which is nearest to the mean angular velocity, so that several turns count.

Source: Redon, Kheddar, Coquillart, Fast Continuous Collision Detection between Rigid Bodies, Comput. Graph. Forum 21, 2002
(arbitrary in-between motions); Hairer, Lubich, Wanner, Geometric Numerical Integration, section IV.8 (the logarithm).
"""

import math

from plumbline.engine.broad.bounds import put_pose
from plumbline.engine.compile.jit import kernel
from plumbline.engine.maths.elementary import atan2
from plumbline.engine.maths.rows import Floats, Ints, Quat, Vec, load3, load4, store3, store4
from plumbline.engine.maths.vec import add, along, axpy, dot, norm, quat_conj, quat_mul, quat_turn, scale, sub
from plumbline.engine.memory import arena as at

ACCELERATION = 13
"""First column of the acceleration in a row of a path."""
PATH_COLUMNS = 16


@kernel
def write_path(start: Floats, end: Floats, path: Floats, b: int, span: float, a: Vec) -> None:
    """Write the path of body b between two states, `span` seconds apart, under the acceleration a [m/s2]."""
    q = load4(start, b, at.Q)
    store3(path, b, at.P, load3(start, b, at.P))
    store4(path, b, at.Q, q)
    mean_v = scale(1.0 / span, sub(load3(end, b, at.P), load3(start, b, at.P)))
    store3(path, b, at.V, axpy(-0.5 * span, a, mean_v))
    store3(path, b, ACCELERATION, a)
    turn = quat_mul(load4(end, b, at.Q), quat_conj(q))
    mean = scale(0.5, add(load3(start, b, at.W), load3(end, b, at.W)))
    axis = (turn[1], turn[2], turn[3])
    sine = norm(axis)
    axis = along(axis, along(mean, (0.0, 0.0, 1.0)))
    angle = 2.0 * atan2(sine, turn[0])
    angle += 2.0 * math.pi * round((span * dot(axis, mean) - angle) / (2.0 * math.pi))
    store3(path, b, at.W, scale(angle / span, axis))


@kernel
def body_at(path: Floats, b: int, time: float) -> tuple[Vec, Quat]:
    """The pose of body b at a time [s] of its path."""
    w = load3(path, b, at.W)
    q = load4(path, b, at.Q)
    if w != (0.0, 0.0, 0.0):
        q = quat_turn(q, w, time)
    return axpy(time, axpy(0.5 * time, load3(path, b, ACCELERATION), load3(path, b, at.V)), load3(path, b, at.P)), q


@kernel
def velocity_of(path: Floats, b: int, time: float) -> Vec:
    """The velocity [m/s] of the centre of mass of body b at a time [s] of its path."""
    return axpy(time, load3(path, b, ACCELERATION), load3(path, b, at.V))


@kernel
def shape_at(path: Floats, shape: Floats, shape_kind: Ints, s: int, time: float, pose: Floats) -> None:
    """Write the pose of shape s in W at a time [s] of its body's path."""
    p, q = body_at(path, shape_kind[s, at.OWNER], time)
    put_pose(shape, s, p, q, pose, s)
