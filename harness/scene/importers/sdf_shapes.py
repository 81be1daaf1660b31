"""SDF's collisions: shapes in their link, what they are for contacts, and the mass that fills them."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations_with_replacement

from plumbline.harness.intake.safe_text import quoted
from plumbline.harness.scene import Box, Capsule, Cylinder, Ellipsoid, Plane, Shape, Sphere, Surface
from plumbline.harness.scene.importers.companion import Ground
from plumbline.harness.scene.importers.fidelity import Fidelity
from plumbline.harness.scene.importers.importer import Reading
from plumbline.harness.scene.importers.poses import Pose
from plumbline.harness.scene.importers.robot import ContactRules, Geometry, Solid
from plumbline.harness.scene.importers.sdf_frames import Scope
from plumbline.harness.scene.importers.sdf_grammar import flag, lengths, number, numbers, word
from plumbline.harness.scene.importers.solids import moved, together
from plumbline.harness.scene.importers.urdf_shapes import Shapes
from plumbline.harness.scene.importers.xml_text import Element

FRICTION = 1.0
"""Where nothing is said, as the specification has it."""
_ALL = 0xFFFF


@dataclass(frozen=True, slots=True)
class _Detail:
    """What tells shapes apart for contacts. Terms: mask: two shapes touch where theirs share a bit."""

    friction: float
    restitution: float
    mask: int


class Collisions:
    """Reads the shapes of one link after the other, and keeps what is to be said of them all.

    Terms: unsaid: links without an <inertial>, which have the format's own.
    """

    def __init__(self, reading: Reading, self_collide: bool) -> None:
        self._shapes = Shapes(reading.folders, None, reading.convex, reading.tell)
        self._self_collide = self_collide
        self._sorts: dict[_Detail, str] = {}
        self._solids: dict[str, list[tuple[Solid, float | None]]] = {}
        self._apart: list[str] = []
        self._other_way: list[str] = []
        self._filled: list[str] = []
        self.unsaid: list[str] = []

    def of(self, link: Element, scope: Scope, X_ML: Pose, name: str) -> tuple[Geometry, ...]:
        """The shapes of a link. Raises: RobotError."""
        geometries = list[Geometry]()
        for collision in link.all("collision"):
            label = f"{name}/{collision.attributes.get('name', '')}"
            sort = self._sort(collision, label)
            X_LG = X_ML.inverse() @ scope.placed(collision, link.attributes["name"])
            read = self._shape(collision, name)
            if read is None:
                continue
            shapes, solid = read
            density = collision.first("density")
            own = None if density is None else number(collision, "density", 1000.0)
            self._solids.setdefault(name, []).append((moved(solid, X_LG), own))
            if sort is None:
                self._apart.append(label)
                continue
            key = self._sorts.setdefault(sort, f"robot_{len(self._sorts) + 1}" if self._sorts else "robot")
            geometries += [Geometry(shape, X_LG, key) for shape in shapes]
        return tuple(geometries)

    def _shape(self, collision: Element, link: str) -> tuple[Sequence[Shape], Solid] | None:
        geometry = collision.first("geometry")
        forms = [] if geometry is None else geometry.children
        if geometry is None or len(forms) != 1:
            raise collision.refuse("has no <geometry> of one shape, expected that")
        form = forms[0]
        match form.tag:
            case "box":
                x, y, z = (side / 2 for side in lengths(form, "size", (1.0, 1.0, 1.0)))
                return self._shapes.primitive(Box(half_extents=(x, y, z)))
            case "sphere":
                return self._shapes.primitive(Sphere(radius=lengths(form, "radius")[0]))
            case "cylinder" | "capsule":
                kind = Cylinder if form.tag == "cylinder" else Capsule
                shape = kind(radius=lengths(form, "radius")[0], half_length=lengths(form, "length")[0] / 2)
                return self._shapes.primitive(shape)
            case "ellipsoid":
                x, y, z = lengths(form, "radii", (1.0, 1.0, 1.0))
                return self._shapes.primitive(Ellipsoid(semi_axes=(x, y, z)))
            case "plane":
                x, y, z = numbers(form, "normal", (3,)) or (0.0, 0.0, 1.0)
                if not math.hypot(x, y, z) > 1e-9:
                    raise form.refuse("<normal> has no length, expected a direction")
                return self._shapes.primitive(Plane(normal=(x, y, z)))
            case "mesh":
                if form.first("submesh") is not None:
                    raise form.refuse("asks for a part of a mesh by name, expected a file of its own for it")
                x, y, z = numbers(form, "scale", (3,)) or (1.0, 1.0, 1.0)
                if 0 in (x, y, z):
                    raise form.refuse("<scale> holds a 0, expected none")
                return self._shapes.mesh(word(form, "uri"), (x, y, z), f"{collision.where}: mesh uri", link)
            case _:
                raise form.refuse("is no shape of a scene, expected box, sphere, cylinder, capsule, ellipsoid, plane or mesh")

    def _sort(self, collision: Element, label: str) -> _Detail | None:
        """What a shape is for contacts; None where it touches nothing. Raises: RobotError."""
        surface = collision.first("surface")
        friction, bounce, contact = (
            None if surface is None else surface.first(tag) for tag in ("friction", "bounce", "contact")
        )
        ode = None if friction is None else friction.first("ode")
        first = number(ode, "mu", FRICTION)
        if number(ode, "mu2", first) != first:
            self._other_way.append(label)
        rebound = number(bounce, "restitution_coefficient", 0.0)
        if first < 0 or not 0 <= rebound <= 1:
            raise collision.refuse(f"friction is {first:g} and restitution {rebound:g}, expected 0 or more, and 0 to 1")
        if contact is not None and flag(contact, "collide_without_contact"):
            return None
        stated = None if contact is None else contact.first("collide_bitmask")
        try:
            mask = _ALL if stated is None else int(stated.text.strip(), 0) & _ALL
        except ValueError:
            raise stated.refuse(f"is {quoted(stated.text.strip(), 40)}, expected a whole number") from None  # type: ignore[union-attr]
        return _Detail(first, rebound, mask) if mask else None

    def filled(self, link: str, density: float, inertial: Element) -> Solid:
        """The mass of a link's shapes at a density [kg/m3], or their own. Raises: RobotError, where it has none."""
        solids = []
        for solid, own in self._solids.get(link, []):
            times = density if own is None else own
            assert solid.inertia is not None
            solids.append(Solid(solid.mass * times, solid.centre, solid.inertia * times))
        if not sum(solid.mass for solid in solids) > 0:
            raise inertial.refuse("is to be worked out, and the link has no shape with a volume, expected one")
        self._filled.append(link)
        return together(solids)

    def contacts(self) -> tuple[ContactRules, list[Fidelity]]:
        """The laws between shapes and with a ground, and what is said of them."""
        laws = []
        for (a, key_A), (b, key_B) in combinations_with_replacement(self._sorts.items(), 2):
            if self._self_collide and a.mask & b.mask:
                low, high = min(a.friction, b.friction), min(a.restitution, b.restitution)
                laws.append(Surface.rough(low, (key_A, key_B), restitution=high))
        ground = Ground().material
        laws += [Surface.rough(sort.friction, (key, ground), restitution=sort.restitution) for sort, key in self._sorts.items()]
        rows = list[Fidelity]()
        if self._sorts:
            most = max(sort.friction for sort in self._sorts)
            rows += Fidelity.told("friction of pairs", list(self._sorts.values()), most)
        rows += Fidelity.told("shape that touches nothing", self._apart)
        rows += Fidelity.left_out("mu2", self._other_way, "friction is alike both ways, by the first number")
        if not self._self_collide and self._sorts:
            rows += Fidelity.exact("self_collide", list(self._sorts.values()), "links that pass through each other")
        return ContactRules(laws=tuple(laws)), rows

    def rows(self) -> list[Fidelity]:
        """What became of the shapes and masses."""
        rows = self._shapes.rows()
        rows += Fidelity.exact("inertial", self.unsaid, "1 kg and 1 kg m2 about each axis", consequence="SDF's own default")
        rows += Fidelity.exact("inertial auto", self._filled, "mass and inertia of the collision shapes, filled evenly")
        return rows
