"""Collision shapes of a triangle mesh in levels of detail.

From coarse to fine: the bounding sphere, the bounding box along the principal axes, the convex hull, a decomposition into
convex pieces, and the mesh itself.

Source: Ericson, Real-Time Collision Detection, sections 4.3.2 (sphere, Ritter) and 4.4.2 (box by principal components);
Wei, Liu, Ling, Su, Approximate Convex Decomposition for 3D Meshes with Collision-Aware Concavity
and Tree Search, ACM Transactions on Graphics 41, 2022 (through CoACD).
"""

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np

from plumbline.engine.build.polyhedra import check_closed
from plumbline.engine.build.solids import mat_quat, quat_mat, quat_mul
from plumbline.engine.describe.bodies import Body
from plumbline.engine.describe.errors import NotSupported
from plumbline.engine.describe.shapes import Box, ConvexHull, Placed, Sphere, TriangleMesh
from plumbline.engine.maths.arrays import eigen, mat_vec, norm, unit
from plumbline.engine.maths.types import Floats

CONCAVITY = 0.05
"""CoACD's threshold [1] unless set."""


def simplified(
    mesh: TriangleMesh, level: str, concavity: float = CONCAVITY, seed: int = 0
) -> tuple[tuple[Placed, ...], list[Floats]]:
    """The shapes of a mesh at a level other than itself, and the corners (n, 3) of each but a sphere."""
    vertices = np.asarray(mesh.vertices, float)
    if level == "sphere":
        centre, radius = bounding_sphere(vertices)
        return (Placed(Sphere(radius), tuple(centre)),), []
    if level == "box":
        centre, half, axes = bounding_box(vertices)
        signs = np.array([[1 if k >> axis & 1 else -1 for axis in range(3)] for k in range(8)])
        return (Placed(Box(tuple(half)), tuple(centre), tuple(mat_quat(axes))),), [centre + mat_vec(axes, signs * half)]
    pieces = [vertices] if level == "hull" else convex_pieces(mesh, concavity, seed)
    return tuple(Placed(ConvexHull(points.tolist())) for points in pieces), pieces


def at_level(bodies: Sequence[Body], level: str) -> list[Body]:
    """The bodies with their triangle meshes at a level; what they look like stays.

    Raises: NotSupported for a mesh that is open or inside out, and where CoACD is not installed.
    """
    return [
        replace(body, shapes=tuple(_simpler(body, level)), visual=body.looks)
        if any(isinstance(part.shape, TriangleMesh) for part in body.shapes)
        else body
        for body in bodies
    ]


def _simpler(body: Body, level: str) -> Iterator[Placed]:
    """The shapes of a body, those of its meshes at a level, all in the frame of the body. Raises: as `at_level`."""
    for placed in body.shapes:
        if not isinstance(placed.shape, TriangleMesh) or level == "mesh":
            yield placed
            continue
        check_closed(placed.shape, f"level of detail '{level}' of body '{body.name}'")
        p_BS, q_BS = np.asarray(placed.p_BS, float), unit(np.asarray(placed.q_BS, float))
        for part in simplified(placed.shape, level)[0]:
            yield Placed(
                part.shape,
                (p_BS + mat_vec(quat_mat(q_BS), np.asarray(part.p_BS, float))).tolist(),
                quat_mul(q_BS, np.asarray(part.q_BS, float)).tolist(),
            )


def bounding_sphere(points: Floats) -> tuple[Floats, float]:
    """Centre and radius [m] of a ball that holds the points (n, 3): about two distant ones, grown over the others."""
    one = points[norm(points - points[0]).argmax()]
    two = points[norm(points - one).argmax()]
    centre, radius = (one + two) / 2, float(norm(two - one)) / 2
    for point in points:
        away = float(norm(point - centre))
        if away > radius:
            radius, past = (radius + away) / 2, (away - radius) / 2
            centre = centre + (point - centre) * (past / away)
    return centre, float(norm(points - centre).max())


def bounding_box(points: Floats) -> tuple[Floats, Floats, Floats]:
    """Centre (3,), half extents (3,) [m] and axes (columns) of the smaller of two boxes about points (n, 3): along their frame
    and along their principal components.
    """
    spread = points - points.mean(axis=0)
    _, principal = eigen(np.array([[float((u * v).sum()) for v in spread.T] for u in spread.T]) / len(points))
    principal[:, 2] = np.cross(principal[:, 0], principal[:, 1])
    found = []
    for axes in (np.eye(3), principal):
        along = mat_vec(axes.T, points)
        low, high = along.min(axis=0), along.max(axis=0)
        x, y, z = (high - low).tolist()
        found.append((x * y * z, mat_vec(axes, (low + high) / 2), (high - low) / 2, axes))
    _, centre, half, axes = min(found, key=lambda box: box[0])
    return centre, half, axes


def convex_pieces(mesh: TriangleMesh, concavity: float = CONCAVITY, seed: int = 0) -> list[Floats]:
    """The vertices (n, 3) of convex pieces that make up a mesh. Raises: NotSupported where CoACD is not installed."""
    try:
        import coacd
    except ImportError as error:
        raise NotSupported("convex decomposition", "it needs CoACD: pip install plumbline[decomposition]") from error
    coacd.set_log_level("error")
    whole = coacd.Mesh(np.asarray(mesh.vertices, float), np.asarray(mesh.faces, np.int32))
    return [np.asarray(points, float) for points, _ in coacd.run_coacd(whole, threshold=concavity, seed=seed)]
