"""Volume, centre and inertia of shapes of unit density, for links whose file gives none."""

import math

import numpy as np

from plumbline.harness.scene import (
    Box,
    Capsule,
    ConvexHull,
    Cylinder,
    Ellipsoid,
    Shape,
    Sphere,
    TriangleMesh,
    box_inertia,
    capsule_inertia,
    cylinder_inertia,
    ellipsoid_inertia,
    sphere_inertia,
)
from plumbline.harness.scene.importers.meshes import Mesh
from plumbline.harness.scene.importers.poses import Array, Pose, cross
from plumbline.harness.scene.importers.robot import Solid


def about(solid_mass: float, inertia: Array, offset: Array) -> Array:
    """The inertia about a point that lies `offset` [m] from the centre of mass (parallel-axis theorem)."""
    K = cross(offset)
    total: Array = inertia - solid_mass * (K @ K)
    return total


def moved(solid: Solid, X: Pose) -> Solid:
    """The solid of a frame B as it is in A, X the pose of B in A: centre and axes turn with it."""
    return Solid(solid.mass, X.of(solid.centre), None if solid.inertia is None else X.R @ solid.inertia @ X.R.T)


def together(solids: list[Solid]) -> Solid:
    """Several solids with tensors, in one frame, as one; a tensor without a mass is added as it is."""
    if len(solids) == 1 and solids[0].mass > 0:
        return solids[0]
    mass = math.fsum(solid.mass for solid in solids)
    if mass <= 0:
        return Solid(0.0, np.zeros(3), np.zeros((3, 3)))
    centre = np.sum([solid.mass * solid.centre for solid in solids], axis=0) / mass
    inertia = np.zeros((3, 3))
    for solid in solids:
        assert solid.inertia is not None
        inertia = inertia + about(solid.mass, solid.inertia, solid.centre - centre)
    return Solid(mass, centre, inertia)


def of_mesh(mesh: Mesh) -> Solid:
    """A closed mesh filled with unit density.

    Source: Eberly, Polyhedral Mass Properties (Revisited): sums over the tetrahedra from the origin to each triangle.
    """
    a, b, c = (mesh.vertices[mesh.faces[:, k]] for k in range(3))
    six = np.einsum("ni,ni->n", a, np.cross(b, c))
    volume = float(six.sum()) / 6
    if volume <= 0:
        return Solid(0.0, np.zeros(3), np.zeros((3, 3)))
    centre = ((a + b + c) * six[:, None]).sum(axis=0) / 24 / volume
    corners = np.stack([a - centre, b - centre, c - centre], axis=1)
    six = np.einsum("ni,ni->n", corners[:, 0], np.cross(corners[:, 1], corners[:, 2]))
    total = corners.sum(axis=1)
    second = (np.einsum("n,nki,nkj->ij", six, corners, corners) + np.einsum("n,ni,nj->ij", six, total, total)) / 120
    # The tetrahedra from the centre do not close on the volume's sign alone: theirs sum up to the same volume.
    return Solid(volume, centre, np.trace(second) * np.eye(3) - second)


def of_shape(shape: Shape) -> Solid:
    """A shape of unit density in its own frame; nothing for a half space and an open mesh."""
    match shape:
        case Sphere(radius=r):
            mass = 4 / 3 * math.pi * r**3
            tensor = sphere_inertia(mass, r)
        case Box(half_extents=h):
            mass = 8 * h[0] * h[1] * h[2]
            tensor = box_inertia(mass, h)
        case Ellipsoid(semi_axes=s):
            mass = 4 / 3 * math.pi * s[0] * s[1] * s[2]
            tensor = ellipsoid_inertia(mass, s)
        case Cylinder(radius=r, half_length=h):
            mass = 2 * math.pi * r * r * h
            tensor = cylinder_inertia(mass, r, h)
        case Capsule(radius=r, half_length=h):
            mass = math.pi * r * r * (2 * h + 4 / 3 * r)
            tensor = capsule_inertia(mass, r, h)
        case ConvexHull(vertices=vertices):
            return of_mesh(_hull_mesh(np.asarray(vertices)))
        case TriangleMesh(vertices=vertices, faces=faces):
            return of_mesh(Mesh(np.asarray(vertices), np.asarray(faces)))
        case _:
            return Solid(0.0, np.zeros(3), np.zeros((3, 3)))
    return Solid(mass, np.zeros(3), np.array(tensor))


def _hull_mesh(vertices: Array) -> Mesh:
    """The surface of the convex hull, its triangles turned outwards."""
    from scipy.spatial import ConvexHull as Qhull

    hull = Qhull(vertices)
    faces = np.array(hull.simplices, dtype=np.int64)
    a, b, c = (vertices[faces[:, k]] for k in range(3))
    inwards = np.einsum("ni,ni->n", np.cross(b - a, c - a), hull.equations[:, :3]) < 0
    faces[inwards] = faces[inwards][:, ::-1]
    return Mesh(vertices, faces)
