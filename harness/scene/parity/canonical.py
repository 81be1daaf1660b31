"""The form in which robots are compared, whoever read them: one link a coordinate, all frames W's where coordinates are at 0.

What fixed joints hold together is one link, by the name of the coordinate that moves it; its `where` names the links that it is
of. What nothing moves is the link FIXED, with shapes alone.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from itertools import combinations
from pathlib import Path

import numpy as np

from plumbline.harness.intake.documents import InputError, document, named
from plumbline.harness.intake.error import RobotError, listed
from plumbline.harness.intake.import_wishes import NOTHING, Omissions, Root, Wishes
from plumbline.harness.intake.near_miss import did_you_mean
from plumbline.harness.intake.safe_text import quoted
from plumbline.harness.scene import Surface
from plumbline.harness.scene.importers.companion import Companion
from plumbline.harness.scene.importers.kinematics import Line, Posed, posed
from plumbline.harness.scene.importers.materials import laws_of
from plumbline.harness.scene.importers.merging import Group, check_masses, grouped
from plumbline.harness.scene.importers.poses import IDENTITY
from plumbline.harness.scene.importers.reading import robot_of
from plumbline.harness.scene.importers.robot import Closure, Coordinate, Geometry, Link, Robot
from plumbline.harness.scene.importers.settling import left_of
from plumbline.harness.scene.importers.solids import moved
from plumbline.harness.scene.importers.ties import lets_go

FIXED = ""
"""The link that stands for the world, and what is fixed to it."""
SCALAR = ("revolute", "prismatic")
_UNCOMPARED = ("armature", "friction_loss", "actuator")
"""Needs of these kinds are numbers of joints, or of what drives a robot."""
_ACROSS = 1e-9
"""How far from a right angle axes may be that are written down as being at one."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Canonical(Robot):
    """Terms: touches: the laws of those that may touch, by pair of links. An axis is a unit vector but where a loader keeps
    another length: then rates count as many times, and poses do not."""

    touches: Mapping[frozenset[str], Surface] = field(default_factory=dict)

    @property
    def moving(self) -> tuple[Link, ...]:
        """The links that have a coordinate."""
        return tuple(link for link in self.links if link.coordinates)

    @property
    def joints(self) -> tuple[Coordinate, ...]:
        """All coordinates, parents before children."""
        return tuple(link.coordinate for link in self.moving)

    @property
    def weight(self) -> float:
        """The mass of all that moves [kg]."""
        return sum(link.solid.mass for link in self.moving if link.solid is not None)


def pair_of(path_A: Path, path_B: Path, wishes: Wishes) -> tuple[Canonical, Canonical]:
    """The robots of two files. Where one does not say how its root is held, it is held as the other's. Raises: RobotError."""
    read = [robot_of(path, wishes) for path in (path_A, path_B)]
    joints = [c.name for robot, _, _ in read for link in robot.links for c in link.coordinates]
    wishes.omissions.check(joints, " and ".join(robot.source for robot, _, _ in read))
    roots = [robot.root or wishes.root or companion.root for robot, companion, _ in read]
    a, b = (
        canonical(_held(robot, own or other or "fixed"), all_wishes.omissions)
        for (robot, _, all_wishes), own, other in zip(read, roots, roots[::-1], strict=True)
    )
    return a, b


def stated(path: Path, wishes: Wishes) -> tuple[Canonical, Root]:
    """The robot of a file, and how a loader is to hold its root: fixed where neither the file nor its user says.

    Raises: RobotError.
    """
    robot, companion, wishes = robot_of(path, wishes)
    wishes.omissions.check((c.name for link in robot.links for c in link.coordinates), robot.source)
    root = wishes.root or companion.root or "fixed" if robot.root is None else "fixed"
    return canonical(_held(robot, robot.root or root), wishes.omissions), root


def _held(robot: Robot, root: Root) -> Robot:
    """The robot with a joint of its root where that is free, and the file does not say so."""
    if robot.root is not None or root != "floating":
        return robot
    free = Coordinate(name=f"{robot.links[0].name}.root", kind="free")
    return replace(robot, links=(replace(robot.links[0], coordinates=(free,)), *robot.links[1:]))


