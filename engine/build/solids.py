"""The solids that shapes become in the arena: each with its own frame, a few sizes, and corners and faces where it has any.

A hull's frame is moved to the middle of its bounds. A mesh becomes its triangles, each with its normal along z.
"""

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from plumbline.engine.build.polyhedra import Polyhedron, box_polyhedron, hull_polyhedron, inner_edges, triangle_polyhedron
from plumbline.engine.describe.bodies import Body
from plumbline.engine.describe.check import unit_quaternion
from plumbline.engine.describe.shapes import Box, Capsule, ConvexHull, Cylinder, Ellipsoid, Plane, Shape, Sphere, TriangleMesh
from plumbline.engine.maths.arrays import cross, det, dot, eigen, mat_mat, mat_vec, norm, unit
from plumbline.engine.maths.types import Floats
from plumbline.engine.memory import arena as at


def principal_frame(inertia: Floats) -> tuple[Floats, Floats]:
    """The principal moments and axes of an inertia, I_B = R_BP diag(moments) R_BP^T.

    Args: inertia (3, 3) kg m2, symmetric, in B.
    Returns: moments (3,) kg m2 in ascending order, and q_BP (w, x, y, z).
    Source: Goldstein, Poole, Safko, Classical Mechanics, 3rd ed., section 5.4.
    """
    if np.count_nonzero(inertia - np.diag(np.diag(inertia))) == 0:
        # The axes of a diagonal inertia are those of B: only their order may change, and nothing is rounded.
        order = np.argsort(np.diag(inertia), kind="stable")
        moments, axes = np.diag(inertia)[order], np.eye(3)[:, order]
    else:
        moments, axes = eigen(inertia)
    if det(axes) < 0:
        axes = axes * (1.0, 1.0, -1.0)
    return moments, mat_quat(axes)


@dataclass(frozen=True, slots=True)
class Solid:
    """One row of the arena's table of shapes.

    Terms: kind: its type there; size: three numbers [m]; radius [m] of the bounding sphere; offset [m] and turn (w, x, y, z) in
    B; part: which of the body's shapes it belongs to; inner: bits of a triangle's edges that do not stick out.
    """

    kind: int
    size: tuple[float, float, float]
    radius: float
    offset: Floats
    turn: Floats
    part: int
    polyhedron: Polyhedron | None = None
    inner: int = 0


def quat_mul(a: Floats, b: Floats) -> Floats:
    """Hamilton product: first b, then a."""
    w = a[0] * b[0] - dot(a[1:], b[1:])
    return np.concatenate(([w], a[0] * b[1:] + b[0] * a[1:] + cross(a[1:], b[1:])))


def quat_mat(q: Floats) -> Floats:
    """The rotation matrix (3, 3) of a unit quaternion."""
    x = np.array([[0, -q[3], q[2]], [q[3], 0, -q[1]], [-q[2], q[1], 0]])
    return np.asarray(np.eye(3) + 2 * q[0] * x + mat_mat(2 * x, x))


def from_z(n: Floats) -> Floats:
    """The shortest rotation that takes z to the unit vector n."""
    if n[2] < -1 + 1e-12:
        return np.array([0.0, 1.0, 0.0, 0.0])
    q = np.array([1 + n[2], -n[1], n[0], 0.0])
    return unit(q)


def _closed_form(shape: Shape) -> tuple[int, tuple[float, float, float], float]:
    """Type, three sizes and bounding radius [m] of a shape that a few numbers describe."""
    match shape:
        case Sphere(radius):
            return at.SPHERE, (radius, 0.0, 0.0), radius
        case Box((x, y, z)):
            return at.BOX, (x, y, z), float(norm(np.array([x, y, z], float)))
        case Capsule(radius, half_length):
            return at.CAPSULE, (radius, half_length, 0.0), radius + half_length
        case Cylinder(radius, half_length):
            return at.CYLINDER, (radius, half_length, 0.0), float(norm(np.array([radius, half_length])))
        case Ellipsoid((x, y, z)):
            return at.ELLIPSOID, (x, y, z), float(max(x, y, z))
        case Plane():
            return at.PLANE, (0.0, 0.0, 0.0), math.inf
    raise TypeError(f"{type(shape).__name__} is made of several numbers")


