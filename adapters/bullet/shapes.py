"""Shapes of collision and of pictures, each made in one call of the binding."""

import itertools
import tempfile
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, assert_never

import numpy as np

from plumbline.adapters.bullet.frames import plus, xyzw
from plumbline.adapters.bullet.vendor import Port
from plumbline.harness.adapter import Unsupported
from plumbline.harness.scene import (
    Body,
    Box,
    Capsule,
    ConvexHull,
    Cylinder,
    Ellipsoid,
    Plane,
    Quaternion,
    Scene,
    Shape,
    Sphere,
    TriangleMesh,
    Vector3,
    polyhedron_of,
    rotate,
)

Placed = tuple[Shape, Vector3, Quaternion]
"""A shape with its pose in the frame of a body or a link."""
NO_ELLIPSOID = (
    "an ellipsoid",
    "pybullet makes none; the hull of points on one is another shape, which ellipsoids = 'polyhedra' beside a robot asks for",
)
"""What is refused, and why."""
PLANE_WIDTH = 1000.0
"""Side [m] of the square that stands for a plane in images."""


def _write_mesh(path: Path, vertices: Iterable[Vector3], faces: Iterable[Sequence[int]]) -> str:
    """An OBJ file of a mesh; returns its name."""
    lines = [f"v {x!r} {y!r} {z!r}" for x, y, z in vertices]
    lines += [f"f {a + 1} {b + 1} {c + 1}" for a, b, c in faces]
    path.write_text("\n".join(lines) + "\n")
    return str(path)


def _hull_faces(shape: ConvexHull) -> list[list[int]]:
    """Triangles of a convex hull by their vertices, counter-clockwise seen from outside."""
    from scipy.spatial import ConvexHull as Hull

    points = np.asarray(shape.vertices)
    hull = Hull(points)
    faces: list[list[int]] = []
    for (a, b, c), plane in zip(hull.simplices, hull.equations, strict=True):
        outward = float(np.dot(np.cross(points[b] - points[a], points[c] - points[a]), plane[:3])) > 0
        faces.append([int(a), int(b), int(c)] if outward else [int(a), int(c), int(b)])
    return faces


@dataclass(slots=True)
class _ShapeTable:
    """The arrays that createCollisionShapeArray and createVisualShapeArray read in step, one row a shape."""

    types: list[int] = field(default_factory=list)
    radii: list[float] = field(default_factory=list)
    halves: list[list[float]] = field(default_factory=list)
    lengths: list[float] = field(default_factory=list)
    files: list[str] = field(default_factory=list)
    normals: list[list[float]] = field(default_factory=list)
    flags: list[int] = field(default_factory=list)
    positions: list[Vector3] = field(default_factory=list)
    turns: list[list[float]] = field(default_factory=list)

    def add(self, bullet: Any, shape: Shape, p_LS: Vector3, q_LS: Quaternion, folder: Path) -> None:
        """Append one shape at its pose in the link frame L; meshes are written into `folder`."""
        kind, radius, half, length, file, normal, flag = bullet.GEOM_SPHERE, 0.0, [0.0] * 3, 0.0, "", [0.0, 0.0, 1.0], 0
        path = folder / f"{id(self)}_{len(self.types)}.obj"
        match shape:
            case Sphere():
                radius = shape.radius
            case Box():
                kind, half = bullet.GEOM_BOX, list(shape.half_extents)
            case Capsule():
                kind, radius, length = bullet.GEOM_CAPSULE, shape.radius, 2 * shape.half_length
            case Cylinder():
                kind, radius, length = bullet.GEOM_CYLINDER, shape.radius, 2 * shape.half_length
            case Plane():
                kind, normal = bullet.GEOM_PLANE, list(shape.normal)
            case ConvexHull():
                kind, file = bullet.GEOM_MESH, _write_mesh(path, shape.vertices, _hull_faces(shape))
            case TriangleMesh():
                kind, file = bullet.GEOM_MESH, _write_mesh(path, shape.vertices, shape.faces)
                flag = bullet.GEOM_FORCE_CONCAVE_TRIMESH
            case Ellipsoid():
                raise Unsupported(*NO_ELLIPSOID)
            case _:
                assert_never(shape)
        self.types.append(kind)
        self.radii.append(radius)
        self.halves.append(half)
        self.lengths.append(length)
        self.files.append(file)
        self.normals.append(normal)
        self.flags.append(flag)
        self.positions.append(p_LS)
        self.turns.append(xyzw(q_LS))


