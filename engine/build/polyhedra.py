"""Faces of boxes, convex hulls and triangles, found once when a world is built.

Source: Barber, Dobkin, Huhdanpaa, The Quickhull Algorithm for Convex Hulls, 1996 (through SciPy).
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from plumbline.engine.describe.errors import NotSupported
from plumbline.engine.describe.shapes import TriangleMesh
from plumbline.engine.maths.arrays import cross, dot, norm, unit
from plumbline.engine.maths.types import Floats, Ints


def closed_volume(vertices: Floats, faces: NDArray[Any]) -> float:
    """The volume [m3] within a mesh. Raises: ValueError where an edge lacks its neighbour, or faces look inwards."""
    edges = np.concatenate([faces[:, [k, (k + 1) % 3]] for k in range(3)])
    there, back = ({tuple(edge) for edge in way.tolist()} for way in (edges, edges[:, ::-1]))
    if there != back:
        raise ValueError(f"triangle mesh: edge {min(there ^ back)} has one face, expected a closed surface")
    a, b, c = (vertices[faces[:, k]] - vertices.mean(axis=0) for k in range(3))
    volume = float(np.sum(a * np.cross(b, c))) / 6
    if volume <= 0:
        raise ValueError(f"triangle mesh: volume {volume:g} m3, expected faces counter-clockwise seen from outside")
    return volume


def check_closed(mesh: TriangleMesh, what: str) -> None:
    """Raises: NotSupported for what a mesh without an inside is wanted for."""
    try:
        closed_volume(np.asarray(mesh.vertices, float), np.asarray(mesh.faces))
    except ValueError as error:
        raise NotSupported(what, str(error)) from error


FLAT = 1e-9
"""Share of the size within which facets lie in one plane [1]: quickhull's own facets of one face differ by rounding only."""


@dataclass(frozen=True, slots=True)
class Polyhedron:
    """A convex polyhedron about the origin of its frame.

    Terms: vertices (n, 3) m; normals (f, 3) outward; loops: the corners of each face, counter-clockwise seen from outside.
    """

    vertices: Floats
    normals: Floats
    loops: tuple[tuple[int, ...], ...]


def box_polyhedron(half_extents: Sequence[float]) -> Polyhedron:
    """The eight corners and six faces of a box."""
    signs = np.array([[1 if k >> axis & 1 else -1 for axis in range(3)] for k in range(8)], float)
    normals, loops = [], []
    for axis in range(3):
        one, two = 1 << (axis + 1) % 3, 1 << (axis + 2) % 3
        loops += [(0, two, one + two, one), tuple(k + (1 << axis) for k in (0, one, one + two, two))]
        normals += [-np.eye(3)[axis], np.eye(3)[axis]]
    return Polyhedron(signs * np.asarray(half_extents, float), np.array(normals), tuple(loops))


def hull_polyhedron(vertices: Any) -> Polyhedron:
    """The convex hull of points (n, 3), coplanar facets merged to one face. Raises: ValueError for points without a volume.

    Quickhull only says which points are the corners of a facet; their order, planes and areas are worked out here.
    """
    from scipy.spatial import ConvexHull, QhullError

    points = np.asarray(vertices, float)
    try:
        hull = ConvexHull(points)
    except (QhullError, ValueError) as error:
        raise ValueError("convex hull: the vertices span no volume") from error
    size = float(np.ptp(points, axis=0).max())
    facets, areas, planes = _canonical(points, hull.simplices, hull.equations, size)
    kept = np.unique(facets)
    corners = points[kept]
    at = np.searchsorted(kept, facets)
    left = np.ones(len(facets), bool)
    normals: list[Floats] = []
    loops: list[tuple[int, ...]] = []
    rings_of: dict[int, list[frozenset[int]]] = {}
    for first in np.argsort(-areas, kind="stable").tolist():
        if not left[first]:
            continue
        n, offset = planes[first, :3], planes[first, 3]
        on = np.abs(dot(corners, n) + offset) <= FLAT * size
        mine = left & on[at].all(axis=1)
        mine[first] = True
        left[mine] = False
        ring = np.unique(at[mine])
        members = frozenset(ring.tolist())
        if any(members <= ring_before for ring_before in rings_of.get(int(ring[0]), ())):
            continue
        for corner in members:
            rings_of.setdefault(corner, []).append(members)
        middle = corners[ring].mean(axis=0)
        u = corners[ring[0]] - middle
        v = np.cross(n, u)
        angle = _as_angle(dot(corners[ring] - middle, u), dot(corners[ring] - middle, v))
        loops.append(tuple(int(k) for k in ring[np.argsort(angle)]))
        normals.append(unit(n))
    return Polyhedron(corners, np.array(normals), tuple(loops))


def _canonical(points: Floats, facets: NDArray[Any], planes: Floats, size: float) -> tuple[NDArray[Any], Floats, Floats]:
    """Facets (f, 3) by their corners, twice their areas [m2], and their planes (f, 4): the outer normal and the offset.

    Args: planes: as Quickhull has them, which remain where a facet is too thin to have a normal.
    """
    rows = np.sort(facets, axis=1)
    order = np.lexsort(rows.T[::-1])
    rows, planes = rows[order], planes[order].copy()
    a, b, c = (points[rows[:, k]] for k in range(3))
    across = np.cross(b - a, c - a)
    areas = norm(across)
    plain = areas > FLAT * size * size
    n = unit(across[plain])
    n = np.where(dot(n, a[plain] - points.mean(axis=0))[:, np.newaxis] < 0.0, -n, n)
    planes[plain] = np.column_stack([n, -dot(n, a[plain])])
    return rows, areas, planes


def _as_angle(x: Floats, y: Floats) -> Floats:
    """What grows as the angle of the direction (x, y) does, from -2 to 2."""
    share = y / (np.abs(x) + np.abs(y))
    return np.asarray(np.where(x >= 0.0, share, np.copysign(2.0, y) - share))


def triangle_polyhedron(corners: Floats) -> Polyhedron:
    """A triangle (3, 3) as a solid without thickness; the first face is the outer one."""
    n = unit(cross(corners[1] - corners[0], corners[2] - corners[0]))
    return Polyhedron(corners, np.array([n, -n]), ((0, 1, 2), (0, 2, 1)))


def inner_edges(vertices: Floats, faces: NDArray[Any]) -> Ints:
    """For each triangle, bit k is set where no edge sticks out between its corners k and k + 1: there its neighbour lies in
    its plane or above it.

    Args: vertices (n, 3) m, faces (m, 3), counter-clockwise seen from outside. Corners at one place are the same corner.
    """
    _, same = np.unique(vertices, axis=0, return_inverse=True)
    ring = np.asarray(same).reshape(-1)[faces]
    size = float(np.ptp(vertices, axis=0).max())
    beyond = {(int(t[k]), int(t[(k + 1) % 3])): f for f, t in enumerate(ring) for k in range(3)}
    bits = np.zeros(len(faces), np.int64)
    for f, t in enumerate(ring):
        a, b, c = vertices[faces[f]]
        n = unit(cross(b - a, c - a))
        for k in range(3):
            other = beyond.get((int(t[(k + 1) % 3]), int(t[k])))
            if (
                other is not None
                and (dot(vertices[faces[other]] - a, n).max() >= 0.0)
                and (dot(vertices[faces[other]] - a, n).min() >= -1e-6 * size)
            ):
                bits[f] |= 1 << k
    return bits
