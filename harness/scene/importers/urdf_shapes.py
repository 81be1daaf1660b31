"""The shapes of URDF's links: primitives as they are, meshes as hulls or convex pieces, and mass from them if none is given."""

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from harness.intake.refusal import RobotError, listed
from harness.scene import Box, ConvexHull, Cylinder, Shape, Sphere
from harness.scene.importers.decomposition import pieces_of
from harness.scene.importers.fidelity import Fidelity
from harness.scene.importers.files import Folders
from harness.scene.importers.meshes import hull_of, load_mesh
from harness.scene.importers.poses import IDENTITY, Array, Pose
from harness.scene.importers.robot import Geometry, Look, Solid
from harness.scene.importers.solids import moved, of_mesh, of_shape, together
from harness.scene.importers.xml_text import Element


class Shapes:
    """Reads the shapes of one link after the other, and keeps what is to be said of them all."""

    def __init__(
        self, folders: Folders, density: float | None, convex: int | None = None, tell: Callable[[str], object] | None = None
    ) -> None:
        self._folders, self._density, self._convex, self._tell = folders, density, convex, tell
        self._solids: dict[str, list[Solid]] = {}
        self._exact = 0
        self._excess: dict[str, float] = {}
        self._missing: dict[str, list[str]] = {}
        self._filled: list[str] = []
        self._spread: list[str] = []
        self._drawn = 0
        self._pieces: dict[str, int] = {}
        self._read: dict[tuple[str, tuple[float, ...]], tuple[list[ConvexHull], float, Solid]] = {}

    def of(self, link: Any, element: Element) -> tuple[Geometry, ...]:
        """The collision shapes of a link that yourdfpy has read. Raises: RobotError."""
        self._drawn += len(link.visuals)
        made = []
        for collision, own in zip(link.collisions, element.all("collision"), strict=True):
            X = IDENTITY if collision.origin is None else _pose(collision.origin)
            read = self._shape(collision.geometry, own, link.name)
            if read is not None:
                shapes, solid = read
                made += [Geometry(shape, X) for shape in shapes]
                self._solids.setdefault(link.name, []).append(moved(solid, X))
        return tuple(made)

    def looks(self, link: Any, element: Element, colours: Mapping[str, Any]) -> tuple[Look, ...]:
        """What is drawn of a link, meshes unread. Args: colours: of the materials that the robot names, by name."""
        made = []
        for visual, own in zip(link.visuals, element.all("visual"), strict=True):
            X = IDENTITY if visual.origin is None else _pose(visual.origin)
            geometry, colour = visual.geometry, _colour(visual.material, colours)
            if geometry is None:
                continue
            if geometry.mesh is None:
                shape = _primitive(geometry)
                if shape is not None:
                    made.append(Look(X_LG=X, shape=shape, colour=colour))
                continue
            try:
                path = self._folders.found(geometry.mesh.filename, own.where)
            except RobotError:  # it leads outside: nothing is read of it, and nothing moves otherwise
                path = None
            scale = (1.0, 1.0, 1.0) if geometry.mesh.scale is None else np.broadcast_to(geometry.mesh.scale, (3,)).tolist()
            made.append(Look(X_LG=X, file=path, scale=tuple(scale), where=own.where, colour=colour))
        return tuple(made)

    def _shape(self, geometry: Any, element: Element, link: str) -> tuple[Sequence[Shape], Solid] | None:
        if geometry.mesh is not None:
            return self._mesh(geometry.mesh, element, link)
        shape = _primitive(geometry)
        assert shape is not None
        self._exact += 1
        return [shape], of_shape(shape)

    def _mesh(self, mesh: Any, element: Element, link: str) -> tuple[Sequence[Shape], Solid] | None:
        scale = (1.0, 1.0, 1.0) if mesh.scale is None else tuple(float(x) for x in np.broadcast_to(mesh.scale, (3,)))
        where = f"{element.where}: mesh filename"
        path = self._folders.found(mesh.filename, where)
        if path is None:
            self._missing.setdefault(self._folders.missing(mesh.filename), []).append(link)
            return None
        key = (str(path), scale)
        if key not in self._read:
            self._read[key] = self._loaded(path, np.array(scale), where)
        shapes, excess, solid = self._read[key]
        worst = self._excess.get(link, excess)
        self._excess[link] = excess if np.isnan(worst) else max(worst, excess) if not np.isnan(excess) else worst
        self._pieces[link] = self._pieces.get(link, 0) + len(shapes)
        return shapes, solid

    def _loaded(self, path: Path, scale: Array, where: str) -> tuple[list[ConvexHull], float, Solid]:
        """What stands for a mesh, by how much its volume exceeds the mesh's (nan where that is open), and the mesh filled."""
        mesh = load_mesh(path, scale, where)
        hull, volume = hull_of(mesh.vertices, where)
        inside = of_mesh(mesh) if mesh.closed else None
        shapes = [hull]
        if self._convex is not None:
            shapes, volume = pieces_of(mesh, self._convex, where, self._tell)
        if inside is None or inside.mass <= 0:
            return shapes, float("nan"), of_shape(hull)
        return shapes, volume / inside.mass - 1, inside

    def filled(self, link: str) -> Solid | None:
        """The mass of a link's shapes at the density; None where there is no density, or no shape."""
        solids = self._solids.get(link, [])
        if self._density is None or not solids:
            return None
        self._filled.append(link)
        whole = together(solids)
        assert whole.inertia is not None
        return Solid(whole.mass * self._density, whole.centre, whole.inertia * self._density)

    def spread(self, link: str, mass: float, centre: Array | None, element: Element) -> Solid:
        """A mass without a tensor, spread evenly over the link's shapes. Raises: RobotError, where it has none."""
        solids = self._solids.get(link, [])
        whole = together(solids) if solids else None
        if whole is None or whole.mass <= 0 or whole.inertia is None:
            raise element.refuse(
                f"<inertial> has a mass of {mass:g} kg and no <inertia>, and there is no shape to spread it over"
            )
        self._spread.append(link)
        return Solid(mass, whole.centre if centre is None else centre, whole.inertia * (mass / whole.mass))

    def rows(self) -> list[Fidelity]:
        """What became of the shapes."""
        rows = []
        if self._exact:
            rows.append(Fidelity(element="collision", name="primitives", count=self._exact, outcome="exact", becomes="shapes"))
        if self._excess:
            known = [value for value in self._excess.values() if value == value]
            what = "the hull's volume exceeds" if self._convex is None else "the pieces' volumes together exceed"
            rows.append(
                Fidelity(
                    element="collision mesh",
                    name=listed(list(self._excess)),
                    count=len(self._excess),
                    outcome="approximated",
                    becomes="convex hull"
                    if self._convex is None
                    else f"{sum(self._pieces.values())} convex pieces by CoACD, at most {self._convex} a mesh",
                    consequence=f"contacts where the mesh is hollow; {what} a closed mesh's by at most"
                    if known
                    else "contacts where the mesh is hollow; the mesh is open, so that its volume is not known",
                    value=max(known) if known else None,
                    unit="1" if known else "",
                )
            )
        for why, links in self._missing.items():
            rows.append(
                Fidelity(
                    element="collision mesh",
                    name=listed(links),
                    count=len(links),
                    outcome="left_out",
                    consequence=f"{why}: nothing touches these shapes, masses and joints stay as they are",
                )
            )
        for links, word in ((self._filled, "mass and inertia"), (self._spread, "inertia")):
            if links:
                rows.append(
                    Fidelity(
                        element="inertial",
                        name=listed(links),
                        count=len(links),
                        outcome="approximated",
                        becomes=f"{word} of the collision shapes, filled evenly",
                        consequence="the file gives none",
                    )
                )
        if self._drawn:
            rows.append(
                Fidelity(
                    element="visual",
                    name="",
                    count=self._drawn,
                    outcome="left_out",
                    becomes="the collision shapes are drawn",
                    consequence="pictures and cameras see what collides",
                )
            )
        return rows


def _primitive(geometry: Any) -> Shape | None:
    """The shape of a box, a sphere or a cylinder; None of what has none of them."""
    if geometry.box is not None:
        x, y, z = (float(side) / 2 for side in geometry.box.size)
        return Box(half_extents=(x, y, z))
    if geometry.sphere is not None:
        return Sphere(radius=float(geometry.sphere.radius))
    if geometry.cylinder is not None:
        return Cylinder(radius=float(geometry.cylinder.radius), half_length=float(geometry.cylinder.length) / 2)
    return None


def _colour(material: Any, colours: Mapping[str, Any]) -> tuple[float, float, float] | None:
    """What a material states itself, or the robot of it by name."""
    stated = None if material is None else material.color or colours.get(material.name)
    rgba = None if stated is None else getattr(stated, "rgba", None)
    if rgba is None or len(rgba) < 3 or not np.isfinite(rgba[:3]).all():
        return None
    return float(rgba[0]), float(rgba[1]), float(rgba[2])


def _pose(origin: Array) -> Pose:
    return Pose(np.array(origin[:3, :3]), np.array(origin[:3, 3]))