def canonical(robot: Robot, dropped: Omissions = NOTHING, *, read_back: bool = False) -> Canonical:
    """A robot in this form. Args: dropped: what is taken out. read_back: of an engine, where a mass of 0 may have a tensor.

    Raises: RobotError, for a tensor without a mass.
    """
    robot = replace(robot, links=tuple(map(_at_zero, robot.links)))
    at, groups = posed(robot, IDENTITY), grouped(robot)
    if not read_back:
        check_masses(groups)
    links, mover = {FIXED: Link(name=FIXED, parent=None)}, dict[str, str]()
    for link in robot.links:
        above = FIXED if link.parent is None else mover[link.parent]
        for line in at.lines[link.name]:
            name = line.coordinate.name
            links[name] = Link(name=name, parent=above, coordinates=(_coordinate(line, dropped),))
            above = name
        mover[link.name] = above
    for lead, group in groups.items():
        whole, X = links[mover[lead]], at.pose[lead]
        placed = tuple(Geometry(shape.shape, X @ shape.X_LG, shape.contact) for shape in group.geometries)
        solid = None if group.solid is None or whole.name == FIXED else moved(group.solid, X)
        geometries = (*whole.geometries, *placed)
        links[whole.name] = replace(whole, solid=solid, geometries=geometries, where=", ".join(group.members))
    needs = [left_of(need, dropped) for need in robot.needs if need.kind not in _UNCOMPARED]
    loops = (closure for closure in robot.closures if closure.kind == "spring" or not dropped.takes("equality"))
    return Canonical(
        name=robot.name,
        links=tuple(links.values()),
        closures=tuple(_closure(closure, at, mover) for closure in loops),
        tendons=() if dropped.takes("tendon") else robot.tendons,
        gravity=robot.gravity,
        needs=tuple(need for need in needs if need is not None),
        wordless=robot.wordless | ({"touch"} if robot.contacts is None else set()),
        source=robot.source,
        touches={} if robot.contacts is None else _touches(robot, groups, mover),
    )


def _at_zero(link: Link) -> Link:
    """The link with every coordinate at 0, and at W's origin where it is free in W."""
    coordinates = tuple(
        replace(c, position=0.0 if c.kind in SCALAR else None, velocity=0.0, X_start=None) for c in link.coordinates
    )
    free = any(c.kind == "free" for c in coordinates)
    return replace(link, coordinates=coordinates, X_PL=IDENTITY if free else link.X_PL)


def _coordinate(line: Line, dropped: Omissions) -> Coordinate:
    c = line.coordinate
    return replace(
        c,
        axis=line.axis_W,
        anchor=line.anchor_W,
        lower=c.lower or 0.0 if c.needs_range else c.lower,
        upper=c.upper or 0.0 if c.needs_range else c.upper,
        rest=c.rest if c.stiffness > 0 else 0.0,
        armature=0.0 if dropped.takes("armature", c.name) else c.armature,
        friction_loss=0.0 if dropped.takes("friction_loss", c.name) else c.friction_loss,
        tie=None if lets_go(dropped, c) else c.tie,
    )


def _closure(closure: Closure, at: Posed, mover: Mapping[str, str]) -> Closure:
    A, B = closure.link_A, closure.link_B
    anchor_A, anchor_B = at.pose[A].of(closure.anchor_A), at.pose[B].of(closure.anchor_B)
    return replace(closure, link_A=mover[A], link_B=mover[B], anchor_A=anchor_A, anchor_B=anchor_B)


def stronger(law: Surface | None, other: Surface) -> Surface:
    """Of two laws between the same two, the one that rubs more."""
    return other if law is None or other.kinetic_friction > law.kinetic_friction else law


def _touches(robot: Robot, groups: Mapping[str, Group], mover: Mapping[str, str]) -> dict[frozenset[str], Surface]:
    """The laws of what may touch, by the links of this form."""
    laws = laws_of(robot, groups, Companion())
    surfaces = {law.pair: law for law in laws.surfaces}
    materials = {
        lead: {laws.still[lead, shape.contact] for shape in group.geometries} if group.still else {laws.material[lead]}
        for lead, group in groups.items()
        if group.geometries
    }
    touches: dict[frozenset[str], Surface] = {}
    for a, b in combinations(materials, 2):
        joined = groups[b].parent == a and not robot.collide and (robot.filter_world or not groups[a].still)
        if joined or (groups[a].still and groups[b].still):
            continue
        pair = frozenset((mover[a], mover[b]))
        for law in (surfaces.get(frozenset((x, y))) for x in materials[a] for y in materials[b]):
            if law is not None:
                touches[pair] = stronger(touches.get(pair), law)
    return touches


