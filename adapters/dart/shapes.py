"""The shapes of a body: for contact if the scene has any, else for rays alone."""

import tempfile
from collections.abc import Mapping
from pathlib import Path
from typing import Any, assert_never

import numpy as np

from plumbline.adapters.dart.built import Built
from plumbline.adapters.dart.vectors import tangents
from plumbline.adapters.dart.vendor import pose
from plumbline.harness.adapter import Unsupported
from plumbline.harness.adapter.touching_kinds import Kind
from plumbline.harness.scene import (
    Box,
    Capsule,
    ConvexHull,
    Cylinder,
    Effect,
    Ellipsoid,
    Plane,
    Quaternion,
    Shape,
    Sphere,
    TriangleMesh,
    axis_angle,
    multiply,
    rotation_matrix,
)
from plumbline.harness.trajectory import Floats, Integers

ASKEW = 1e-12
"""Under the ODE detector a box that leans over an edge along no axis of W is turned by its number times this [rad].

ODE (`box.cpp`, `dBoxBox`) holds boxes for apart that are so along the cross product of two edges, also where that is what
rounding leaves of parallel ones; along the axes of W it is nought, and left out. Of boxes that lean over an edge parallel to
one of what bears them, in directions drawn at random, 9 to 20 % have no contact at any depth; with edges 1e-15 rad apart all
have theirs. A house of cards fell so in one of sixteen directions. The corners of the hundredth box of a metre are 1e-10 m off.
"""
SLAB = 1e3
"""Under the Bullet detector, which holds a solid on a plane at one point, a plane is a slab of these half extents [m]."""


def add_shapes(built: Built, place: int, coefficients: Mapping[Kind, tuple[float, float]]) -> None:
    """Give the body at that place of the scene its shapes. Args: coefficients: (friction, restitution) of its kind [1]."""
    body, node = built.scene.bodies[place], built.nodes[place]
    for k, placed in enumerate(body.collision):
        shape_node = node.createShapeNode(_shape(built.dart, placed.shape), f"{place}/{k}")
        X_BS = pose(built.dart, placed.p_BS, placed.q_BS)
        if (
            built.resolved.options["detector"] == "ode"
            and isinstance(placed.shape, Box)
            and _leans(multiply(body.q_WB, placed.q_BS))
        ):
            askew = axis_angle((1.0, 1.0, 1.0), ASKEW * (len(built.shapes) + 1))
            X_BS = X_BS.multiply(pose(built.dart, (0.0, 0.0, 0.0), askew))
        shape_node.setRelativeTransform(X_BS)
        built.shapes.append(shape_node)
        if isinstance(placed.shape, Plane) and built.resolved.options["detector"] == "bullet":
            # Rays still meet the plane itself.
            shape_node = node.createShapeNode(_shape(built.dart, Box(half_extents=(SLAB, SLAB, SLAB))), f"{place}/{k}/slab")
            down = built.dart.math.Isometry3()
            normal = np.array(placed.shape.normal)
            down.set_rotation(np.vstack((tangents(normal), normal)).T)
            down.set_translation(-SLAB * normal)
            shape_node.setRelativeTransform(X_BS.multiply(down))
        if Effect.CONTACT in built.effects:
            shape_node.createCollisionAspect()
            shape_node.createDynamicsAspect()
            friction, restitution = coefficients[body.material, body.movable]
            aspect = shape_node.getDynamicsAspect()
            aspect.setFrictionCoeff(friction)
            aspect.setRestitutionCoeff(restitution)


def _leans(q_WS: Quaternion) -> bool:
    """Does no axis of a frame lie along an axis of W, to the last bit?"""
    return bool(np.all(np.count_nonzero(rotation_matrix(q_WS), axis=0) > 1))


def _shape(dart: Any, shape: Shape) -> Any:
    dynamics = dart.dynamics
    match shape:
        case Sphere(radius=r):
            return dynamics.SphereShape(r)
        case Box(half_extents=half):
            return dynamics.BoxShape(2 * np.array(half))
        case Capsule(radius=r, half_length=h):
            return dynamics.CapsuleShape(r, 2 * h)
        case Cylinder(radius=r, half_length=h):
            return dynamics.CylinderShape(r, 2 * h)
        case Ellipsoid(semi_axes=semi_axes):
            return dynamics.EllipsoidShape(2 * np.array(semi_axes))
        case Plane(normal=n):
            return dynamics.PlaneShape(np.array(n), 0.0)
        case ConvexHull(vertices=vertices):
            return _mesh(dart, *_surface(np.asarray(vertices)))
        case TriangleMesh(vertices=vertices, faces=faces):
            return _mesh(dart, np.asarray(vertices), np.asarray(faces))
        case _:
            assert_never(shape)


def _mesh(dart: Any, vertices: Floats, faces: Integers) -> Any:
    """A MeshShape: dartpy cannot make one from arrays, but its URDF reader can from a file."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "mesh.obj"
        lines = ["v {:.17g} {:.17g} {:.17g}".format(*v) for v in vertices.tolist()]
        lines += ["f {} {} {}".format(*f) for f in (faces + 1).tolist()]
        path.write_text("\n".join(lines) + "\n", encoding="ascii")
        urdf = (
            '<robot name="mesh"><link name="mesh"><collision><geometry>'
            f'<mesh filename="{path.as_uri()}"/></geometry></collision></link></robot>'
        )
        reader, files = dart.utils.DartLoader(), dart.common.LocalResourceRetriever()
        skeleton = reader.parseSkeletonString(urdf, dart.common.Uri("file:///"), files)
    if skeleton is None:
        raise Unsupported("mesh", f"dartpy's reader refused {len(vertices)} vertices and {len(faces)} faces")
    return skeleton.getBodyNode(0).getShapeNode(0).getShape()


def _surface(points: Floats) -> tuple[Floats, Integers]:
    """Vertices and faces, counter-clockwise from outside, of the convex hull of points (n, 3) m."""
    from scipy.spatial import ConvexHull as Hull

    hull = Hull(points)
    faces = np.array(hull.simplices, dtype=np.int64)
    corners = points[faces]
    across = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    inward = np.einsum("ij,ij->i", across, hull.equations[:, :3]) < 0
    faces[inward] = faces[inward][:, ::-1]
    used = np.unique(faces)
    return points[used], np.searchsorted(used, faces).astype(np.int64)