def single_shape(port: Port, shape: Shape, p_LS: Vector3, q_LS: Quaternion) -> int:
    """A collision shape of one part, in double precision; the number of the shape."""
    bullet = port.bullet
    pose: dict[str, Any] = {"collisionFramePosition": p_LS, "collisionFrameOrientation": xyzw(q_LS)}
    made: int
    match shape:
        case Sphere():
            made = port.call("createCollisionShape", bullet.GEOM_SPHERE, radius=shape.radius, **pose)
        case Box():
            made = port.call("createCollisionShape", bullet.GEOM_BOX, halfExtents=shape.half_extents, **pose)
        case Capsule():
            length = 2 * shape.half_length
            made = port.call("createCollisionShape", bullet.GEOM_CAPSULE, radius=shape.radius, height=length, **pose)
        case Cylinder():
            length = 2 * shape.half_length
            made = port.call("createCollisionShape", bullet.GEOM_CYLINDER, radius=shape.radius, height=length, **pose)
        case Plane():
            made = port.call("createCollisionShape", bullet.GEOM_PLANE, planeNormal=shape.normal, **pose)
        case ConvexHull() | TriangleMesh():
            # The pose goes into the vertices, in double precision.
            vertices = [plus(p_LS, rotate(q_LS, v)) for v in shape.vertices]
            if isinstance(shape, ConvexHull):
                made = port.call("createCollisionShape", bullet.GEOM_MESH, vertices=vertices)
            else:
                indices = [k for face in shape.faces for k in face]
                flags = bullet.GEOM_FORCE_CONCAVE_TRIMESH
                made = port.call("createCollisionShape", bullet.GEOM_MESH, vertices=vertices, indices=indices, flags=flags)
        case Ellipsoid():
            raise Unsupported(*NO_ELLIPSOID)
        case _:
            assert_never(shape)
    return made


def visual_shape(port: Port, shape: Shape, colour: Vector3) -> int:
    """What TinyRenderer draws of a shape, in a linear colour; the number of the visual shape."""
    bullet, paint = port.bullet, (*colour, 1.0)
    made: int
    match shape:
        case Sphere():
            made = port.call("createVisualShape", bullet.GEOM_SPHERE, radius=shape.radius, rgbaColor=paint)
        case Box():
            made = port.call("createVisualShape", bullet.GEOM_BOX, halfExtents=shape.half_extents, rgbaColor=paint)
        case Capsule():
            made = port.call(
                "createVisualShape", bullet.GEOM_CAPSULE, radius=shape.radius, length=2 * shape.half_length, rgbaColor=paint
            )
        case Cylinder():
            made = port.call(
                "createVisualShape", bullet.GEOM_CYLINDER, radius=shape.radius, length=2 * shape.half_length, rgbaColor=paint
            )
        case Plane():
            # TinyRenderer has no picture of a plane: a square of PLANE_WIDTH stands for it.
            normal = np.asarray(shape.normal)
            side = np.cross(normal, np.eye(3)[int(np.abs(normal).argmin())])
            across, along = (
                PLANE_WIDTH / 2 * side / np.linalg.norm(side),
                PLANE_WIDTH / 2 * np.cross(normal, side / np.linalg.norm(side)),
            )
            corners = [across + along, along - across, -across - along, across - along]
            made = _visual_mesh(port, [tuple(corner.tolist()) for corner in corners], [(0, 1, 2), (0, 2, 3)], paint)
        case ConvexHull():
            made = _visual_mesh(port, shape.vertices, _hull_faces(shape), paint)
        case Ellipsoid():
            hull = ConvexHull(vertices=polyhedron_of(shape))
            made = _visual_mesh(port, hull.vertices, _hull_faces(hull), paint)
        case TriangleMesh():
            made = _visual_mesh(port, shape.vertices, shape.faces, paint)
        case _:
            assert_never(shape)
    return made


