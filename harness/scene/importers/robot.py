"""A robot as every format is read: links that hang on each other by coordinates, before anything is merged or posed.

A link stands at `X_PL` in its parent where each of its coordinates has its `reference` value; its coordinates then act one
after the other, each about an axis that the ones before it have moved:

    X_PL(q) = X_PL M_1(q_1 - reference_1) M_2(q_2 - reference_2) ...

A link without coordinates is fixed to its parent.
"""

from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from itertools import chain
from pathlib import Path
from typing import Literal, Self
from zlib import crc32

import numpy as np

from plumbline.harness.intake.import_wishes import NOTHING, Drop, Omissions
from plumbline.harness.scene import Matrix3, Motion, Sensor, Shape, Surface, Vector3
from plumbline.harness.scene.importers.fidelity import Fidelity
from plumbline.harness.scene.importers.poses import IDENTITY, Array, Pose

Kind = Literal["revolute", "prismatic", "ball", "free"]


@dataclass(frozen=True, slots=True, eq=False)
class Solid:
    """Mass [kg], centre of mass in the link [m] and inertia about it in the link's axes [kg m2]; None where none is given."""

    mass: float
    centre: Array
    inertia: Array | None


@dataclass(frozen=True, slots=True, eq=False)
class Geometry:
    """A shape in its link. Terms: contact: what it is for contacts, a key of the robot's."""

    shape: Shape
    X_LG: Pose
    contact: str = "robot"


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Look:
    """What is drawn of a link in place of what touches: a shape, or the mesh of a file that is not read yet.

    Terms: file, scale (3,), where: of the mesh; in the file that names it. vertices, faces: of a mesh that is at hand.
    colour [1]: as the file states it, red, green, blue; None where it states none.
    """

    X_LG: Pose
    shape: Shape | None = None
    file: Path | None = None
    scale: tuple[float, float, float] = (1.0, 1.0, 1.0)
    where: str = ""
    vertices: Array | None = None
    faces: Array | None = None
    colour: tuple[float, float, float] | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class Servo:
    """A drive: stiffness (target - x) + damping (target_velocity - x') + feedforward, cut off at limit, and a constant push.

    Terms: motion: how its target moves. push [N m or N]: beside the drive, not cut off.
    """

    stiffness: float = 0.0
    damping: float = 0.0
    target: float = 0.0
    target_velocity: float = 0.0
    limit: float | None = None
    motion: Motion | None = None
    feedforward: float = 0.0
    push: float = 0.0


@dataclass(frozen=True, slots=True, kw_only=True)
class Tie:
    """Whom a coordinate follows: x = ratio y + offset, y being the coordinate `joint`.

    Terms: joint: '' where a loader does not tell. kinds: any of which, dropped by the user, sets it free. soft: the file says
    how softly it holds.
    """

    joint: str
    ratio: float
    offset: float = 0.0
    kinds: frozenset[Drop] = frozenset(("mimic",))
    soft: bool = False


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Coordinate:
    """One degree of freedom of a link (three of a ball, six of a free one).

    Terms:
        anchor [m], axis: in the link, at the reference. lower, upper [rad or m]; None is open. stiffness, damping, rest: of a
        passive spring. armature [kg m2 or kg]; friction_loss [N m or N]; effort [N m or N]; speed [rad/s or m/s]: its bound.
        tie: to another coordinate. velocity: at the start. position: at the start, None for the reference. needs_range: the
        format asks for a range, and the file gives none or half of one. X_start: the pose of a free link in its parent at the
        start, and of a ball's turn; None for the reference. w_start, v_start: of a free or ball joint at the start, angular
        velocity [rad/s] in the link and velocity [m/s] of its origin in W; None for none. where: file and line.
    """

    name: str
    kind: Kind
    axis: Array = field(default_factory=lambda: np.array([1.0, 0.0, 0.0]))
    anchor: Array = field(default_factory=lambda: np.zeros(3))
    reference: float = 0.0
    lower: float | None = None
    upper: float | None = None
    stiffness: float = 0.0
    damping: float = 0.0
    rest: float = 0.0
    armature: float = 0.0
    friction_loss: float = 0.0
    effort: float | None = None
    speed: float | None = None
    position: float | None = None
    velocity: float = 0.0
    servo: Servo | None = None
    tie: Tie | None = None
    needs_range: bool = False
    X_start: Pose | None = None
    w_start: Array | None = None
    v_start: Array | None = None
    where: str = ""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Link:
    """One link.

    Terms:
        parent: None for the world. geometries: what touches; drawn: what is drawn too. looks: what is drawn instead, where
        pictures are made. where: in the file.
    """

    name: str
    parent: str | None
    X_PL: Pose = IDENTITY
    coordinates: tuple[Coordinate, ...] = ()
    solid: Solid | None = None
    geometries: tuple[Geometry, ...] = ()
    drawn: tuple[Geometry, ...] = ()
    looks: tuple[Look, ...] = ()
    where: str = ""

    @property
    def coordinate(self) -> Coordinate:
        """The one coordinate of a link that has one."""
        (coordinate,) = self.coordinates
        return coordinate


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Closure:
    """What acts between two links beside the tree: it holds a point ('ball') or everything ('fixed'), or is a 'spring'.

    Terms: anchor_A, anchor_B [m]: the point in either link. R_AB: how B is turned in A where everything is held. stiffness
    [N/m], damping [N s/m], rest [m]: of a spring between the two points.
    """

    name: str
    kind: Literal["ball", "fixed", "spring"]
    link_A: str
    link_B: str
    anchor_A: Array
    anchor_B: Array
    R_AB: Array | None = None
    stiffness: float = 0.0
    damping: float = 0.0
    rest: float = 0.0