def joint_names(path: Path, a: Canonical, b: Canonical) -> dict[str, str]:
    """A's names by B's, of a TOML file with a table `joints` of names in A to names in B.

    Raises: RobotError, naming the file, the joint and those that there are.
    """
    where = named(path)
    try:
        content = document(path)
    except InputError as error:
        raise RobotError(str(error)) from None
    table = content.get("joints") if isinstance(content, dict) else None
    if not isinstance(table, dict) or len(content) != 1:
        raise RobotError(f'{where}: expected one table, [joints], with a line "name in A" = "name in B" for each joint')
    names: dict[str, str] = {}
    for name_A, name_B in table.items():
        for side, name, robot in (("A", name_A, a), ("B", name_B, b)):
            known = [joint.name for joint in robot.joints]
            if not isinstance(name, str) or name not in known:
                shown = quoted(str(name), 80)
                hint = did_you_mean(str(name), known)
                raise RobotError(f"{where}: joints > {shown} is no joint of {side}, expected one of {listed(known, 12)}{hint}")
        if name_B in names:
            raise RobotError(f"{where}: joints > {quoted(name_B, 80)} of B is given twice, expected once")
        names[name_B] = name_A
    return names


def renamed(robot: Canonical, names: Mapping[str, str]) -> Canonical:
    """The robot with its joints by other names. Args: names: new by old; what is not in it keeps its own."""

    def new(name: str) -> str:
        return names.get(name, name)

    def called(c: Coordinate) -> Coordinate:
        return replace(c, name=new(c.name), tie=c.tie and replace(c.tie, joint=new(c.tie.joint)))

    return replace(
        robot,
        links=tuple(
            replace(
                link,
                name=new(link.name),
                parent=None if link.parent is None else new(link.parent),
                coordinates=tuple(map(called, link.coordinates)),
            )
            for link in robot.links
        ),
        closures=tuple(replace(each, link_A=new(each.link_A), link_B=new(each.link_B)) for each in robot.closures),
        touches={frozenset(map(new, pair)): law for pair, law in robot.touches.items()},
    )


def with_free_root(a: Canonical, b: Canonical) -> Canonical:
    """B with its free joint by A's name, where each has one: formats name it in ways of their own."""
    free_A, free_B = ([joint.name for joint in robot.joints if joint.kind == "free"] for robot in (a, b))
    return renamed(b, {free_B[0]: free_A[0]}) if len(free_A) == 1 and len(free_B) == 1 else b


def aligned(a: Canonical, b: Canonical) -> Canonical | None:
    """B with its links in the order of A's and its free root by A's name; None where their trees differ."""
    b = with_free_root(a, b)
    own = {link.name: link for link in b.links}
    trees = [{(link.name, link.coordinate.kind, link.parent) for link in robot.moving} for robot in (a, b)]
    return replace(b, links=tuple(own[link.name] for link in a.links)) if trees[0] == trees[1] else None


Plane = tuple[Coordinate, Coordinate, Coordinate]


def planes(robot: Canonical) -> Iterator[Plane]:
    """Planar joints: two slides and a hinge, each on the one before, at right angles, with both slides resisted alike."""
    links = {link.name: link for link in robot.moving}
    for last in links.values():
        above = links.get(last.parent or FIXED)
        first = None if above is None else links.get(above.parent or FIXED)
        if above is None or first is None:
            continue
        x, y, angle = first.coordinate, above.coordinate, last.coordinate
        if [x.kind, y.kind, angle.kind] == ["prismatic", "prismatic", "revolute"] and _resisted(x) == _resisted(y):
            axes = np.array([x.axis, y.axis, angle.axis])
            if np.abs(axes @ axes.T - np.eye(3)).max() <= _ACROSS:
                yield x, y, angle


def _resisted(slide: Coordinate) -> tuple[object, ...]:
    """What acts along a slide; a bound or a drive is of its own direction."""
    own = slide.name if (slide.lower, slide.upper, slide.servo, slide.friction_loss) != (None, None, None, 0.0) else ""
    return slide.damping, slide.stiffness, slide.rest, slide.armature, own


def turned_alike(a: Canonical, b: Canonical) -> Canonical:
    """B with its planar joints' slides along A's directions, where both slide in one plane: that is the same joint."""
    own = {tuple(joint.name for joint in plane): plane for plane in planes(b)}
    turned: dict[str, Coordinate] = {}
    for plane in planes(a):
        other = own.get(tuple(joint.name for joint in plane))
        if other is not None and max(abs(plane[2].axis @ slide.axis) for slide in other[:2]) <= _ACROSS:
            turned |= {joint.name: replace(slide, axis=joint.axis) for joint, slide in zip(plane[:2], other[:2], strict=True)}
    return replace(
        b, links=tuple(replace(link, coordinates=tuple(turned.get(c.name, c) for c in link.coordinates)) for link in b.links)
    )
