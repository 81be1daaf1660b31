"""What a file states of its robot, as the neutral import reads it."""

from collections.abc import Mapping
from dataclasses import replace
from itertools import combinations
from pathlib import Path

import numpy as np

from plumbline.harness.intake.import_wishes import NOTHING, Omissions, Root, Wishes
from plumbline.harness.scene import Surface
from plumbline.harness.scene.importers.companion import Companion
from plumbline.harness.scene.importers.kinematics import Posed, posed
from plumbline.harness.scene.importers.materials import laws_of
from plumbline.harness.scene.importers.merging import grouped
from plumbline.harness.scene.importers.poses import IDENTITY, Array
from plumbline.harness.scene.importers.reading import robot_of
from plumbline.harness.scene.importers.robot import Coordinate, Cord, Geometry, Link, Robot
from plumbline.harness.scene.importers.settling import left_of
from plumbline.harness.scene.importers.solids import moved
from plumbline.harness.scene.importers.ties import lets_go
from plumbline.harness.scene.parity.contacts import stronger
from plumbline.harness.scene.parity.facts import FIXED, JointFacts, Law, MassFacts, RobotFacts

_DRIVEN = "actuator"
"""Needs of this kind are of what drives a robot, and are not compared."""
_MERGED = ("armature", "friction_loss")


def pair_of(path_A: Path, path_B: Path, wishes: Wishes) -> tuple[RobotFacts, RobotFacts]:
    """The facts of two files. Where one does not say how its root is held, it is held as the other's. Raises: RobotError."""
    read = [robot_of(path, wishes) for path in (path_A, path_B)]
    joints = [c.name for robot, _, _ in read for link in robot.links for c in link.coordinates]
    wishes.omissions.check(joints, " and ".join(robot.source for robot, _, _ in read))
    roots = [robot.root or wishes.root or companion.root for robot, companion, _ in read]
    a, b = (
        _facts(robot, own or other or "fixed", all_wishes)
        for (robot, _, all_wishes), own, other in zip(read, roots, roots[::-1], strict=True)
    )
    return a, b


def facts_of(path: Path, wishes: Wishes) -> RobotFacts:
    """The facts that a file states; its root is fixed where neither the file nor its user says. Raises: RobotError."""
    robot, companion, wishes = robot_of(path, wishes)
    return _facts(robot, robot.root or wishes.root or companion.root or "fixed", wishes)


def audited(path: Path, wishes: Wishes) -> tuple[RobotFacts, Root]:
    """The facts that a file states, and how a loader is to hold its root. Raises: RobotError."""
    robot, companion, wishes = robot_of(path, wishes)
    wishes.omissions.check((c.name for link in robot.links for c in link.coordinates), robot.source)
    root = wishes.root or companion.root or "fixed" if robot.root is None else "fixed"
    return _facts(robot, robot.root or root, wishes), root


def _facts(robot: Robot, root: Root, wishes: Wishes) -> RobotFacts:
    if robot.root is None and root == "floating":
        free = Coordinate(name=f"{robot.links[0].name}.root", kind="free")
        robot = replace(robot, links=(replace(robot.links[0], coordinates=(free,)), *robot.links[1:]))
    return of_robot(robot, wishes.omissions)


def of_robot(robot: Robot, dropped: Omissions = NOTHING) -> RobotFacts:
    """The facts of a neutral robot. Args: dropped: what is taken out."""
    robot = replace(robot, links=tuple(_at_zero(link) for link in robot.links))
    at = posed(robot, IDENTITY)
    joints: list[JointFacts] = []
    last: dict[str, str] = {}
    for link in robot.links:
        above = FIXED if link.parent is None else last[link.parent]
        for line in at.lines[link.name]:
            joints.append(_joint(line.coordinate, above, line.axis_W, line.anchor_W, dropped))
            above = line.coordinate.name
        last[link.name] = above
    masses = {}
    for name, group in grouped(robot).items():
        if group.still or last[name] == FIXED:
            continue
        solid = None if group.solid is None else moved(group.solid, at.pose[name])
        assert solid is None or solid.inertia is not None
        masses[last[name]] = MassFacts(
            joint=last[name],
            members=tuple(group.members),
            mass=0.0 if solid is None else solid.mass,
            centre=np.zeros(3) if solid is None else solid.centre,
            inertia=np.zeros((3, 3)) if solid is None or solid.inertia is None else solid.inertia,
        )
    laws = _laws(robot, at, last, dropped)
    shapes: dict[str, tuple[Geometry, ...]] = {}
    for lead, group in grouped(robot).items():
        placed = tuple(Geometry(shape.shape, at.pose[lead] @ shape.X_LG, shape.contact) for shape in group.geometries)
        if placed:
            shapes[last[lead]] = (*shapes.get(last[lead], ()), *placed)
    return RobotFacts(
        source=robot.source,
        joints=tuple(joints),
        masses=masses,
        gravity=robot.gravity,
        laws=laws,
        shapes=shapes,
        touches={} if robot.contacts is None else _touches(robot, last),
        wordless=robot.wordless | ({"touch"} if robot.contacts is None else set()),
    )