def _visual_mesh(port: Port, vertices: Sequence[Vector3], faces: Sequence[Sequence[int]], paint: Sequence[float]) -> int:
    """A mesh for TinyRenderer with a normal per face, so that edges stay sharp."""
    points = np.asarray(vertices)[np.asarray(faces)]
    normals = np.cross(points[:, 1] - points[:, 0], points[:, 2] - points[:, 0])
    normals = np.repeat(normals / np.linalg.norm(normals, axis=1, keepdims=True), 3, axis=0)
    corners = points.reshape(-1, 3)
    made: int = port.call(
        "createVisualShape",
        port.bullet.GEOM_MESH,
        vertices=corners.tolist(),
        indices=list(range(len(corners))),
        normals=normals.tolist(),
        uvs=[[0.0, 0.0]] * len(corners),
        rgbaColor=paint,
    )
    return made


def unseen_shape(port: Port) -> int:
    """A visual shape without an extent: a body without any would be drawn by its collision shape."""
    corner = [[0.0, 0.0, 0.0]] * 3
    made: int = port.call(
        "createVisualShape", port.bullet.GEOM_MESH, vertices=corner, indices=[0, 1, 2], normals=[[0.0, 0.0, 1.0]] * 3,
        uvs=[[0.0, 0.0]] * 3,
    )  # fmt: skip
    return made


def check_shapes(body: Body) -> None:
    """Refuse what Bullet has no collision algorithm for. Raises: Unsupported."""
    for placed in body.collision:
        if isinstance(placed.shape, Ellipsoid):
            raise Unsupported(*NO_ELLIPSOID)
        vertices = getattr(placed.shape, "vertices", ())
        if len(vertices) > 131_072 or len(getattr(placed.shape, "faces", ())) * 3 > 524_288:
            raise Unsupported(
                f"mesh of body '{body.name}'", "pybullet takes 131072 vertices and 524288 indices of a mesh from memory"
            )


def check_pairs(scene: Scene) -> None:
    """Refuse two meshes of triangles that may meet. Raises: Unsupported."""
    meshes = [body for body in scene.bodies if any(isinstance(placed.shape, TriangleMesh) for placed in body.collision)]
    for one, other in itertools.combinations(meshes, 2):
        if (one.motion != "static" or other.motion != "static") and scene.collides(one, other):
            raise Unsupported(
                f"meshes of bodies '{one.name}' and '{other.name}'",
                "Bullet lets two meshes of triangles pass through each other",
            )


def collision_shape(port: Port, placed: Sequence[Placed]) -> int:
    """One collision shape out of shapes at their poses in the link frame L; -1 for none."""
    if not placed:
        return -1
    if len(placed) == 1:
        return single_shape(port, *placed[0])
    table = _ShapeTable()
    with tempfile.TemporaryDirectory(prefix="plumbline-") as folder:
        for shape, p_LS, q_LS in placed:
            table.add(port.bullet, shape, p_LS, q_LS, Path(folder))
        made: int = port.call(
            "createCollisionShapeArray",
            shapeTypes=table.types,
            radii=table.radii,
            halfExtents=table.halves,
            lengths=table.lengths,
            fileNames=table.files,
            meshScales=[[1.0, 1.0, 1.0]] * len(table.types),
            planeNormals=table.normals,
            flags=table.flags,
            collisionFramePositions=table.positions,
            collisionFrameOrientations=table.turns,
        )
    if made < 0:
        raise Unsupported("compound", "pybullet could not make one shape of these parts")
    return made


def padded(body: Body) -> bool:
    """Has the body shapes that Bullet makes thicker by its margin?"""
    return any(isinstance(placed.shape, ConvexHull | TriangleMesh) for placed in body.collision)


def inner_radius(body: Body) -> float:
    """The radius [m] of a ball that fits into each of the body's shapes."""
    radii: list[float] = []
    for placed in body.collision:
        match placed.shape:
            case Sphere() | Capsule():
                radii.append(placed.shape.radius)
            case Cylinder():
                radii.append(min(placed.shape.radius, placed.shape.half_length))
            case Box():
                radii.append(min(placed.shape.half_extents))
            case Ellipsoid():
                radii.append(min(placed.shape.semi_axes))
            case ConvexHull():
                radii.append(0.25 * float(np.ptp(np.asarray(placed.shape.vertices), axis=0).min()))
            case Plane() | TriangleMesh():
                continue
            case _:
                assert_never(placed.shape)
    return min(radii, default=0.0)
