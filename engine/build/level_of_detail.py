"""Collision shapes of a triangle mesh in levels of detail, each with its measured error.

From coarse to fine: the bounding sphere, the bounding box along the principal axes, the convex hull, a decomposition into
convex pieces, and the mesh itself.

Source: Ericson, Real-Time Collision Detection, sections 4.3.2 (sphere, Ritter), 4.4.2 (box by principal components) and 5.1.5
(closest point of a triangle); Wei, Liu, Ling, Su, Approximate Convex Decomposition for 3D Meshes with Collision-Aware Concavity
and Tree Search, ACM Transactions on Graphics 41, 2022 (through CoACD).
"""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from engine.build.closed_mesh import closed_volume
from engine.build.solids import mat_quat, quat_mat, quat_mul
from engine.describe.bodies import Body
from engine.describe.errors import NotSupported
from engine.describe.shapes import Box, ConvexHull, Placed, Sphere, TriangleMesh
from engine.maths.arrays import dot, eigen, mat_vec, norm, unit
from engine.options import LEVELS

FloatArray = NDArray[np.float64]

CONCAVITY = 0.05
"""CoACD's threshold [1] unless set."""
STEP = 1e-4
"""Share of the size [1] that a point steps off its face: if into another piece, the face is none of the outer surface."""
BLOCK = 1_000_000
"""Pairs of points and triangles taken at once: some 100 MB."""


@dataclass(frozen=True, slots=True)
class Detail:
    """A mesh at one level.

    Terms:
        shapes: in the frame of the mesh. volume_ratio [1]: the sum of their volumes over that of the mesh, so that overlaps of
        pieces count twice. excess [m]: greatest distance from the mesh of points on the outer surface of the shapes. lack
        [m]: greatest distance from the shapes of points on the mesh outside of them. Both are estimates from below.
    """

    shapes: tuple[Placed, ...]
    volume_ratio: float
    excess: float
    lack: float


def collision_shapes(
    mesh: TriangleMesh, level: str, concavity: float = CONCAVITY, samples: int = 2000, seed: int = 0
) -> Detail:
    """The shapes of a closed mesh at a level, and their error.

    Args: level: one of LEVELS. concavity [1]: CoACD's threshold, 0.01 to 1, smaller for more pieces. samples, seed: number of
        points of each estimate, and what draws them.
    Raises: ValueError for an unknown level, a mesh that is open or inside out; NotSupported where CoACD is not installed.
    """
    if level not in LEVELS:
        raise ValueError(f"level of detail '{level}', expected one of {', '.join(LEVELS)}")
    vertices, faces = np.asarray(mesh.vertices, float), np.asarray(mesh.faces)
    volume = closed_volume(vertices, faces)
    if level == "mesh":
        return Detail((Placed(mesh),), 1.0, 0.0, 0.0)
    rng = np.random.default_rng(seed)
    triangles = vertices[faces]
    on_mesh = np.concatenate([_scatter(triangles, samples, rng)[0], vertices])
    shapes, pieces = _simplified(mesh, level, concavity, seed)
    if isinstance(ball := shapes[0].shape, Sphere):
        centre = np.asarray(shapes[0].p_BS)
        way = rng.normal(size=(samples, 3))
        skin = centre + ball.radius * unit(way)
        out = float(norm(on_mesh - centre).max()) - ball.radius
        ratio = 4 / 3 * math.pi * (ball.radius * ball.radius * ball.radius) / volume
        return Detail(shapes, ratio, float(_distances(skin, triangles).max()), max(0.0, out))
    total, excess, lack = _errors(pieces, triangles, on_mesh, samples, rng)
    return Detail(shapes, total / volume, excess, lack)


def _simplified(mesh: TriangleMesh, level: str, concavity: float, seed: int) -> tuple[tuple[Placed, ...], list[FloatArray]]:
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
        replace(body, shapes=tuple(_simpler(body, level)), visual=body.shapes if body.visual is None else body.visual)
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
        try:
            closed_volume(np.asarray(placed.shape.vertices, float), np.asarray(placed.shape.faces))
        except ValueError as error:
            raise NotSupported(f"level of detail '{level}' of body '{body.name}'", str(error)) from error
        p_BS, q_BS = np.asarray(placed.p_BS, float), np.asarray(placed.q_BS, float)
        q_BS = unit(q_BS)
        for part in _simplified(placed.shape, level, CONCAVITY, seed=0)[0]:
            yield Placed(
                part.shape,
                (p_BS + mat_vec(quat_mat(q_BS), np.asarray(part.p_BS, float))).tolist(),
                quat_mul(q_BS, np.asarray(part.q_BS, float)).tolist(),
            )


