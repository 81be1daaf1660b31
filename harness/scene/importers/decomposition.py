"""Shapes that few engines collide as convex ones: meshes in pieces by CoACD, which is asked once a mesh, ellipsoids as hulls.

Source: Wei, Liu, Ling, Su, Approximate convex decomposition for 3D meshes with collision-aware concavity and tree search,
ACM Transactions on Graphics 41(4), 2022.
"""

import hashlib
import io
import json
from collections.abc import Callable, Sequence
from dataclasses import replace
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np

from plumbline.harness.intake.error import RobotError
from plumbline.harness.intake.safe_text import readable
from plumbline.harness.intake.user_cache import cache_folder, keep, read_kept
from plumbline.harness.scene import Body, ConvexHull, Ellipsoid, PlacedShape, Scene, TriangleMesh, polyhedron_of
from plumbline.harness.scene.importers.fidelity import Fidelity
from plumbline.harness.scene.importers.meshes import Mesh, hull_of
from plumbline.harness.scene.importers.poses import Array
from plumbline.harness.scene.importers.robot import Geometry, Robot
from plumbline.harness.scene.importers.solids import of_mesh

CONCAVITY = 0.05
"""Below which a piece is not cut further, in CoACD's measure, relative to the mesh's size: its own default."""

SEARCH = {"mcts_iterations": 20, "mcts_nodes": 8, "mcts_max_depth": 1, "resolution": 500}
"""A shorter search for cuts than CoACD's own, which takes minutes for a robot of eight links; the error is measured anyhow."""


def pieces_of(mesh: Mesh, most: int, where: str, tell: Callable[[str], object] | None) -> tuple[list[ConvexHull], float]:
    """At most `most` convex pieces of a mesh, and the sum of their volumes [m3], overlaps counted twice.

    Args: tell: is told, before a mesh is taken apart, that this takes its time; None where nobody listens.
    Raises: RobotError, where CoACD is not installed or finds none.
    """
    try:
        import coacd
    except ImportError:
        raise RobotError(f"{where}: --convex needs CoACD: pip install plumbline[decomposition]") from None
    kept = _place(mesh, most)
    points = _kept(kept)
    if points is None:
        if tell is not None:
            tell(f"{where}: {len(mesh.faces)} faces are taken apart into convex pieces, once on this machine")
        coacd.set_log_level("error")
        whole = coacd.Mesh(np.asarray(mesh.vertices, np.float64), np.asarray(mesh.faces, np.int32))
        try:
            pieces = coacd.run_coacd(whole, threshold=CONCAVITY, max_convex_hull=most, seed=0, **SEARCH)
        except Exception as error:  # a broken mesh may break it anywhere
            message = readable(f"{type(error).__name__}: {error}", 160)
            raise RobotError(
                f"{where}: CoACD cannot take the mesh apart ({message}); without --convex its hull is taken"
            ) from None
        points = [np.asarray(corners, np.float64) for corners, _ in pieces]
        _keep(kept, points)
    made = [hull_of(corners, where) for corners in points]
    if not made:
        raise RobotError(f"{where}: CoACD finds no pieces; without --convex the mesh's hull is taken")
    return [shape for shape, _ in made], sum(volume for _, volume in made)


def _place(mesh: Mesh, most: int) -> Path:
    """Where the pieces of a mesh are kept, by all that they depend on."""
    asked = {"coacd": version("coacd"), "most": most, "concavity": CONCAVITY, **SEARCH}
    digest = hashlib.sha256(json.dumps(asked, sort_keys=True).encode())
    for array in (mesh.vertices, mesh.faces):
        digest.update(repr((array.shape, array.dtype.str)).encode() + np.ascontiguousarray(array).tobytes())
    return cache_folder("pieces") / f"{digest.hexdigest()}.npz"


def _kept(place: Path) -> list[Array] | None:
    """The corners (n, 3) m of each piece that is kept; None where none are, or no such thing."""
    content = read_kept(place)
    if content is None:
        return None
    with np.load(io.BytesIO(content), allow_pickle=False) as arrays:
        points = [np.asarray(arrays[name], np.float64) for name in sorted(arrays.files)]
    sound = all(corners.ndim == 2 and corners.shape[1] == 3 and np.isfinite(corners).all() for corners in points)
    return points if points and sound else None


