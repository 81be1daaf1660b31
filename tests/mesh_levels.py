"""How far the collision shapes of a mesh at a level of detail reach out of it, and it out of them.

Source: Ericson, Real-Time Collision Detection, section 5.1.5 (closest point of a triangle).
"""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from plumbline.engine.build.level_of_detail import CONCAVITY, simplified
from plumbline.engine.build.polyhedra import closed_volume
from plumbline.engine.describe.shapes import Placed, Sphere, TriangleMesh
from plumbline.engine.maths.arrays import dot, mat_vec, norm, unit
from plumbline.engine.options import LEVELS

__all__ = ["Detail", "collision_shapes", "distances_from"]

FloatArray = NDArray[np.float64]

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
    shapes, pieces = simplified(mesh, level, concavity, seed)
    if isinstance(ball := shapes[0].shape, Sphere):
        centre = np.asarray(shapes[0].p_BS)
        way = rng.normal(size=(samples, 3))
        skin = centre + ball.radius * unit(way)
        out = float(norm(on_mesh - centre).max()) - ball.radius
        ratio = 4 / 3 * math.pi * (ball.radius * ball.radius * ball.radius) / volume
        return Detail(shapes, ratio, float(distances_from(skin, triangles).max()), max(0.0, out))
    total, excess, lack = _errors(pieces, triangles, on_mesh, samples, rng)
    return Detail(shapes, total / volume, excess, lack)


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
    excess = distances_from(surface[outside(surface + step * normals[facet])], triangles)
    lack = distances_from(on_mesh[outside(on_mesh)], skin)
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


def distances_from(points: FloatArray, triangles: FloatArray) -> FloatArray:
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
