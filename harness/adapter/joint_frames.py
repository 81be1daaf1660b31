"""Frames of joints whose x lies along the axis, in both bodies, for engines that are told joints so."""

import math

from plumbline.harness.adapter.rotations import IDENTITY, conjugate
from plumbline.harness.scene import WORLD, Fixed, Joint, Prismatic, Quaternion, Scene, Vector3, multiply, rotate

Frame = tuple[Vector3, Quaternion]
"""Origin [m] and q of a frame in a body."""


def joint_frames(scene: Scene, joint: Joint, node: str) -> tuple[Frame, Frame]:
    """The joint's frame J in the body that it comes from and in that which it leads to, by name `node`, at the start.

    Towards the scene's parent the axis is turned about, which leaves the coordinate as it is. Where the anchor means nothing, J
    lies at a centre of mass: with a lever of 5 m the motor of a slide in Rapier lacked 12 % of its force.
    """
    moved = joint.child if joint.child != WORLD and scene.body(joint.child).movable else joint.parent
    central = isinstance(joint, Fixed | Prismatic) and moved != WORLD
    anchor = scene.body(moved).p_WB if central else getattr(joint, "anchor_W", (0.0, 0.0, 0.0))
    x, y, z = getattr(joint, "axis_W", (1.0, 0.0, 0.0))
    away = node == joint.child
    q_WJ = _along_x((x, y, z) if away else (-x, -y, -z))
    first, second = (joint.parent, joint.child) if away else (joint.child, joint.parent)
    return _frame(scene, first, anchor, q_WJ), _frame(scene, second, anchor, q_WJ)


def within(scene: Scene, name: str, point_W: Vector3) -> Vector3:
    """A point of W in the frame of a body at the start, or of the world [m]."""
    return _frame(scene, name, point_W, IDENTITY)[0]


def _frame(scene: Scene, name: str, point_W: Vector3, q_WJ: Quaternion) -> Frame:
    if name == WORLD:
        return point_W, q_WJ
    body = scene.body(name)
    x, y, z = (a - b for a, b in zip(point_W, body.p_WB, strict=True))
    back = conjugate(body.q_WB)
    return rotate(back, (x, y, z)), multiply(back, q_WJ)


def _along_x(axis: Vector3) -> Quaternion:
    """A rotation that turns x to the axis: by half a turn about the line midway between x and that end which looks ahead."""
    sign = 1.0 if axis[0] >= 0 else -1.0
    x, y, z = (sign * c for c in axis)
    long = math.hypot(1.0 + x, y, z)
    turn = (0.0, (1.0 + x) / long, y / long, z / long)
    return turn if sign > 0 else multiply(turn, (0.0, 0.0, 1.0, 0.0))
