"""Meshes of robot files: STL, OBJ and DAE through trimesh, scaled and mirrored, never more than what is allowed."""

import re
from collections.abc import Mapping
from dataclasses import dataclass
from io import BytesIO
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from plumbline.harness.intake.allowance import beyond
from plumbline.harness.intake.documents import named
from plumbline.harness.intake.error import RobotError
from plumbline.harness.intake.safe_text import readable
from plumbline.harness.scene import ConvexHull
from plumbline.harness.scene.importers.fidelity import Fidelity
from plumbline.harness.scene.importers.files import content
from plumbline.harness.scene.importers.poses import Array
from plumbline.harness.scene.importers.xml_text import elements

FORMATS = (".stl", ".obj", ".dae")
MOST_CORNERS = 500
"""Of a convex hull that touches: more of them cost every engine time, and lie within a hundredth of a round part's radius."""
_AT_ONCE = 8
"""Corners that a hull is given in one turn."""
_FACE = re.compile(rb"^f\s", re.MULTILINE)
_BINARY_STL = (84, 50)
"""Bytes before the triangles of a binary STL, and of each triangle."""


@dataclass(frozen=True, slots=True, eq=False)
class Mesh:
    """A mesh in its own frame. Terms: vertices (n, 3) m, faces (m, 3), counter-clockwise from outside also where mirrored."""

    vertices: Array
    faces: npt.NDArray[np.int64]

    @property
    def closed(self) -> bool:
        """Does every edge belong to two triangles that run along it in opposite ways?"""
        f = self.faces
        edges = np.concatenate([f[:, [0, 1]], f[:, [1, 2]], f[:, [2, 0]]])
        there, back = ({(int(a), int(b)) for a, b in edges[:, turn]} for turn in ([0, 1], [1, 0]))
        return len(there) == len(edges) and there == back


def too_many_faces(kind: str, raw: bytes) -> str:
    """What goes beyond the allowed number of faces, in words, before anything is made of them."""
    before, each = _BINARY_STL
    if kind == ".stl":
        count = (len(raw) - before) // each if not raw[:6].lower().startswith(b"solid") else raw.count(b"endfacet")
    elif kind == ".obj":
        count = len(_FACE.findall(raw))
    else:
        return ""
    return beyond("vertices", count, "faces")


_ZEROTH = re.compile(rb"^f[ \t](?:[^\n]*[ \t])?[+-]?0+(?=[/\s]|$)", re.MULTILINE)
"""A face of an OBJ with vertex 0, which some readers take for the last one: vertices count from 1, or back from -1."""


def load_mesh(path: Path, scale: Array, where: str) -> Mesh:
    """The mesh of a file, all its parts together, times a scale (3,) that may be negative.

    Raises: RobotError, where it is none of FORMATS, not readable, not finite, empty or too large.
    """
    kind = path.suffix.lower()
    if kind not in FORMATS:
        raise RobotError(f"{where}: {named(path)}: format {kind or 'without ending'}, expected one of {', '.join(FORMATS)}")
    raw = content(path, where, "meshes")
    if reason := too_many_faces(kind, raw):
        raise RobotError(f"{where}: {named(path)}: {reason}")
    if kind == ".obj" and (face := _ZEROTH.search(raw)):
        line = raw.count(b"\n", 0, face.start()) + 1
        raise RobotError(f"{where}: {named(path)}: line {line}: a face names vertex 0, expected numbers from 1 on")
    if kind == ".dae":
        elements(raw.decode("utf-8", "replace"), f"{where}: {named(path)}")

    import trimesh

    try:
        loaded: Any = trimesh.load(BytesIO(raw), file_type=kind[1:], force="mesh", process=False, skip_materials=True)
        vertices = np.array(loaded.vertices, dtype=np.float64)
        faces = np.array(loaded.faces, dtype=np.int64)
    except Exception as error:  # a broken file may break the reader anywhere
        reason = readable(f"{type(error).__name__}: {error}", 200)
        raise RobotError(f"{where}: {named(path)}: no mesh that can be read ({reason})") from None
    if vertices.ndim != 2 or not len(vertices) or not len(faces) or faces.min() < 0 or faces.max() >= len(vertices):
        raise RobotError(f"{where}: {named(path)}: no triangles between vertices, expected a mesh")
    if reason := beyond("vertices", max(len(vertices), len(faces))):
        raise RobotError(f"{where}: {named(path)}: {reason}")
    vertices = vertices * scale
    if not np.isfinite(vertices).all() or np.abs(vertices).max() > 1e6:
        raise RobotError(f"{where}: {named(path)}: vertices are not finite or beyond 1e6 m, expected a mesh of finite size")
    if np.prod(np.sign(scale)) < 0:
        faces = faces[:, ::-1]
    merged, index = np.unique(vertices, axis=0, return_inverse=True)
    faces = index.reshape(-1)[faces]
    proper = (faces[:, 0] != faces[:, 1]) & (faces[:, 1] != faces[:, 2]) & (faces[:, 2] != faces[:, 0])
    return Mesh(merged, faces[proper])


def hull_of(vertices: Array, where: str) -> tuple[ConvexHull, float]:
    """The convex hull of points (n, 3) m, and its volume [m3]. Raises: RobotError, where they span none."""
    from scipy.spatial import ConvexHull as Qhull
    from scipy.spatial import QhullError

    try:
        hull = Qhull(vertices)
        corners = vertices[np.sort(hull.vertices)]
        return ConvexHull(vertices=corners.tolist()), float(hull.volume)
    except (QhullError, ValueError) as error:
        message = readable(str(error).strip().splitlines()[0], 160)
        raise RobotError(f"{where}: the mesh spans no volume ({message}), expected a solid") from None


def simplified(hull: ConvexHull) -> tuple[ConvexHull, float]:
    """The hull of at most MOST_CORNERS of its corners, and how far the others lie outside of its faces [m].

    Those that lie the farthest outside are taken in first, as quickhull does.
    Source: Barber, Dobkin, Huhdanpaa, The Quickhull Algorithm for Convex Hulls, ACM Trans. Math. Software 22 (1996) 469.
    """
    from scipy.spatial import ConvexHull as Qhull

    corners = np.array(hull.vertices)
    if len(corners) <= MOST_CORNERS:
        return hull, 0.0
    ways = np.concatenate((np.eye(3), -np.eye(3), np.ones((1, 3)), -np.ones((1, 3))))
    chosen = np.unique(np.argmax(ways @ corners.T, axis=1))
    while True:
        outside = corners @ (faces := Qhull(corners[chosen]).equations)[:, :3].T + faces[:, 3]
        farthest, beyond_faces = np.argmax(outside, axis=0), np.max(outside, axis=0)
        order = np.argsort(-beyond_faces)[: min(_AT_ONCE, MOST_CORNERS - len(chosen))]
        fresh = np.setdiff1d(farthest[order], chosen)
        if len(fresh) == 0:
            return ConvexHull(vertices=corners[chosen].tolist()), max(0.0, float(beyond_faces.max()))
        chosen = np.sort(np.concatenate((chosen, fresh)))


def coarser(off: Mapping[str, float]) -> list[Fidelity]:
    """The row of hulls that are given fewer corners than they have. Args: off: by how much [m], by whose they are."""
    return Fidelity.told("corners of a hull", list(off), max(off.values(), default=None), most_corners=MOST_CORNERS)
