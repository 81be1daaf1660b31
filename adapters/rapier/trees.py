"""Trees of joints in reduced coordinates: which joints make them, and the multibodies that they become."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from plumbline.harness.adapter.disjoint_sets import DisjointSets
from plumbline.harness.adapter.spanning_forest import Branch, spanning_forest
from plumbline.harness.scene import WORLD, Body, Effect, Fixed, Joint, Prismatic, Revolute, Scene
from plumbline.harness.trajectory import State
from plumbline.harness.trajectory.joint_states import joint_states

PRIMING = 1e-9
"""The length [s] of a step by which a multibody learns that its root stands still: until then that has six coordinates. At
1e-20, whose square is no number of single precision, an undamped spring of 80 N/m lost 9 % of its energy in 0.8 s."""
_OFF = 1e-6
"""By how much velocities at a joint may differ from what it allows, over the greatest of the scene."""


@dataclass(frozen=True, slots=True)
class Tree:
    """Joints from the root on. Terms: root: a body's name, or the world's."""

    root: str
    branches: tuple[Branch[str, Joint], ...]


def trees_of(scene: Scene, joints: Sequence[Joint]) -> list[Tree]:
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
    # An impulse joint that closes a loop of hinges stops multibodies dead: four bars at 1 rad/s within two steps.
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
        trees += _apart(branches) if root == WORLD else [Tree(root, branches)]
    return trees


def _apart(branches: tuple[Branch[str, Joint], ...]) -> list[Tree]:
    """What hangs on the world, each by itself: a multibody's work grows faster than its links."""
    first = {branch.node: k for k, branch in enumerate(b for b in branches if b.above == WORLD)}
    for branch in branches:
        first.setdefault(branch.node, first.get(branch.above, 0))
    return [Tree(WORLD, tuple(b for b in branches if first[b.node] == k)) for k in sorted(set(first.values()))]


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


def put_trees(world: Any, scene: Scene, trees: Sequence[Tree], root: Callable[[str], Any], link: Callable[..., Any]) -> None:
    """Insert the joints of trees with the velocities of the start.

    Args: root: the handle that a tree's root has. link: inserts a joint towards the body of that name, whose parent is the root
    of its tree, or None for another body.
    """
    inserted = []
    for tree in trees:
        base = root(tree.root)
        ends = [link(b.edge, b.node, base if b.above == tree.root else None) for b in tree.branches]
        inserted.append((tree, ends[-1]))
    if not inserted:
        return
    parameters, gravity = world.integration_parameters, (world.gravity.x, world.gravity.y, world.gravity.z)
    usual, parameters.dt, world.gravity = parameters.dt, PRIMING, (0.0, 0.0, 0.0)
    world.step()
    parameters.dt, world.gravity = usual, gravity
    start = State.initial(scene)
    rate = dict(zip((joint.name for joint in scene.joints), joint_states(scene, start).rate.tolist(), strict=True))
    for tree, end in inserted:
        multibody = world.multibody_joints.multibody(end)
        rates, links = [0.0] * multibody.ndofs, {link.link_id: link for link in multibody}
        if links[0].ndofs == 6:
            body_index = scene.index(tree.root)
            rates[:6] = [*start.v_WB[body_index].tolist(), *start.w_WB[body_index].tolist()]
        for number, branch in enumerate(tree.branches, 1):
            if links[number].ndofs == 1:
                rates[links[number].assembly_id] = rate[branch.edge.name]
        multibody.set_damping([0.0] * multibody.ndofs)
        multibody.set_generalized_velocity(rates)
