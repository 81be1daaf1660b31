"""Closed meshes of solids, convex or not, and bodies of one with the inertia of a uniform solid, for tests."""

import itertools
import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from plumbline import engine
from plumbline.engine.build.polyhedra import closed_volume
from tests.mesh_levels import distances_from

__all__ = [
    "bolt", "bowl", "box", "circle", "deepest", "hexagon", "lofted", "mass_properties", "mesh_body", "nut", "ring", "sag",
    "scattered", "together", "volume",
]  # fmt: skip

SIDES = (
    (0, 1, 3), (0, 3, 2), (4, 6, 7), (4, 7, 5), (0, 4, 5), (0, 5, 1), (2, 3, 7), (2, 7, 6), (0, 2, 6), (0, 6, 4), (1, 5, 7),
    (1, 7, 3),
)  # fmt: skip


def box(half_extents: Sequence[float], centre: Sequence[float] = (0.0, 0.0, 0.0)) -> engine.TriangleMesh:
    """A box of twelve triangles [m]."""
    corners = np.array(list(itertools.product((-1.0, 1.0), repeat=3))) * half_extents + np.asarray(centre)
    return engine.TriangleMesh(corners.tolist(), SIDES)


def ring(radius: float, thick: float, around: int = 20, across: int = 10) -> engine.TriangleMesh:
    """A torus about z [m]: `radius` to the middle of its tube, `thick` of the tube."""
    u, v = np.meshgrid(np.arange(around) * 2 * np.pi / around, np.arange(across) * 2 * np.pi / across, indexing="ij")
    out = radius + thick * np.cos(v)
    points = np.stack([out * np.cos(u), out * np.sin(u), thick * np.sin(v)], axis=-1).reshape(-1, 3)
    i, j = (k.ravel() for k in np.meshgrid(np.arange(around), np.arange(across), indexing="ij"))
    a, b = across * i + j, across * ((i + 1) % around) + j
    c, d = across * ((i + 1) % around) + (j + 1) % across, across * i + (j + 1) % across
    return engine.TriangleMesh(points.tolist(), np.concatenate([np.stack([a, b, c], 1), np.stack([a, c, d], 1)]).tolist())


def together(*meshes: engine.TriangleMesh) -> engine.TriangleMesh:
    """Several meshes as one, of as many parts."""
    first = np.cumsum([0, *(len(one.vertices) for one in meshes)])
    faces = [np.asarray(one.faces) + at for one, at in zip(meshes, first, strict=False)]
    return engine.TriangleMesh(np.concatenate([one.vertices for one in meshes]).tolist(), np.concatenate(faces).tolist())


def volume(mesh: engine.TriangleMesh) -> float:
    """What a closed mesh encloses [m3]."""
    return closed_volume(np.asarray(mesh.vertices, float), np.asarray(mesh.faces))


def mass_properties(mesh: engine.TriangleMesh, mass: float) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Centre of mass [m] and inertia [kg m2] about it of a uniform solid of this mass: sums over tetrahedra from the origin."""
    t = np.asarray(mesh.vertices, float)[np.asarray(mesh.faces)]
    six = np.einsum("ni,ni->n", t[:, 0], np.cross(t[:, 1], t[:, 2]))
    centre = np.einsum("n,nki->i", six, t) / (4 * six.sum())
    t = t - centre
    six = np.einsum("ni,ni->n", t[:, 0], np.cross(t[:, 1], t[:, 2]))
    total = t.sum(axis=1)
    second = np.einsum("n,nki,nkj->ij", six, t, t) + np.einsum("n,ni,nj->ij", six, total, total)
    second *= mass / (20 * six.sum())
    return centre, np.trace(second) * np.eye(3) - second


def mesh_body(name: str, mesh: engine.TriangleMesh, mass: float = 1.0, **state: object) -> engine.Body:
    """A body of one mesh of uniform density, whose frame is that of the mesh moved to its centre of mass."""
    centre, inertia = mass_properties(mesh, mass)
    shapes = [engine.Placed(mesh, (-centre).tolist())]
    return engine.Body(name=name, mass=mass, inertia=inertia, shapes=shapes, **state)  # type: ignore[arg-type]


def sag(dt: float, substeps: int = 4, gravity: float = 9.81) -> float:
    """How far [m] one contact spring of a quarter of the sub-step's rate gives under its own body: g / (2 pi hertz)^2."""
    hertz = 0.25 * substeps / dt
    return gravity / (2 * math.pi * hertz) ** 2


def hexagon(flats: float, points: int) -> NDArray[np.float64]:
    """Points (n, 2) m at even angles on a regular hexagon, `flats` [m] wide; a multiple of six has its corners among them."""
    angle = 2 * np.pi * np.arange(points) / points
    far = flats / 2 / np.cos((angle % (np.pi / 3)) - np.pi / 6)
    return np.asarray(far[:, None] * circle(1.0, points))