def _keep(place: Path, points: Sequence[Array]) -> None:
    """Keep the pieces, all or nothing; where that cannot be done they are worked out again."""
    archive, arrays = io.BytesIO(), dict[str, Any]({f"{k:03}": corners for k, corners in enumerate(points)})
    np.savez(archive, allow_pickle=False, **arrays)
    keep(place, archive.getvalue())


def in_pieces(scene: Scene, most: int, where: str, tell: Callable[[str], object] | None = None) -> tuple[Scene, list[Fidelity]]:
    """The scene with each closed collision mesh as at most `most` convex hulls, and what that may change.

    Masses, frames and what is drawn stay. An open mesh encloses nothing that could be taken apart, and stays too.
    Args: where: the scene, in words; tell: is told before a mesh is taken apart, since that takes its time.
    Raises: RobotError, where CoACD is not installed or finds no pieces.
    """
    made: dict[TriangleMesh, tuple[list[ConvexHull], float]] = {}
    counts: dict[str, int] = {}
    excess = 0.0
    bodies = []
    for body in scene.bodies:
        shapes: list[PlacedShape] = []
        for placed in body.collision:
            mesh = _closed(placed)
            if mesh is None:
                shapes.append(placed)
                continue
            shape, volume = placed.shape, of_mesh(mesh).mass
            assert isinstance(shape, TriangleMesh)
            if shape not in made:
                made[shape] = pieces_of(mesh, most, f"{where}: body '{body.name}'", tell)
            hulls, total = made[shape]
            counts[body.name] = counts.get(body.name, 0) + len(hulls)
            excess = max(excess, total / volume - 1)
            shapes += [replace(placed, shape=hull) for hull in hulls]
        bodies.append(_shaped(body, tuple(shapes)) if body.name in counts else body)
    if not counts:
        return scene, []
    rows = Fidelity.told("mesh in pieces", list(counts), excess, pieces=sum(counts.values()), most=most)
    return replace(scene, bodies=tuple(bodies)), rows


def _closed(placed: PlacedShape) -> Mesh | None:
    """The mesh of a shape that is a closed one with its faces outwards; None for any other."""
    if not isinstance(placed.shape, TriangleMesh):
        return None
    mesh = Mesh(np.asarray(placed.shape.vertices, np.float64), np.asarray(placed.shape.faces, np.int64))
    return mesh if mesh.closed and of_mesh(mesh).mass > 0 else None


def _shaped(body: Body, shapes: tuple[PlacedShape, ...]) -> Body:
    """The body with other collision shapes, drawn as it was."""
    return replace(body, collision=shapes, visual=body.collision if body.visual is None else body.visual)


ELEMENT = "geom ellipsoid"
"""What rows on ellipsoids are of."""


def as_polyhedra(robot: Robot) -> Robot:
    """The robot whose ellipsoids that touch are the hulls of points on them, with a row that says how far those lie inside."""
    links, names, inside = [], [], 0.0
    for link in robot.links:
        made = []
        for geometry in link.geometries:
            if isinstance(geometry.shape, Ellipsoid):
                names.append(link.name)
                inside = max(inside, _inside(geometry.shape))
                made.append(Geometry(ConvexHull(vertices=polyhedron_of(geometry.shape)), geometry.X_LG, geometry.contact))
            else:
                made.append(geometry)
        links.append(replace(link, geometries=tuple(made)))
    if not names:
        return robot
    words = "as the companion asks; it rocks on its facets, and contacts lie inside the true surface by up to"
    row = Fidelity.approximated(ELEMENT, names, "a polyhedron of 162 corners", consequence=words, value=inside, unit="m")
    rows = tuple(each for each in robot.rows if each.element != ELEMENT)
    return replace(robot, links=tuple(links), rows=rows).told(row)


def _inside(shape: Ellipsoid) -> float:
    """How far the facets lie inside the ellipsoid at most [m], its largest semi-axis times that of the unit ball's."""
    from scipy.spatial import ConvexHull as Hull  # late: a listing must not pay for it

    planes = Hull(np.array(polyhedron_of(Ellipsoid(semi_axes=(1.0, 1.0, 1.0))))).equations
    return float(max(shape.semi_axes) * (1 + planes[:, 3]).max())
