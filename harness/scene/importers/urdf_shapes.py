"""The shapes of URDF's links: primitives as they are, meshes as hulls or convex pieces, and mass from them if none is given."""

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path

import numpy as np

from plumbline.harness.intake.allowance import beyond
from plumbline.harness.intake.error import RobotError
from plumbline.harness.intake.safe_text import quoted
from plumbline.harness.scene import Box, ConvexHull, Cylinder, Shape, Sphere
from plumbline.harness.scene.importers.decomposition import pieces_of
from plumbline.harness.scene.importers.fidelity import Fidelity
from plumbline.harness.scene.importers.files import Folders
from plumbline.harness.scene.importers.meshes import coarser, hull_of, load_mesh, simplified
from plumbline.harness.scene.importers.poses import IDENTITY, Array, Pose, rolled
from plumbline.harness.scene.importers.robot import Geometry, Look, Solid
from plumbline.harness.scene.importers.solids import moved, of_mesh, of_shape, together
from plumbline.harness.scene.importers.urdf_grammar import numbers
from plumbline.harness.scene.importers.xml_text import Element


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
        self._coarser: dict[str, float] = {}
        self._bytes: dict[Path, int] = {}
        self._read: dict[tuple[str, tuple[float, ...]], tuple[list[ConvexHull], float, Solid]] = {}

    def of(self, link: Element) -> tuple[Geometry, ...]:
        """The collision shapes of a link. Raises: RobotError."""
        name = link.attributes["name"]
        self._drawn += len(link.all("visual"))
        geometries = []
        for collision in link.all("collision"):
            X, read = pose_of(collision), self._shape(collision, name)
            if read is not None:
                shapes, solid = read
                geometries += [Geometry(shape, X) for shape in shapes]
                self._solids.setdefault(name, []).append(moved(solid, X))
        return tuple(geometries)

    def looks(self, link: Element, materials: Mapping[str | None, Element]) -> tuple[Look, ...]:
        """What is drawn of a link, meshes unread. Args: materials: those that the robot states, by name."""
        looks = []
        for visual in link.all("visual"):
            X, form, colour = pose_of(visual), _form(visual), _colour(visual.first("material"), materials)
            if form.tag != "mesh":
                looks.append(Look(X_LG=X, shape=_primitive(form), colour=colour))
                continue
            try:
                path = self._folders.found(form.attributes["filename"], visual.where)
            except RobotError:  # it leads outside: nothing is read of it, and nothing moves otherwise
                path = None
            looks.append(Look(X_LG=X, file=path, scale=_scale(form), where=visual.where, colour=colour))
        return tuple(looks)

    def _shape(self, collision: Element, link: str) -> tuple[Sequence[Shape], Solid] | None:
        form = _form(collision)
        if form.tag == "mesh":
            return self.mesh(form.attributes["filename"], _scale(form), f"{collision.where}: mesh filename", link)
        return self.primitive(_primitive(form))

    def primitive(self, shape: Shape) -> tuple[Sequence[Shape], Solid]:
        """A shape that has a word in a scene, and what it is filled with."""
        self._exact += 1
        return [shape], of_shape(shape)

    def mesh(
        self, filename: str, scale: tuple[float, float, float], where: str, link: str
    ) -> tuple[Sequence[Shape], Solid] | None:
        """What stands for a link's mesh, and the mesh filled; None where there is no such file. Raises: RobotError."""
        path = None if self._folders.strays(filename) else self._folders.found(filename, where)
        if path is None:
            why = self._folders.missing(filename)
            self._missing.setdefault(why if why.startswith("package ") else f"{quoted(filename, 200)}: {why}", []).append(link)
            return None
        key = (str(path), scale)
        if key not in self._read:
            self._bytes[path] = path.stat().st_size
            if beyond_all := beyond("meshes", sum(self._bytes.values()), "bytes of all meshes"):
                raise RobotError(f"{where}: {beyond_all}")
            self._read[key] = self._loaded(path, np.array(scale), where)
        whole, excess, solid = self._read[key]
        shapes, off = zip(*map(simplified, whole), strict=True)
        if max(off) > 0:
            self._coarser[link] = max(*off, self._coarser.get(link, 0.0))
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
            rows += Fidelity.exact("collision", "primitives", "shapes", count=self._exact)
        if self._excess:
            known = [value for value in self._excess.values() if value == value]
            what = "the hull's volume exceeds" if self._convex is None else "the pieces' volumes together exceed"
            rows += Fidelity.approximated(
                "collision mesh",
                list(self._excess),
                "convex hull"
                if self._convex is None
                else f"{sum(self._pieces.values())} convex pieces by CoACD, at most {self._convex} a mesh",
                consequence=f"contacts where the mesh is hollow; {what} a closed mesh's by at most"
                if known
                else "contacts where the mesh is hollow; the mesh is open, so that its volume is not known",
                value=max(known) if known else None,
                unit="1" if known else "",
            )
        rows += coarser(self._coarser)
        for why, links in self._missing.items():
            rows += Fidelity.told("mesh not read", links, why=why)
        for links, word in ((self._filled, "mass and inertia"), (self._spread, "inertia")):
            rows += Fidelity.told("inertia of shapes", links, word=word)
        if self._drawn:
            rows += Fidelity.told("visual", "", count=self._drawn)
        return rows


def pose_of(element: Element) -> Pose:
    """The pose that its <origin> states, R = Rz(yaw) Ry(pitch) Rx(roll); the identity without one."""
    origin = element.first("origin")
    if origin is None:
        return IDENTITY
    xyz, rpy = (numbers(origin, name, (3,)) or (0.0, 0.0, 0.0) for name in ("xyz", "rpy"))
    p = np.array(xyz) + 0.0  # no zero with a sign
    return Pose(rolled(rpy) if any(rpy) else IDENTITY.R, p)


def _form(element: Element) -> Element:
    """The one shape of a visual's or a collision's <geometry>."""
    geometry = element.first("geometry")
    assert geometry is not None
    return geometry.children[0]


def _primitive(form: Element) -> Shape:
    """The shape of a box, a sphere or a cylinder."""
    if form.tag == "box":
        x, y, z = (_half(form, "size", side) for side in numbers(form, "size", (3,)) or ())
        return Box(half_extents=(x, y, z))
    (radius,) = numbers(form, "radius") or ()
    if form.tag == "sphere":
        return Sphere(radius=radius)
    (length,) = numbers(form, "length") or ()
    return Cylinder(radius=radius, half_length=_half(form, "length", length))


def _half(form: Element, name: str, side: float) -> float:
    """Half of a length above 0, which is above 0 too. Raises: RobotError."""
    if side > 0 and not side / 2:
        raise form.refuse(f"{name} is {side:g}, expected lengths of which there is a half")
    return side / 2


def _scale(mesh: Element) -> tuple[float, float, float]:
    scale = numbers(mesh, "scale", (1, 3)) or (1.0,)
    return scale[0], scale[len(scale) // 2], scale[-1]


def _colour(material: Element | None, materials: Mapping[str | None, Element]) -> tuple[float, float, float] | None:
    """What a material states itself, or the robot of it by name."""
    if material is None:
        return None
    named = materials.get(material.attributes.get("name"))
    stated = material.first("color") or (named and named.first("color"))
    if stated is None:
        return None
    red, green, blue, _ = numbers(stated, "rgba", (4,)) or (1.0, 1.0, 1.0, 1.0)
    return red, green, blue