def circle(radius: float, points: int) -> NDArray[np.float64]:
    """Points (n, 2) m at even angles on a circle."""
    angle = 2 * np.pi * np.arange(points) / points
    return np.asarray(radius * np.stack([np.cos(angle), np.sin(angle)], axis=1))


def lofted(outlines: Sequence[NDArray[np.float64]], heights: Sequence[float], closed: bool = False) -> engine.TriangleMesh:
    """The skin through outlines of equally many points about z, from one to the next counter-clockwise seen from above.

    Args: heights [m]: of each outline. closed: whether the last goes on to the first, around a hole; else the first and the
    last are capped, and the first is the lowest.
    """
    n, rings = len(outlines[0]), len(outlines)
    points = np.concatenate([np.column_stack([ring, np.full(n, z)]) for ring, z in zip(outlines, heights, strict=True)])
    faces: list[tuple[int, int, int]] = []
    for k in range(rings if closed else rings - 1):
        low, high = n * k, n * ((k + 1) % rings)
        for i in range(n):
            j = (i + 1) % n
            faces += [(low + i, low + j, high + j), (low + i, high + j, high + i)]
    if not closed:
        last = n * (rings - 1)
        points = np.concatenate([points, [[0, 0, heights[0]], [0, 0, heights[-1]]]])
        faces += [(n * rings, (i + 1) % n, i) for i in range(n)]
        faces += [(n * rings + 1, last + i, last + (i + 1) % n) for i in range(n)]
    return engine.TriangleMesh(points.tolist(), faces)


def nut(flats: float = 0.016, bore: float = 0.0105, height: float = 0.008, points: int = 12) -> engine.TriangleMesh:
    """A hexagonal nut about z, its hole a polygon, without a thread [m]."""
    outer, inner, half = hexagon(flats, points), circle(bore / 2, points), height / 2
    return lofted([inner, outer, outer, inner], [-half, -half, half, half], closed=True)


def bolt(
    flats: float = 0.016, head: float = 0.0064, shank: float = 0.01, length: float = 0.03, points: int = 12
) -> engine.TriangleMesh:
    """A bolt about z, its hexagonal head below, its shank a polygon without a thread [m]."""
    round_ = circle(shank / 2, points)
    return lofted([hexagon(flats, points), hexagon(flats, points), round_, round_], [0.0, head, head, head + length])


def bowl(radius: float, wall: float, opening: float, around: int = 24, rings: int = 6) -> engine.TriangleMesh:
    """A part of a hollow ball about the origin, its inner side of this radius, down to the angle `opening` [rad] from -z."""
    angles = opening * np.arange(1, rings + 1) / rings
    inner, outer = radius, radius + wall
    rounds = [circle(r * np.sin(a), around) for r, a in [*((outer, a) for a in angles), *((inner, a) for a in angles[::-1])]]
    heights = [-r * np.cos(a) for r, a in [*((outer, a) for a in angles), *((inner, a) for a in angles[::-1])]]
    mesh = lofted(rounds, heights)
    vertices = np.asarray(mesh.vertices, float)
    vertices[-2:, 2] = -outer, -inner
    return engine.TriangleMesh(vertices.tolist(), mesh.faces)


def deepest(points: NDArray[np.float64], mesh: engine.TriangleMesh) -> float:
    """How deep [m] the deepest of points (n, 3) lies within a closed mesh; 0 where all are outside.

    A point is within where the triangles cover more than half of all directions that are seen from it (Van Oosterom, Strackee,
    The Solid Angle of a Plane Triangle, 1983); its depth is the distance from the nearest triangle.
    """
    t = np.asarray(mesh.vertices, float)[np.asarray(mesh.faces)]
    near = ((points > t.min(axis=(0, 1))) & (points < t.max(axis=(0, 1)))).all(axis=1)
    points = points[near]
    a, b, c = (t[:, k] - points[:, None] for k in range(3))
    la, lb, lc = (np.linalg.norm(x, axis=-1) for x in (a, b, c))
    volume = np.einsum("nmi,nmi->nm", a, np.cross(b, c))
    dots = (np.einsum("nmi,nmi->nm", *two) * one for *two, one in ((a, b, lc), (b, c, la), (c, a, lb)))
    angle = 2 * np.arctan2(volume, la * lb * lc + sum(dots)).sum(axis=1)
    within = points[angle > 2 * np.pi]
    return float(distances_from(within, t).max(initial=0.0)) if len(within) else 0.0


def scattered(mesh: engine.TriangleMesh, steps: int) -> NDArray[np.float64]:
    """Points on every triangle of a mesh, (n, 3) m: its corners, `steps` parts of each edge, and those of a grid within."""
    t = np.asarray(mesh.vertices, float)[np.asarray(mesh.faces)]
    share = np.array([(i, j, steps - i - j) for i in range(steps + 1) for j in range(steps + 1 - i)]) / steps
    return np.asarray(np.unique(np.einsum("sk,mkc->msc", share, t).reshape(-1, 3), axis=0))
