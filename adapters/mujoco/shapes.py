"""Shapes as geoms, each of one native kind or a mesh."""

from collections.abc import Sequence
from typing import Any, assert_never

import numpy as np

from plumbline.adapters.mujoco.frames import upright
from plumbline.adapters.mujoco.plan import Plan
from plumbline.adapters.mujoco.uncompiled_model import Draft
from plumbline.harness.adapter import Unsupported
from plumbline.harness.adapter.convex_meshes import is_convex
from plumbline.harness.adapter.rotations import conjugate, matrix
from plumbline.harness.scene import (
    Box,
    Capsule,
    ConvexHull,
    Cylinder,
    Effect,
    Ellipsoid,
    PlacedShape,
    Plane,
    Sphere,
    TriangleMesh,
    Vector3,
    multiply,
)

COLLISION_GROUP, BOTH_GROUP, VISUAL_GROUP = 1, 0, 2
"""Geom groups: rays see shapes that collide, images see shapes that are drawn."""


def add_geom(plan: Plan, draft: Draft, k: int, placed: PlacedShape, name: str, drawn: bool = False) -> Any:
    """One shape of the body at a place of the scene, its pose S turned from B to M, or to W. Raises: Unsupported.

    Args: drawn: is it for pictures alone?
    """
    kinds, shape, body, node = draft.mj.mjtGeom, placed.shape, plan.scene.bodies[k], draft.bodies[k]
    p, q = np.zeros(3), conjugate(plan.q_BM[k])
    if plan.planted(body):
        node, p, q, draft.planted[name] = draft.spec.worldbody, plan.p[k], body.q_WB, k
    pose: dict[str, Any] = {"pos": p + matrix(q) @ placed.p_BS, "quat": multiply(q, placed.q_BS), "name": name}
    match shape:
        case Sphere(radius=r):
            return node.add_geom(type=kinds.mjGEOM_SPHERE, size=[r, 0, 0], **pose)
        case Box(half_extents=half):
            return node.add_geom(type=kinds.mjGEOM_BOX, size=half, **pose)
        case Capsule(radius=r, half_length=l):
            return node.add_geom(type=kinds.mjGEOM_CAPSULE, size=[r, l, 0], **pose)
        case Cylinder(radius=r, half_length=l):
            return node.add_geom(type=kinds.mjGEOM_CYLINDER, size=[r, l, 0], **pose)
        case Ellipsoid(semi_axes=semi_axes):
            return node.add_geom(type=kinds.mjGEOM_ELLIPSOID, size=semi_axes, **pose)
        case Plane(normal=n):
            if plan.prescribed(body):
                raise Unsupported(f"body '{body.name}': a plane that moves", "MuJoCo's planes are part of static bodies only")
            pose["quat"] = multiply(pose["quat"], upright(n))
            return node.add_geom(type=kinds.mjGEOM_PLANE, size=[0, 0, 1], **pose)
        case ConvexHull(vertices=vertices):
            return node.add_geom(type=kinds.mjGEOM_MESH, meshname=_add_mesh(draft, vertices, None), **pose)
        case TriangleMesh(vertices=vertices, faces=faces):
            if Effect.CONTACT in plan.effects and not drawn and not is_convex(np.array(vertices), np.array(faces)):
                raise Unsupported(
                    f"body '{body.name}': a mesh that is not convex and closed",
                    "MuJoCo collides a mesh as its hull, or as a distance field that is a tenth of a millimetre off",
                )
            return node.add_geom(type=kinds.mjGEOM_MESH, meshname=_add_mesh(draft, vertices, faces), **pose)
        case _ as other:
            assert_never(other)


def _add_mesh(draft: Draft, vertices: Sequence[Vector3], faces: Sequence[tuple[int, int, int]] | None) -> str:
    """A mesh, the hull of its vertices where no faces are given; its name."""
    name = f"m{draft.meshes}"
    draft.meshes += 1
    mesh = draft.spec.add_mesh(name=name)
    mesh.uservert = [float(c) for vertex in vertices for c in vertex]
    if faces is not None:
        mesh.userface = [int(c) for face in faces for c in face]
        # Exact volume would refuse open meshes, which rays may see; the inertia is given by the scene in any case.
        mesh.inertia = draft.mj.mjtMeshInertia.mjMESH_INERTIA_SHELL
    return name
