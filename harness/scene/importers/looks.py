"""How a robot looks: what its file draws of each link, meshes coarsened to what a picture shows, on the bodies of the scene.

A coarse mesh has its vertices moved to the middle of those in the same cell of a grid, and the triangles that are left.
Source: Rossignac, Borrel, Multi-resolution 3D approximations for rendering complex scenes (1993): vertex clustering.
"""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from plumbline.harness.intake.error import RobotError, listed
from plumbline.harness.scene import Appearance, Body, PlacedShape, Shape, TriangleMesh
from plumbline.harness.scene.importers.fidelity import Fidelity
from plumbline.harness.scene.importers.meshes import Mesh, load_mesh
from plumbline.harness.scene.importers.poses import Array, Pose, pose, quaternion, vector
from plumbline.harness.scene.importers.robot import Link, Look

FACES = 1500
"""Triangles of one mesh that a picture shows."""
FINEST = 64
"""Cells along the longest side of a mesh, before they are made larger."""
FLAT = 1e-9
"""Of the square of a mesh's size: a triangle of less area is none."""


@dataclass(frozen=True, slots=True)
class Drawn:
    """What is drawn, by body, and what is to be said of it."""

    shapes: Mapping[str, tuple[PlacedShape, ...]]
    rows: tuple[Fidelity, ...]


def looks_of(links: Iterable[Link], on: Mapping[str, str], at: Mapping[str, Pose], bodies: Iterable[Body]) -> Drawn:
    """What is drawn, by body; a mesh that cannot be read is not, and said so.

    Args: on: the body of each link. at: pose in W of each link.
    """
    own = {body.name: pose(body.p_WB, body.q_WB) for body in bodies}
    shapes: dict[str, list[PlacedShape]] = {}
    meshes: list[str] = []
    lost: list[str] = []
    count, off = 0, 0.0
    for link in links:
        body = on.get(link.name, "")
        for look in link.looks if body in own else ():
            try:
                shape, moved = _shape(look)
            except RobotError:
                lost.append(link.name)
                continue
            X_BG = own[body].inverse() @ at[link.name] @ look.X_LG
            shapes.setdefault(body, []).append(PlacedShape(shape=shape, p_BS=vector(X_BG.p), q_BS=quaternion(X_BG.R)))
            count, off = count + 1, max(off, moved)
            if look.shape is None:
                meshes.append(link.name)
    return Drawn({body: tuple(placed) for body, placed in shapes.items()}, tuple(_rows(count, meshes, lost, off)))


def _rows(count: int, meshes: list[str], lost: list[str], off: float) -> Iterable[Fidelity]:
    becomes, consequence = f"meshes of at most {FACES} triangles, in pictures", "vertices are moved by up to"
    if meshes:
        yield from Fidelity.approximated(
            "visual", listed(meshes), becomes, consequence=consequence, value=off, unit="m", count=count
        )
    else:
        yield from Fidelity.exact("visual", "primitives", "shapes in pictures", count=count)
    yield from Fidelity.left_out("visual", lost, "the mesh is not there or cannot be read; nothing but pictures depends on it")


def drawn_bodies(bodies: tuple[Body, ...], looks: Mapping[str, tuple[PlacedShape, ...]]) -> tuple[Body, ...]:
    """The bodies with what is drawn of them, for cameras to see."""
    return tuple(replace(body, visual=looks[body.name]) if body.name in looks else body for body in bodies)


def coloured(bodies: tuple[Body, ...], links: Iterable[Link], on: Mapping[str, str]) -> tuple[Body, ...]:
    """The bodies in the colours that the file states: of each the first. What is stated is for screens (sRGB), a scene's is
    linear."""
    colours: dict[str, tuple[float, float, float]] = {}
    for link in links:
        stated = next((look.colour for look in link.looks if look.colour is not None), None)
        if stated is not None:
            red, green, blue = (min(max(c, 0.0), 1.0) ** 2.2 for c in stated)
            colours.setdefault(on.get(link.name, ""), (red, green, blue))
    return tuple(
        replace(body, appearance=Appearance(colour=colours[body.name])) if body.name in colours else body for body in bodies
    )


def _shape(look: Look) -> tuple[Shape, float]:
    """The shape of a look, and by how much its vertices were moved [m]. Raises: RobotError."""
    if look.shape is not None:
        return look.shape, 0.0
    if look.vertices is not None and look.faces is not None:
        mesh = Mesh(look.vertices, look.faces.astype(np.int64))
    elif look.file is not None:
        mesh = load_mesh(look.file, np.array(look.scale), look.where)
    else:
        raise RobotError(f"{look.where}: there is no such file")
    return coarse(mesh, look.where)


def coarse(mesh: Mesh, where: str) -> tuple[TriangleMesh, float]:
    """A mesh of at most FACES triangles, and by how much a vertex was moved at most [m]. Raises: RobotError."""
    cells = FINEST
    size = float(np.ptp(mesh.vertices, axis=0).max())
    vertices, faces, off = mesh.vertices, _proper(mesh.vertices, mesh.faces, size), 0.0
    while len(faces) > FACES and cells >= 2:
        key = np.floor((mesh.vertices - mesh.vertices.min(axis=0)) / (size / cells)).astype(np.int64)
        _, group, held = np.unique(key, axis=0, return_inverse=True, return_counts=True)
        group = group.reshape(-1)
        vertices = np.stack([np.bincount(group, mesh.vertices[:, k]) for k in range(3)], axis=1) / held[:, None]
        off = float(np.linalg.norm(mesh.vertices - vertices[group], axis=1).max())
        faces = _proper(vertices, group[mesh.faces], size)
        cells = int(cells / 1.25)
    if not len(faces):
        raise RobotError(f"{where}: no triangle of the mesh has an area, expected a mesh that can be drawn")
    used, renumbered = np.unique(faces, return_inverse=True)
    triangles = tuple((int(a), int(b), int(c)) for a, b, c in renumbered.reshape(-1, 3))
    return TriangleMesh(vertices=vertices[used].tolist(), faces=triangles), off


def _proper(vertices: Array, faces: npt.NDArray[np.int64], size: float) -> npt.NDArray[np.int64]:
    """The triangles that have an area, each once."""
    a, b, c = (vertices[faces[:, k]] for k in range(3))
    area = np.linalg.norm(np.cross(b - a, c - a), axis=1) / 2
    kept = faces[area > FLAT * size * size]
    _, first = np.unique(np.sort(kept, axis=1), axis=0, return_index=True)
    distinct: npt.NDArray[np.int64] = kept[np.sort(first)]
    return distinct
