"""The bodies: skeletons, masses, dampers, the velocities that they start with."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from plumbline.adapters.dart.built import Built
from plumbline.adapters.dart.joints import add_joint
from plumbline.adapters.dart.shapes import add_shapes
from plumbline.adapters.dart.trees import WORLD_FRAME, Edge
from plumbline.adapters.dart.vendor import pose
from plumbline.harness.adapter.touching_kinds import Kind
from plumbline.harness.scene import Effect

FAINT = 1e-12
"""Of mass and inertia, what bodies without mass get: DART takes none too, at the price of a warning for each; what this adds to
any inertia is its rounding."""


def add_bodies(built: Built, edges: list[Edge], coefficients: Mapping[Kind, tuple[float, float]]) -> None:
    """Skeletons, nodes, joints, masses and shapes; joint-free bodies first, in the order that `state` reads them.

    Args:
        edges: the bodies that are not static, parents first.
        coefficients: (friction, restitution) of each kind of body [1].
    """
    dart, scene = built.dart, built.scene
    dynamics, skeletons = dart.dynamics, list[Any]()
    parents = {e.parent for e in edges if e.joint is not None}
    alone = [e for e in edges if e.joint is None and e.body not in parents]
    edges = alone + [e for e in edges if not (e.joint is None and e.body not in parents)]
    built.free = [e.body for e in alone]
    built.linked = [e.body for e in edges[len(alone) :]]
    for edge in edges:
        body = scene.bodies[edge.body]
        if edge.parent == WORLD_FRAME:
            skeleton = dynamics.Skeleton(f"skeleton {edge.body}")
            skeletons.append(skeleton)
            built.skeletons.append(skeleton)
            joint, node = add_joint(built, skeleton, edge)
        else:
            joint, node = add_joint(built, built.nodes[edge.parent], edge)
            node.getSkeleton().enableSelfCollisionCheck()
            node.getSkeleton().enableAdjacentBodyCheck()
        joint.setName(f"joint {edge.body}")
        node.setName(f"body {edge.body}")
        node.setInertia(_inertia(built, edge.body))
        built.nodes[edge.body] = node
        if edge.joint is not None:
            built.hung[edge.joint.name] = edge.body
        add_shapes(built, edge.body, coefficients)
        _damp(built, edge, joint, edge.body in built.free)
    for i, body in enumerate(scene.bodies):
        if body.motion == "static":
            skeleton = dynamics.Skeleton(f"skeleton {i}")
            joint, node = skeleton.createWeldJointAndBodyNodePair()
            joint.setTransformFromParentBodyNode(pose(dart, body.p_WB, body.q_WB))
            node.setName(f"body {i}")
            skeleton.setMobile(False)
            built.nodes[i] = node
            skeletons.append(skeleton)
            add_shapes(built, i, coefficients)
    for skeleton in skeletons:
        built.world.addSkeleton(skeleton)


def _inertia(built: Built, place: int) -> Any:
    """Mass and inertia of a body; of one without mass `FAINT` of those of the lightest body of the scene that has some."""
    body, Inertia = built.scene.bodies[place], built.dart.dynamics.Inertia
    if not body.massless:
        return Inertia(body.mass, np.zeros(3), np.asarray(body.inertia))
    solid = [other for other in built.scene.bodies if other.movable and not other.massless]
    least = min(float(np.linalg.eigvalsh(np.asarray(other.inertia))[0]) for other in solid)
    return Inertia(FAINT * min(other.mass for other in solid), np.zeros(3), FAINT * least * np.eye(3))


def _damp(built: Built, edge: Edge, joint: Any, alone: bool) -> None:
    """Damp a body by its joint where that is the scene's law exactly, else by forces of each step."""
    effects, body = built.effects, built.scene.bodies[edge.body]
    c = body.linear_damping if Effect.LINEAR_DAMPING in effects else 0.0
    d = body.angular_damping if Effect.ANGULAR_DAMPING in effects else 0.0
    if not body.movable or (c == 0 and d == 0):
        return
    low, _, high = np.linalg.eigvalsh(np.asarray(body.inertia))
    if alone and (d == 0 or high - low <= 1e-12 * high):
        for k in range(3):
            joint.setDampingCoefficient(k, d * float(high))
            joint.setDampingCoefficient(3 + k, c * body.mass)
    else:
        built.damped.append((edge.body, c, d))


def start(built: Built) -> None:
    """Initial velocities of trees of joints: the rates of the coordinates that give every body the scene's velocity."""
    trees: dict[int, tuple[Any, list[int]]] = {}
    for i in built.linked:
        skeleton = built.nodes[i].getSkeleton()
        trees.setdefault(id(skeleton), (skeleton, []))[1].append(i)
    for skeleton, places in trees.values():
        if skeleton.getNumDofs() == 0:
            continue
        jacobian = np.vstack([np.asarray(skeleton.getWorldJacobian(built.nodes[i])) for i in places])
        bodies = [built.scene.bodies[i] for i in places]
        wanted = np.array([x for b in bodies for vector in reversed(b.velocity_at_start) for x in vector])
        if wanted.any():
            skeleton.setVelocities(np.linalg.lstsq(jacobian, wanted, rcond=None)[0])
        else:
            skeleton.resetVelocities()
