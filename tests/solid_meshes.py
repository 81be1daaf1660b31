"""Closed meshes of solids, convex or not, and bodies of one with the inertia of a uniform solid, for tests."""

import itertools
import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

import engine

__all__ = ["box", "mass_properties", "mesh_body", "ring", "together"]

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
