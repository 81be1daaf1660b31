"""The tree of joints: which bodies become links of one multibody, and which joints stay constraints."""

import math
from collections.abc import Container, Sequence
from dataclasses import dataclass

import numpy as np

from plumbline.adapters.bullet.frames import matrices, xyzw
from plumbline.harness.adapter import Unsupported
from plumbline.harness.adapter.between import on_massless
from plumbline.harness.adapter.carried_laws import carried, followed
from plumbline.harness.adapter.fast_rotors import fast_rotors
from plumbline.harness.adapter.spanning_forest import DisjointSets, spanning_forest
from plumbline.harness.scene import WORLD, Ball, Effect, Fixed, Joint, Revolute, Scene, Vector3


@dataclass(frozen=True, slots=True)
class Link:
    """A body of a tree: its place in the scene, its parent's among the links (-1: the base) and the joint between them."""

    place: int
    parent: int
    joint: Joint


@dataclass(frozen=True, slots=True)
class Tree:
    """One multibody: the base's place in the scene (None: the world), its links, and the joints that close its loops."""

    base: int | None
    links: tuple[Link, ...] = ()
    closures: tuple[Joint, ...] = ()


def loaded(joint: Joint) -> bool:
    """Does the joint carry more than its constraint?"""
    return bool(carried(joint))


def fast_tops(scene: Scene) -> frozenset[str]:
    """The ball joints that hold a fast top, by name: one body on what stands still, whose spin gravity cannot overturn.

    With s the angular momentum of the spin about the line from the joint to the centre of mass, of length l, and I the greatest
    moment about the joint: s^2 > 4 I m g l, and s above the rest of the angular momentum.

    Source: Goldstein, Classical Mechanics, 3rd ed., section 5.7 (the fast, and the sleeping, top).
    """
    held = [name for joint in scene.joints for name in (joint.parent, joint.child) if name != WORLD]
    pull = math.hypot(*scene.gravity) if Effect.GRAVITY in scene.effects else 0.0
    tops = set()
    for joint in scene.joints:
        ends = [scene.body(name) for name in (joint.parent, joint.child) if name != WORLD]
        moving = [body for body in ends if body.motion != "static"]
        if not isinstance(joint, Ball) or len(moving) != 1 or not moving[0].movable or held.count(moving[0].name) != 1:
            continue
        body = moving[0]
        arm = np.subtract(body.p_WB, joint.anchor_W)
        reach = float(np.linalg.norm(arm))
        if reach == 0.0:
            continue
        R = matrices(np.array([xyzw(body.q_WB)]))[0]
        momentum = R @ np.asarray(body.inertia) @ R.T @ np.asarray(body.w_WB)
        spin = float(momentum @ arm) / reach
        across = float(np.linalg.norm(momentum - spin * arm / reach))
        greatest = float(np.linalg.eigvalsh(np.asarray(body.inertia)).max()) + body.mass * reach**2
        if abs(spin) > across and spin**2 > 4 * greatest * body.mass * pull * reach:
            tops.add(joint.name)
    return frozenset(tops)


def constrained_joints(scene: Scene, joints: Sequence[Joint], choice: str) -> frozenset[str]:
    """The joints, by name, that are constraints between free bodies rather than links of a multibody."""
    if choice == "links" or not joints:
        return frozenset()
    plain = [joint for joint in joints if isinstance(joint, Ball | Fixed | Revolute) and not loaded(joint)]
    free = frozenset(joint.name for joint in plain) - followed(scene) - on_massless(scene)
    return free if choice == "constraints" else fast_tops(scene) | (fast_rotors(scene).hinges & free)


def spanning_trees(scene: Scene, joints: Sequence[Joint], constrained: Container[str]) -> list[Tree]:
    """All movable and kinematic bodies in spanning trees; joints with limits, springs or drives are never the closing ones.

    Args: constrained: names of joints that are constraints, whether they close a loop or not.
    """
    place = {body.name: k for k, body in enumerate(scene.bodies)}
    motion = {body.name: body.motion for body in scene.bodies} | {WORLD: "static"}
    groups = DisjointSets[str]()
    for joint in joints:
        if "static" not in (motion[joint.parent], motion[joint.child]):
            groups.unite(joint.parent, joint.child)

    def ground(name: str, other: str) -> str:
        # All that stands still is one node per group: two pendulums on one wall stay two multibodies. Names are printable, so
        # the line break makes a node that no body can be called.
        return f"\n{groups.root(other)}" if motion[name] == "static" else name

    ends = {j.name: (ground(j.parent, j.child), ground(j.child, j.parent)) for j in joints}
    grounds = sorted({end for pair in ends.values() for end in pair if end.startswith("\n")})
    others = followed(scene) | on_massless(scene)
    ordered = sorted(joints, key=lambda j: (not loaded(j) and j.name not in others, j.type == "ball", j.type == "fixed"))
    forest = spanning_forest((j for j in ordered if j.name not in constrained), lambda j: ends[j.name])
    looping = {joint.name for joint in forest.closing}
    closing = [(ends[j.name][0], j) for j in ordered if j.name in constrained or j.name in looping]
    moving = [body.name for body in scene.bodies if body.motion != "static"]
    children = {joint.child for joint in joints}
    roots = [*grounds]
    roots += [name for name in moving if motion[name] == "kinematic"]
    roots += [name for name in moving if name not in children] + moving
    trees: list[Tree] = []
    seen: set[str] = set()
    for root in roots:
        if root in seen:
            continue
        numbers, links = {root: -1}, list[Link]()
        # Depth first, children in their order: pybullet numbers links so, whatever order it is told.
        for branch in forest.depth_first(root):
            if motion[branch.node] == "kinematic":
                raise Unsupported(
                    f"joint '{branch.edge.name}'", "Bullet's multibody has one base; a second prescribed body is no link"
                )
            numbers[branch.node] = len(links)
            links.append(Link(place[branch.node], numbers[branch.above], branch.edge))
        seen |= numbers.keys()
        closures = [joint for name, joint in closing if name in numbers]
        trees.append(Tree(None if root in grounds else place[root], tuple(links), tuple(closures)))
    return trees


def joint_axis(joint: Joint, child: str) -> Vector3:
    """The axis in W, reversed where the tree runs from the joint's child to its parent: so its coordinate keeps its sign."""
    x, y, z = getattr(joint, "axis_W", (0.0, 0.0, 1.0))
    return (x, y, z) if joint.child == child else (-x, -y, -z)
