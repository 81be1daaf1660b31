"""Kinematics of whole trajectories as NumPy arrays: rotations, points fixed to bodies, joint coordinates.

Quaternions are (..., 4), unit, (w, x, y, z), and map B to W. Source: Diebel, Representing Attitude (2006), sections 6 and 7.
"""

import numpy as np

from plumbline.harness.scene import WORLD, Distance, Joint, Prismatic, Revolute, Scene
from plumbline.harness.trajectory import Floats, Integers, Trajectory


def conjugate(q: Floats) -> Floats:
    """The inverse rotation, (..., 4)."""
    inverse: Floats = np.asarray(q, dtype=np.float64) * np.array([1.0, -1.0, -1.0, -1.0])
    return inverse


def cross(a: Floats, b: Floats) -> Floats:
    """a x b, (..., 3): the sums of `numpy.cross` to the bit, without its search for axes, which outweighs them."""
    out = np.empty(np.broadcast_shapes(a.shape, b.shape))
    a0, a1, a2, b0, b1, b2 = a[..., 0], a[..., 1], a[..., 2], b[..., 0], b[..., 1], b[..., 2]
    out[..., 0] = a1 * b2 - a2 * b1
    out[..., 1] = a2 * b0 - a0 * b2
    out[..., 2] = a0 * b1 - a1 * b0
    return out


def product(a: Floats, b: Floats) -> Floats:
    """The Hamilton product a b, (..., 4): first b, then a."""
    a, b = np.asarray(a, dtype=np.float64), np.asarray(b, dtype=np.float64)
    aw, av, bw, bv = a[..., :1], a[..., 1:], b[..., :1], b[..., 1:]
    scalar = aw * bw - np.sum(av * bv, axis=-1, keepdims=True)
    return np.concatenate([scalar, aw * bv + bw * av + cross(av, bv)], axis=-1)


def rotate(q_WB: Floats, vector_B: Floats) -> Floats:
    """The vector in W, (..., 3): v + 2 w (u x v) + 2 u x (u x v) for q = (w, u)."""
    q_WB, vector_B = np.asarray(q_WB, dtype=np.float64), np.asarray(vector_B, dtype=np.float64)
    w, u = q_WB[..., :1], q_WB[..., 1:]
    t = 2.0 * cross(u, vector_B)
    turned: Floats = vector_B + w * t + cross(u, t)
    return turned


def rotate_back(q_WB: Floats, vector_W: Floats) -> Floats:
    """The vector in B, (..., 3)."""
    return rotate(conjugate(q_WB), vector_W)


def about(axis: int, angle: Floats) -> Floats:
    """The rotation by angles [rad] (...) about a coordinate axis, 0, 1 or 2, (..., 4)."""
    q = np.zeros((*np.shape(angle), 4))
    q[..., 0], q[..., 1 + axis] = np.cos(angle / 2), np.sin(angle / 2)
    return q


def angle_between(a: Floats, b: Floats) -> Floats:
    """The angle [rad], 0..pi, of the rotation from a to b, (...); NaN where either is no rotation at all."""
    a, b = np.asarray(a, dtype=np.float64), np.asarray(b, dtype=np.float64)
    difference = product(conjugate(a), b)
    angle: Floats = 2.0 * np.arctan2(np.linalg.norm(difference[..., 1:], axis=-1), np.abs(difference[..., 0]))
    # A zero quaternion would pass for no rotation: arctan2(0, 0) is 0.
    lost = (np.linalg.norm(a, axis=-1) < 0.5) | (np.linalg.norm(b, axis=-1) < 0.5)
    return np.where(lost, np.nan, angle)


def movable(scene: Scene) -> Integers:
    """The places of the bodies with mass that a force moves, (m,)."""
    return np.array([i for i, body in enumerate(scene.bodies) if body.movable and not body.massless], dtype=np.int64)


def kinetic_energy(scene: Scene, trajectory: Trajectory) -> Floats:
    """Of all movable bodies at each time, (t,) J."""
    energy = np.zeros(len(trajectory))
    for place in movable(scene):
        body = scene.bodies[place]
        w_B = rotate_back(trajectory.q_WB[:, place], trajectory.w_WB[:, place])
        energy += 0.5 * body.mass * np.sum(np.square(trajectory.v_WB[:, place]), axis=-1)
        energy += 0.5 * np.sum(w_B * (w_B @ np.array(body.inertia)), axis=-1)
    return energy


def _fixed_point(scene: Scene, name: str, point_W: Floats, trajectory: Trajectory) -> Floats:
    """Where the point of body `name` that lay at point_W at time 0 is at each time, (t, 3) m."""
    if name == WORLD:
        return np.broadcast_to(point_W, (len(trajectory), 3))
    place = scene.index(name)
    body = scene.bodies[place]
    point_B = rotate_back(np.array(body.q_WB), point_W - np.array(body.p_WB))
    point: Floats = trajectory.p_WB[:, place] + rotate(
        trajectory.q_WB[:, place], np.broadcast_to(point_B, (len(trajectory), 3))
    )
    return point


def anchors(scene: Scene, joint: Joint, trajectory: Trajectory) -> tuple[Floats, Floats]:
    """The anchors of the parent and of the child at each time, each (t, 3) m; a fixed joint's is the child's centre of mass."""
    on_parent = np.array(getattr(joint, "anchor_W", scene.body(joint.child).p_WB))
    on_child = np.array(joint.child_anchor_W) if isinstance(joint, Distance) else on_parent
    return _fixed_point(scene, joint.parent, on_parent, trajectory), _fixed_point(scene, joint.child, on_child, trajectory)