def _touches(robot: Robot, last: Mapping[str, str]) -> dict[frozenset[str], Surface]:
    """The laws of what may touch, by the joints that move the two."""
    groups = grouped(robot)
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
        pair = frozenset((last[a], last[b]))
        for law in (surfaces.get(frozenset((x, y))) for x in materials[a] for y in materials[b]):
            if law is not None:
                touches[pair] = stronger(touches.get(pair), law)
    return touches


def _laws(robot: Robot, at: Posed, last: dict[str, str], dropped: Omissions) -> tuple[Law, ...]:
    """Ties, springs and closures with their numbers, all else by its name."""
    compared = [need for need in robot.needs if need.kind not in (*_MERGED, _DRIVEN)]
    kept = [left for need in compared if (left := left_of(need, dropped)) is not None]
    laws = [
        Law(kind="mimic", name=c.name, partners=(c.tie.joint,), ratio=c.tie.ratio, offset=c.tie.offset)
        for link in robot.links
        for c in link.coordinates
        if c.tie is not None and not lets_go(dropped, c)
    ]
    laws += [Law(kind=need.kind, name=name) for need in kept for name in need.names]
    if not dropped.takes("tendon"):
        laws += [Law(kind="tendon", name=_told(cord)) for cord in robot.tendons]
    for closure in robot.closures:
        if closure.kind == "spring":
            values = f"{closure.stiffness:g} N/m, {closure.damping:g} N s/m, rest {closure.rest:g} m"
            laws.append(Law(kind="tendon", name=f"{closure.name} of {values}"))
            continue
        if dropped.takes("equality"):
            continue
        p_A, p_B = (at.pose[link].of(p) for link, p in ((closure.link_A, closure.anchor_A), (closure.link_B, closure.anchor_B)))
        laws.append(
            Law(
                kind="closure",
                name=closure.name,
                partners=(last[closure.link_A], last[closure.link_B]),
                points=((p_A[0], p_A[1], p_A[2]), (p_B[0], p_B[1], p_B[2])),
                whole=closure.kind == "fixed",
            )
        )
    return tuple(laws)


def _told(cord: Cord) -> str:
    """A tendon by its name and numbers."""
    length = " + ".join(f"{arm:g} {name}" for name, arm in cord.arms)
    spring = f"{cord.stiffness:g} N/m, {cord.damping:g} N s/m, rest {cord.rest:g} m"
    return f"{cord.name} of {length}, {spring}, from {cord.lower} to {cord.upper}"


def _at_zero(link: Link) -> Link:
    """The link with every coordinate at 0, and at W's origin where it is free in W."""
    coordinates = tuple(
        replace(c, position=0.0 if c.kind in ("revolute", "prismatic") else None, velocity=0.0, X_start=None)
        for c in link.coordinates
    )
    free = any(c.kind == "free" for c in coordinates)
    return replace(link, coordinates=coordinates, X_PL=IDENTITY if free else link.X_PL)


def _joint(c: Coordinate, parent: str, axis: Array, anchor: Array, dropped: Omissions) -> JointFacts:
    lower, upper = c.lower, c.upper
    if c.needs_range:
        lower, upper = lower or 0.0, upper or 0.0
    return JointFacts(
        name=c.name,
        kind=c.kind,
        parent=parent,
        axis=axis,
        anchor=anchor,
        lower=lower,
        upper=upper,
        damping=c.damping,
        stiffness=c.stiffness,
        rest=c.rest if c.stiffness > 0 else 0.0,
        armature=0.0 if dropped.takes("armature", c.name) else c.armature,
        friction_loss=0.0 if dropped.takes("friction_loss", c.name) else c.friction_loss,
        effort=c.effort,
        speed=c.speed,
        drive=c.servo,
    )