def bounding_sphere(points: FloatArray) -> tuple[FloatArray, float]:
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


def bounding_box(points: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
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


def convex_pieces(mesh: TriangleMesh, concavity: float = CONCAVITY, seed: int = 0) -> list[FloatArray]:
    """The vertices (n, 3) of convex pieces that make up a mesh. Raises: NotSupported where CoACD is not installed."""
    try:
        import coacd
    except ImportError as error:
        raise NotSupported("convex decomposition", "it needs CoACD: pip install plumbline[decomposition]") from error
    coacd.set_log_level("error")
    whole = coacd.Mesh(np.asarray(mesh.vertices, float), np.asarray(mesh.faces, np.int32))
    return [np.asarray(points, float) for points, _ in coacd.run_coacd(whole, threshold=concavity, seed=seed)]


def _errors(
    pieces: list[FloatArray], triangles: FloatArray, on_mesh: FloatArray, samples: int, rng: np.random.Generator
) -> tuple[float, float, float]:
    """Volume [m3] of convex pieces, and how far they and the mesh reach out of each other [m]."""
    from scipy.spatial import ConvexHull as Quickhull

    hulls = [Quickhull(points) for points in pieces]
    skin = np.concatenate([points[hull.simplices] for points, hull in zip(pieces, hulls, strict=True)])
    normals = np.concatenate([hull.equations[:, :3] for hull in hulls])
    step = STEP * float(np.ptp(triangles.reshape(-1, 3), axis=0).max())

    def outside(points: FloatArray) -> NDArray[np.bool_]:
        return np.asarray(
            np.all([(mat_vec(h.equations[:, :3], points) + h.equations[:, 3]).max(axis=1) > 0.0 for h in hulls], axis=0)
        )

    surface, facet = _scatter(skin, samples, rng)
    excess = _distances(surface[outside(surface + step * normals[facet])], triangles)
    lack = _distances(on_mesh[outside(on_mesh)], skin)
    return sum(float(h.volume) for h in hulls), float(excess.max(initial=0.0)), float(lack.max(initial=0.0))


def _scatter(triangles: FloatArray, count: int, rng: np.random.Generator) -> tuple[FloatArray, NDArray[np.int64]]:
    """Points (count, 3) spread evenly over triangles (n, 3, 3), and the triangle of each."""
    a, b, c = triangles[:, 0], triangles[:, 1], triangles[:, 2]
    area = norm(np.cross(b - a, c - a))
    k = rng.choice(len(triangles), count, p=area / area.sum())
    u, v = rng.uniform(size=(2, count, 1))
    flip = u + v > 1
    u, v = np.where(flip, 1 - u, u), np.where(flip, 1 - v, v)
    return np.asarray(a[k] + u * (b - a)[k] + v * (c - a)[k]), np.asarray(k)


def _distances(points: FloatArray, triangles: FloatArray) -> FloatArray:
    """The distance [m] of each point (n, 3) from the nearest of the triangles (m, 3, 3)."""
    found = np.empty(len(points))
    step = max(1, BLOCK // len(triangles))
    for first in range(0, len(points), step):
        found[first : first + step] = _squares(points[first : first + step, None], triangles).min(axis=1)
    return np.sqrt(found)


def _squares(x: FloatArray, triangles: FloatArray) -> FloatArray:
    """Squared distances (n, m) [m2] of points (n, 1, 3) from triangles (m, 3, 3): the height over the face, else an edge's."""
    normal = unit(np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0]))
    nearest: FloatArray | float = np.inf
    above: NDArray[np.bool_] | bool = True
    for k in range(3):
        a, e = triangles[:, k], triangles[:, (k + 1) % 3] - triangles[:, k]
        away = x - a
        share = np.clip(dot(away, e) / dot(e, e), 0.0, 1.0)
        rest = away - share[:, :, None] * e
        nearest = np.minimum(nearest, dot(rest, rest))
        above = above & (dot(away, np.cross(normal, e)) >= 0)
    height = dot(x - triangles[:, 0], normal)
    return np.asarray(np.where(above, height * height, nearest))
