"""Joints as constraints between the points of two bodies: what closes a loop, and what holds a free body."""

import math

from plumbline.adapters.bullet.bodies_made import Assembly
from plumbline.adapters.bullet.frames import minus, xyzw
from plumbline.adapters.bullet.plan import Plan
from plumbline.adapters.bullet.trees import loaded
from plumbline.adapters.bullet.vendor import LIFTED
from plumbline.harness.adapter import Unsupported
from plumbline.harness.adapter.rotations import IDENTITY, conjugate
from plumbline.harness.scene import Ball, Coupling, Fixed, Joint, Revolute, Vector3, rotate


def close_loop(plan: Plan, made: Assembly, joint: Joint) -> None:
    """A joint that closes a loop, as constraints between points of the two bodies."""
    bullet = made.port.bullet
    if loaded(joint) or not isinstance(joint, Ball | Fixed | Revolute):
        raise Unsupported(
            f"joint '{joint.name}'",
            "as the closing joint of a loop Bullet holds balls, welds and plain hinges; its slide lets two bodies turn",
        )
    child, parent = (_end(plan, made, name) for name in (joint.child, joint.parent))
    if child is None:
        child, parent = parent, None
    assert child is not None
    points = [getattr(joint, "anchor_W", plan.scene.body(joint.child).p_WB)]
    kind = bullet.JOINT_FIXED if isinstance(joint, Fixed) else bullet.JOINT_POINT2POINT
    if isinstance(joint, Revolute):
        # Two common points on the axis leave nothing but the rotation about it; far apart, as the bodies are big.
        reach = max(math.dist(points[0], plan.scene.body(joint.child).p_WB), 0.05)
        points = [tuple(a + s * reach * c for a, c in zip(points[0], joint.axis_W, strict=True)) for s in (-1, 1)]
    for point in points:
        frames = [_frame(plan, end, point) for end in (child, parent)]
        constraint = made.port.call(
            "createConstraint",
            child[0],
            child[1],
            -1 if parent is None else parent[0],
            -1 if parent is None else parent[1],
            kind,
            [0.0, 0.0, 0.0],
            frames[0][0],
            frames[1][0],
            frames[0][1],
            frames[1][1],
        )
        made.port.call("changeConstraint", constraint, maxForce=LIFTED)


def couple(made: Assembly, joint: str, coupling: Coupling) -> None:
    """Tie two joint coordinates: Bullet's gear has x' + gearRatio y' = 0 along the two links' joints. Raises: Unsupported."""
    for name in (joint, coupling.joint):
        if name not in made.coordinates:
            raise Unsupported(
                f"joint '{joint}': coupling to '{coupling.joint}'", f"'{name}' closes a loop and has no coordinate"
            )
    ends = (*made.coordinates[joint][:2], *made.coordinates[coupling.joint][:2])
    gear = made.port.call("createConstraint", *ends, made.port.bullet.JOINT_GEAR, [0.0, 0.0, 1.0], [0.0] * 3, [0.0] * 3)
    made.port.call("changeConstraint", gear, gearRatio=-coupling.ratio, maxForce=LIFTED)


def _end(plan: Plan, made: Assembly, name: str) -> tuple[int, int, int] | None:
    """(number, link, place) of a body that moves; None for what stands still."""
    for (number, link), place in made.address.items():
        if plan.scene.bodies[place].name == name and plan.scene.bodies[place].motion != "static":
            return number, link, place
    return None


def _frame(plan: Plan, end: tuple[int, int, int] | None, point: Vector3) -> tuple[Vector3, list[float]]:
    """A point of W, and W's axes, in the frame I of a body (or in W)."""
    if end is None:
        return point, xyzw(IDENTITY)
    back = conjugate(plan.q_WI(end[2]))
    return rotate(back, minus(point, plan.scene.bodies[end[2]].p_WB)), xyzw(back)
