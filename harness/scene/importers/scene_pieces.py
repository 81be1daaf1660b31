"""The meshes of a scene in convex pieces, which every engine collides, moving or not; pictures keep the meshes."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from plumbline.harness.scene import Body, ConvexHull, PlacedShape, Scene, TriangleMesh
from plumbline.harness.scene.importers.decomposition import pieces_of
from plumbline.harness.scene.importers.fidelity import Fidelity
from plumbline.harness.scene.importers.meshes import Mesh
from plumbline.harness.scene.importers.solids import of_mesh


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
    becomes = f"{sum(counts.values())} convex pieces by CoACD, at most {most} a mesh"
    words = "contacts where the mesh is hollow; the pieces' volumes together exceed a closed mesh's by at most"
    rows = Fidelity.approximated("collision mesh", list(counts), becomes, consequence=words, value=excess, unit="1")
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
