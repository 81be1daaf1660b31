"""The graph of joints: what becomes trees of skeletons, and which joints are constraints instead."""

from dataclasses import dataclass
from typing import assert_never

import numpy as np

from plumbline.adapters.dart.spinning_tops import spins
from plumbline.harness.adapter import Unsupported
from plumbline.harness.adapter.between import on_massless
from plumbline.harness.adapter.carried_laws import carried
from plumbline.harness.adapter.fast_rotors import fast_rotors
from plumbline.harness.adapter.spanning_forest import spanning_forest
from plumbline.harness.scene import Ball, Body, Distance, Fixed, Joint, Prismatic, Revolute, Scene
from plumbline.harness.trajectory import Floats

WORLD_FRAME = -1
"""The place of the world, and of every static body, in the graph of joints."""


@dataclass(frozen=True, slots=True)
class Edge:
    """A body in its skeleton: `joint` holds it to `parent`, `sign` is -1 where the scene's parent hangs on its child."""

    body: int
    parent: int
    joint: Joint | None
    sign: float


def forest(scene: Scene, joints: tuple[Joint, ...], constrained: list[Joint]) -> tuple[list[Edge], list[Joint]]:
    """The bodies that are not static, parents first, and all joints that are constraints: those given and what closes a loop.

    Raises: Unsupported.
    """
    moving = [i for i, b in enumerate(scene.bodies) if b.motion != "static"]
    between = on_massless(scene)
    trees = spanning_forest(
        sorted((joint for joint in joints if joint not in constrained), key=lambda j: j.name not in between and cuttable(j)),
        lambda joint: ends(scene, joint),
        ground=(WORLD_FRAME, *(i for i in moving if not scene.bodies[i].movable)),
    )
    for joint in trees.closing:
        if not cuttable(joint):
            raise Unsupported(
                f"joint '{joint.name}'",
                f"it closes a loop, and DART has no such constraint for {joint.type} joints, limits, springs and drives",
            )
    edges: list[Edge] = []
    seen = {WORLD_FRAME}
    for root in (WORLD_FRAME, *sorted(moving, key=lambda i: scene.bodies[i].movable)):
        if root in seen and root != WORLD_FRAME:
            continue
        if root != WORLD_FRAME:
            edges.append(Edge(root, WORLD_FRAME, None, 1.0))
            seen.add(root)
        for branch in trees.breadth_first(root):
            seen.add(branch.node)
            sign = 1.0 if ends(scene, branch.edge)[0] == branch.above else -1.0
            edges.append(Edge(branch.node, branch.above, branch.edge, sign))
    return edges, [*constrained, *trees.closing]


def constrained_joints(scene: Scene, joints: tuple[Joint, ...], how: str) -> list[Joint]:
    """The joints that shall be constraints on free bodies: none, all that can be, or ('auto') those of tops and fast rotors.

    DART's explicit step turns the velocities of a BallJoint, which are those in the body, and so lengthens them by (W h)^2/2 a
    step, W the rate of the wobble; those of a FreeJoint are in W, where a top's spin turns nothing. Without spin coordinates
    are better: they leave no gap.
    """
    if how == "coordinates":
        return []
    between = on_massless(scene)
    free = tuple(joint for joint in joints if joint.name not in between)
    if how == "constraints":
        return [joint for joint in free if cuttable(joint)]
    rotors = fast_rotors(scene).hinges
    return [joint for joint in free if (joint.name in rotors and cuttable(joint)) or _holds_a_top(scene, joint)]


def _holds_a_top(scene: Scene, joint: Joint) -> bool:
    """Is this a ball joint of a body that spins?"""
    if not isinstance(joint, Ball):
        return False
    held = [scene.bodies[i] for i in ends(scene, joint) if i != WORLD_FRAME]
    return any(body.movable and spins(scene, body, joint.anchor_W) for body in held)


def ends(scene: Scene, joint: Joint) -> tuple[int, int]:
    """The places of parent and child; static bodies are the world."""
    places = []
    for name in (joint.parent, joint.child):
        place = next((i for i, b in enumerate(scene.bodies) if b.name == name), WORLD_FRAME)
        places.append(WORLD_FRAME if place >= 0 and scene.bodies[place].motion == "static" else place)
    return places[0], places[1]


def cuttable(joint: Joint) -> bool:
    """Has DART a loop-closing constraint for it?"""
    if isinstance(joint, Revolute):
        return not carried(joint)
    return isinstance(joint, Fixed | Ball)


def check_velocities(scene: Scene, joint: Joint) -> None:
    """Do the initial velocities obey the joint? Raises: Unsupported."""
    if isinstance(joint, Distance):
        raise Unsupported(
            f"joint '{joint.name}'", "DART has no distance joint and no constraint that keeps or bounds a distance"
        )
    parent, child = (None if i == WORLD_FRAME else scene.bodies[i] for i in ends(scene, joint))
    held = child if child is not None else parent
    assert held is not None
    anchor = np.array(held.p_WB if isinstance(joint, Fixed) else joint.anchor_W)
    (v_P, w_P), (v_C, w_C) = _velocity_at(parent, anchor), _velocity_at(child, anchor)
    dv, dw = v_C - v_P, w_C - w_P
    match joint:
        case Fixed():
            wrong = np.concatenate((dv, dw))
        case Ball():
            wrong = dv
        case Revolute(axis_W=axis):
            wrong = np.concatenate((dv, np.cross(axis, dw)))
        case Prismatic(axis_W=axis):
            wrong = np.concatenate((np.cross(axis, dv), dw))
        case _:
            assert_never(joint)
    speed = max(float(np.abs(np.concatenate((v_P, w_P, v_C, w_C))).max()), 1.0)
    if float(np.abs(wrong).max()) > 1e-6 * speed:
        raise Unsupported(
            f"joint '{joint.name}'",
            f"DART holds a joint by its coordinates; the initial velocities of '{joint.parent}' and '{joint.child}' break it "
            f"by {float(np.abs(wrong).max()):.3g}, expected velocities that the joint allows",
        )


def _velocity_at(body: Body | None, point: Floats) -> tuple[Floats, Floats]:
    """(v, w) in W of the point [m, in W] that is fixed in the body at time 0; None is the world."""
    if body is None:
        return np.zeros(3), np.zeros(3)
    v, w = map(np.array, body.velocity_at_start)
    return v + np.cross(w, point - np.array(body.p_WB)), w
