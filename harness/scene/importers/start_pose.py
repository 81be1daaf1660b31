"""A scene whose joints start elsewhere: bodies, anchors and axes go with them, as forward kinematics has it."""

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from plumbline.harness.intake.error import RobotError
from plumbline.harness.intake.safe_text import quoted
from plumbline.harness.scene import WORLD, Ball, Body, Distance, Fixed, Joint, Prismatic, Revolute, Scene
from plumbline.harness.scene.importers.poses import IDENTITY, Pose, matrix, quaternion, screw, vector

_SAME = 1e-9
"""Metres and shares of a turn that two ways to one pose may differ by."""


def started_at(scene: Scene, positions: Mapping[str, float], source: str) -> Scene:
    """The scene with joints at these coordinates [rad or m] at the start; others stay, coupled ones follow theirs.

    Bodies at the root of a chain stay where they are. Args: source: who says so, for messages.
    Raises:
        RobotError: where a joint that closes a loop would be torn, or bodies start with velocities that would no longer fit.
    """
    scalar = {joint.name: joint for joint in scene.joints if isinstance(joint, Revolute | Prismatic)}

    def coordinate(name: str) -> float:
        tie = scalar[name].coupling
        return positions.get(name, scalar[name].position) if tie is None else tie.ratio * coordinate(tie.joint) + tie.offset

    children = {joint.child for joint in scene.joints if not isinstance(joint, Distance)}
    moved = {WORLD: IDENTITY} | {body.name: IDENTITY for body in scene.bodies if body.name not in children}
    reached: list[Joint] = []
    waiting = [joint for joint in scene.joints if not isinstance(joint, Distance)]
    while following := [joint for joint in waiting if joint.parent in moved]:
        for joint in following:
            along = IDENTITY
            if isinstance(joint, Revolute | Prismatic):
                travel = coordinate(joint.name) - joint.position
                turned, slid = (travel, 0.0) if isinstance(joint, Revolute) else (0.0, travel)
                along = screw(np.array(joint.axis_W), np.array(joint.anchor_W), turned, slid)
            there = moved[joint.parent] @ along
            if not _same(moved.setdefault(joint.child, there), there):
                raise _torn(joint, source)
            reached.append(joint)
        waiting = [joint for joint in waiting if joint not in reached]
    for closing in scene.joints:
        apart = not _same(moved.get(closing.parent, IDENTITY), moved.get(closing.child, IDENTITY))
        if apart and (isinstance(closing, Distance) or closing in waiting):
            raise _torn(closing, source)

    def placed(body: Body) -> Body:
        X = moved.get(body.name, IDENTITY)
        if _same(X, IDENTITY):
            return body
        if np.any(body.v_WB) or np.any(body.w_WB):
            raise RobotError(
                f"{source}: body {quoted(body.name, 80)} has a velocity that is of another pose; expected a start at rest"
            )
        R_WB = X.R @ matrix(body.q_WB)
        return replace(body, p_WB=vector(X.of(np.array(body.p_WB))), q_WB=quaternion(R_WB))

    def hung(joint: Joint) -> Joint:
        X = moved.get(joint.parent, IDENTITY)
        if isinstance(joint, Fixed):
            return joint
        anchor_W = vector(X.of(np.array(joint.anchor_W)))
        if isinstance(joint, Ball):
            return replace(joint, anchor_W=anchor_W)
        if isinstance(joint, Distance):
            return replace(joint, anchor_W=anchor_W, child_anchor_W=vector(X.of(np.array(joint.child_anchor_W))))
        axis_W = vector(X.R @ np.array(joint.axis_W))
        return replace(joint, anchor_W=anchor_W, axis_W=axis_W, position=coordinate(joint.name))

    return replace(scene, bodies=tuple(map(placed, scene.bodies)), joints=tuple(map(hung, scene.joints)))


def _same(first: Pose, second: Pose) -> bool:
    return bool(np.allclose(first.R, second.R, rtol=0.0, atol=_SAME) and np.allclose(first.p, second.p, rtol=0.0, atol=_SAME))


def _torn(joint: Joint, source: str) -> RobotError:
    return RobotError(
        f"{source}: joint {quoted(joint.name, 80)} closes a loop, which the start pose would tear; expected a start that keeps "
        "it, said in the file"
    )