@dataclass(frozen=True, slots=True, kw_only=True)
class Cord:
    """A tendon: a length that is the sum of arm times coordinate, with the laws that a coordinate has.

    Terms: arms: by the name of a coordinate. lower, upper: None is open. stiffness, damping, rest: of a passive spring.
    """

    name: str
    arms: tuple[tuple[str, float], ...]
    lower: float | None = None
    upper: float | None = None
    stiffness: float = 0.0
    damping: float = 0.0
    rest: float = 0.0
    servo: Servo | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class ContactRules:
    """Who touches whom, by contact keys and by links.

    Terms: laws: by pair of keys, those that are missing never touch. excluded: pairs of links that never touch. paired: pairs
    of keys whose law holds between excluded links too.
    """

    laws: tuple[Surface, ...] = ()
    excluded: tuple[tuple[str, str], ...] = ()
    paired: frozenset[frozenset[str]] = frozenset()

    def key(self, link: str, contact: str) -> str:
        """The contact key of a link's shape: one of the link's own where it is excluded from touching another."""
        return f"{contact}:{_short(link)}" if any(link in pair for pair in self.excluded) else contact


def _short(name: str) -> str:
    """A name that fits into that of a material, no two of which are alike."""
    return name if len(name) < 79 else f"{name[:69]}.{crc32(name.encode()):08x}"


@dataclass(frozen=True, slots=True, kw_only=True)
class Need:
    """Elements that change the motion and have no word in a scene. Terms: kind: one of DROPPABLE; size: of the largest."""

    kind: Drop
    element: str
    names: tuple[str, ...]
    size: str = ""

    @classmethod
    def of(cls, kind: Drop, element: str, names: Iterable[str], size: str = "") -> "list[Need]":
        """What these elements need; nothing where there are none."""
        need = cls(kind=kind, element=element, names=tuple(names), size=size)
        return [need] if need.names else []


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Robot:
    """All that a file says.

    Terms:
        links: parents before children. root: how the root is held, None where the format does not say. gravity [m/s2]: None
        where it does not say. contacts: None where it does not say: then all links are of the material 'robot'. filter_world:
        does a link that hangs on the world pass through what is fixed to the world? collide: do links touch what they hang on?
        sensors: of the file, with a link for their body. rows: what was settled while it was read.
        needs: what has to be dropped by the user. dropped: what the user has dropped.
        speed_limits: are bounds of speed laws of the scene?
        wordless: fields of a Coordinate that the format has no word for.
    """

    name: str
    links: tuple[Link, ...]
    closures: tuple[Closure, ...] = ()
    tendons: tuple[Cord, ...] = ()
    root: Literal["fixed", "floating"] | None = None
    gravity: Vector3 | None = None
    contacts: ContactRules | None = None
    filter_world: bool = True
    collide: bool = False
    sensors: tuple[Sensor, ...] = ()
    rows: tuple[Fidelity, ...] = ()
    needs: tuple[Need, ...] = ()
    dropped: Omissions = NOTHING
    speed_limits: bool = False
    wordless: frozenset[str] = frozenset()
    source: str = ""

    def told(self, *rows: list[Fidelity]) -> Self:
        """The robot with more rows."""
        return replace(self, rows=(*self.rows, *chain(*rows)))

    def coordinates(self) -> Iterator[Coordinate]:
        """Those of all links."""
        return (c for link in self.links for c in link.coordinates)

    def each(self, change: Callable[[Coordinate], Coordinate]) -> Self:
        """The robot with each coordinate changed."""
        links = (replace(link, coordinates=tuple(map(change, link.coordinates))) for link in self.links)
        return replace(self, links=tuple(links))


def parents_first(parent: Mapping[str, str], roots: Iterable[str]) -> list[str]:
    """All that hangs on these roots and the roots themselves, parents before children, each branch to its end.

    Args: parent: by the name of each link that hangs on another one.
    """
    below: dict[str, list[str]] = {}
    for child, above in parent.items():
        below.setdefault(above, []).append(child)
    order, waiting = list[str](), [*roots][::-1]
    while waiting:
        order.append(waiting.pop())
        waiting += reversed(below.get(order[-1], ()))
    return order


def symmetric(tensor: Array) -> Matrix3:
    """The tensor as a scene holds it, made symmetric to the last bit."""
    t = (tensor + tensor.T) / 2
    return (
        (float(t[0, 0]), float(t[0, 1]), float(t[0, 2])),
        (float(t[1, 0]), float(t[1, 1]), float(t[1, 2])),
        (float(t[2, 0]), float(t[2, 1]), float(t[2, 2])),
    )