def _attitude(scene: Scene, name: str, trajectory: Trajectory) -> tuple[Floats, Floats]:
    """q_WB of a body at the start of the scene, (4,), and at each time, (t, 4)."""
    if name == WORLD:
        unturned = np.array([1.0, 0.0, 0.0, 0.0])
        return unturned, np.broadcast_to(unturned, (len(trajectory), 4))
    place = scene.index(name)
    return np.array(scene.bodies[place].q_WB), trajectory.q_WB[:, place]


def _sliding_axis(scene: Scene, joint: Prismatic, trajectory: Trajectory) -> Floats:
    """The axis in W, fixed in the parent, at each time, (t, 3)."""
    q_P0, q_P = _attitude(scene, joint.parent, trajectory)
    return rotate(q_P, np.broadcast_to(rotate_back(q_P0, np.array(joint.axis_W)), (len(trajectory), 3)))


def across_axis(scene: Scene, joint: Prismatic, trajectory: Trajectory) -> Floats:
    """The distance [m] of the child's anchor from the sliding axis at each time, (t,)."""
    on_parent, on_child = anchors(scene, joint, trajectory)
    distance: Floats = np.linalg.norm(np.cross(on_child - on_parent, _sliding_axis(scene, joint, trajectory)), axis=-1)
    return distance


def joint_coordinate(scene: Scene, joint: Joint, trajectory: Trajectory) -> Floats:
    """The coordinate [rad or m] of a revolute, prismatic or distance joint at each time, (t,); angles are unwrapped.

    Raises:
        TypeError: the joint has no coordinate.
    """
    on_parent, on_child = anchors(scene, joint, trajectory)
    if isinstance(joint, Distance):
        distance: Floats = np.linalg.norm(on_child - on_parent, axis=-1)
        return distance
    if not isinstance(joint, Revolute | Prismatic):
        raise TypeError(f"joint '{joint.name}': a {joint.type} joint has no coordinate")
    if isinstance(joint, Prismatic):
        along: Floats = joint.position + np.sum((on_child - on_parent) * _sliding_axis(scene, joint, trajectory), axis=-1)
        return along
    q_P0, q_P = _attitude(scene, joint.parent, trajectory)
    q_C0, q_C = _attitude(scene, joint.child, trajectory)
    relative = product(conjugate(product(q_P, conjugate(q_P0))), product(q_C, conjugate(q_C0)))
    angle = 2.0 * np.arctan2(relative[:, 1:] @ np.array(joint.axis_W), relative[:, 0])
    # q and -q are one rotation: the first angle is taken within half a turn of the initial pose.
    unwrapped: Floats = joint.position + np.unwrap(angle - 2.0 * np.pi * np.round(angle[:1] / (2.0 * np.pi)))
    return unwrapped


def joint_rate(scene: Scene, joint: Joint, trajectory: Trajectory) -> Floats:
    """The rate [rad/s or m/s] of the coordinate of a revolute, prismatic or distance joint at each time, (t,).

    Of a revolute joint the angular velocity of the child over the parent's, on the axis; of the others the velocity of the
    child's anchor over that of the parent's point there, along the axis or the line. Raises: TypeError: it has no coordinate.
    """
    if isinstance(joint, Prismatic | Distance):
        return _sliding_rate(scene, joint, trajectory)
    if not isinstance(joint, Revolute):
        raise TypeError(f"joint '{joint.name}': a {joint.type} joint has no coordinate")
    q_P0, q_P = _attitude(scene, joint.parent, trajectory)
    axis = rotate(q_P, np.broadcast_to(rotate_back(q_P0, np.array(joint.axis_W)), (len(trajectory), 3)))
    turning = trajectory.w_WB[:, scene.index(joint.child)]
    if joint.parent != WORLD:
        turning = turning - trajectory.w_WB[:, scene.index(joint.parent)]
    rate: Floats = np.sum(turning * axis, axis=-1)
    return rate


def _sliding_rate(scene: Scene, joint: Prismatic | Distance, trajectory: Trajectory) -> Floats:
    on_parent, on_child = anchors(scene, joint, trajectory)
    way = on_child - on_parent
    if isinstance(joint, Prismatic):
        along = _sliding_axis(scene, joint, trajectory)
        on_parent = on_child
    else:
        along = way / np.linalg.norm(way, axis=-1, keepdims=True)
    speed = _speed_of(scene, joint.child, on_child, trajectory) - _speed_of(scene, joint.parent, on_parent, trajectory)
    rate: Floats = np.sum(speed * along, axis=-1)
    return rate


def _speed_of(scene: Scene, name: str, point: Floats, trajectory: Trajectory) -> Floats:
    """The velocity [m/s] in W of the points (t, 3) m of a body, (t, 3)."""
    if name == WORLD:
        return np.zeros_like(point)
    place = scene.index(name)
    speed: Floats = trajectory.v_WB[:, place] + np.cross(trajectory.w_WB[:, place], point - trajectory.p_WB[:, place])
    return speed


def carried(scene: Scene, joint: Revolute | Prismatic) -> float:
    """The inertia [kg m2, kg] that a joint carries at the start if all behind it are stiff, its rotor included."""
    behind, grown = {joint.child}, True
    while grown:
        more = {other.child for other in scene.joints if other.parent in behind} - behind
        grown, behind = bool(more), behind | more
    total, axis = joint.armature or 0.0, np.array(joint.axis_W)
    for name in behind - {WORLD}:
        body = scene.body(name)
        if isinstance(joint, Prismatic):
            total += body.mass
            continue
        arm = np.cross(axis, np.array(body.p_WB) - np.array(joint.anchor_W))
        axis_B = rotate(np.array(body.q_WB) * (1.0, -1.0, -1.0, -1.0), axis)
        total += body.mass * float(arm @ arm) + float(axis_B @ np.array(body.inertia) @ axis_B)
    return total
