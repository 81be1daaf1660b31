"""Trees of joints that an engine can hold in reduced coordinates, where it does so beside joints that are constraints."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from plumbline.harness.adapter.spanning_forest import Branch, DisjointSets, spanning_forest
from plumbline.harness.scene import WORLD, Body, Effect, Fixed, Joint, Prismatic, Revolute, Scene

_OFF = 1e-6
"""By how much velocities at a joint may differ from what it allows, over the greatest of the scene."""


@dataclass(frozen=True, slots=True)
class JointTree:
    """Joints from the root on. Terms: root: a body's name, or the world's."""

    root: str
    branches: tuple[Branch[str, Joint], ...]


def trees_of(scene: Scene, joints: Sequence[Joint]) -> list[JointTree]:
    """The trees that multibodies can hold: of fixed joints, hinges and slides, of bodies that nothing damps or prescribes."""
    still = [WORLD, *(body.name for body in scene.bodies if body.motion == "static")]
    groups = DisjointSets[str]()
    apt: list[Joint] = [joint for joint in joints if isinstance(joint, Fixed | Revolute | Prismatic)]
    for joint in joints:
        for name in (joint.parent, joint.child):
            if name not in still:
                groups.unite(joint.child if joint.child not in still else joint.parent, name)
        if joint.parent not in still and joint.child not in still:
            groups.unite(joint.parent, joint.child)
    barred = {groups.root(body.name) for body in scene.bodies if body.motion == "kinematic" or _damped(body, scene.effects)}
    barred |= {groups.root(_moving(j, still)) for j in joints if j not in apt or not _allowed(scene, j)}
    # A hinge that is an impulse joint and closes a loop of hinges stops multibodies dead: four bars at 1 rad/s in two steps.
    barred |= {groups.root(_moving(j, still)) for j in spanning_forest(apt, lambda j: (j.parent, j.child), still).closing}
    forest = spanning_forest(
        (j for j in apt if groups.root(_moving(j, still)) not in barred), lambda j: (j.parent, j.child), still
    )
    trees, seen = [], set[str]()
    for root in (*still, *(body.name for body in scene.bodies if body.movable)):
        if root in seen or root not in forest.beside:
            continue
        branches = tuple(forest.breadth_first(root))
        seen |= {branch.node for branch in branches}
        trees += _apart(branches) if root == WORLD else [JointTree(root, branches)]
    return trees


def _apart(branches: tuple[Branch[str, Joint], ...]) -> list[JointTree]:
    """What hangs on the world, each by itself: a multibody's work grows faster than its links."""
    first = {branch.node: k for k, branch in enumerate(b for b in branches if b.above == WORLD)}
    for branch in branches:
        first.setdefault(branch.node, first.get(branch.above, 0))
    return [JointTree(WORLD, tuple(b for b in branches if first[b.node] == k)) for k in sorted(set(first.values()))]


def _moving(joint: Joint, still: Sequence[str]) -> str:
    return joint.parent if joint.child in still else joint.child


def _damped(body: Body, effects: Effect) -> bool:
    linear, angular = Effect.LINEAR_DAMPING in effects, Effect.ANGULAR_DAMPING in effects
    return body.movable and bool((linear and body.linear_damping) or (angular and body.angular_damping))


def _allowed(scene: Scene, joint: Joint) -> bool:
    """Are the velocities at the start such as the joint allows?"""
    velocities, greatest = [], 1.0
    anchor = np.asarray(getattr(joint, "anchor_W", None) or (0.0, 0.0, 0.0))
    for name in (joint.parent, joint.child):
        if name == WORLD:
            velocities.append((np.zeros(3), np.zeros(3)))
            continue
        body = scene.body(name)
        v, w = np.asarray(body.v_WB), np.asarray(body.w_WB)
        velocities.append((v + np.cross(w, anchor - body.p_WB), w))
        greatest = max(greatest, float(np.abs(velocities[-1]).max()))
    slip, turn = (b - a for a, b in zip(*velocities, strict=True))
    if not isinstance(joint, Fixed):
        free = slip if isinstance(joint, Prismatic) else turn
        free -= (free @ joint.axis_W) * np.asarray(joint.axis_W)  # type: ignore[union-attr]
    return bool(max(np.abs(slip).max(), np.abs(turn).max()) <= _OFF * greatest)