def mat_quat(m: Floats) -> Floats:
    """The unit quaternion (w, x, y, z) of a rotation matrix.

    Source: Shepperd, Quaternion from Rotation Matrix, J. Guidance and Control 1, 1978.
    """
    squares = np.array([np.trace(m), m[0, 0], m[1, 1], m[2, 2]])
    k = int(squares.argmax())
    if k == 0:
        q = np.array([1 + squares[0], m[2, 1] - m[1, 2], m[0, 2] - m[2, 0], m[1, 0] - m[0, 1]])
    else:
        i, j, last = k - 1, k % 3, (k + 1) % 3
        q = np.empty(4)
        q[0], q[1 + i] = m[last, j] - m[j, last], 1 + m[i, i] - m[j, j] - m[last, last]
        q[1 + j], q[1 + last] = m[i, j] + m[j, i], m[i, last] + m[last, i]
    return unit(q)


def _hull(vertices: Floats, offset: Floats, turn: Floats, part: int) -> Solid:
    """The convex hull of vertices, about the middle of its bounds."""
    middle = (vertices.max(axis=0) + vertices.min(axis=0)) / 2
    made = hull_polyhedron(vertices - middle)
    half = np.abs(made.vertices).max(axis=0)
    radius = float(norm(made.vertices).max())
    return Solid(at.HULL, (half[0], half[1], half[2]), radius, offset + mat_vec(quat_mat(turn), middle), turn, part, made)


def _triangle(corners: Floats, inner: int, offset: Floats, turn: Floats, part: int) -> Solid:
    """A triangle with its normal along z and its origin in its plane."""
    x = unit(corners[1] - corners[0])
    z = unit(cross(x, corners[2] - corners[0]))
    own = np.column_stack([x, cross(z, x), z])
    flat = mat_vec(own.T, corners - corners[0])
    flat[:, 2] = 0.0
    middle = (flat.max(axis=0) + flat.min(axis=0)) / 2
    half = (flat - middle).max(axis=0)
    radius = float(norm(flat - middle).max())
    place = offset + mat_vec(quat_mat(turn), corners[0] + mat_vec(own, middle))
    made = triangle_polyhedron(flat - middle)
    return Solid(at.TRIANGLE, (half[0], half[1], 0.0), radius, place, quat_mul(turn, mat_quat(own)), part, made, inner)


def body_solids(body: Body) -> Iterator[Solid]:
    """The solids of a body, in the order of its shapes. Raises: ValueError for a hull without a volume."""
    for part, placed in enumerate(body.shapes):
        shape, offset = placed.shape, np.asarray(placed.p_BS, float)
        turn = unit_quaternion("placed shape", "q_BS", placed.q_BS)
        if isinstance(shape, ConvexHull):
            try:
                yield _hull(np.asarray(shape.vertices, float), offset, turn, part)
            except ValueError as error:
                raise ValueError(f"body '{body.name}': {error}") from error
        elif isinstance(shape, TriangleMesh):
            vertices, faces = np.asarray(shape.vertices, float), np.asarray(shape.faces)
            for face, inner in zip(faces, inner_edges(vertices, faces), strict=True):
                yield _triangle(vertices[face], int(inner), offset, turn, part)
        else:
            kind, size, radius = _closed_form(shape)
            made = box_polyhedron(shape.half_extents) if isinstance(shape, Box) else None
            if isinstance(shape, Plane):
                turn = quat_mul(turn, from_z(unit(np.asarray(shape.normal, float))))
            yield Solid(kind, size, radius, offset, turn, part, made)
