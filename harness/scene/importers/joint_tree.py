"""A settled robot as a scene: merged groups are bodies at their centres of mass, coordinates are joints, in W at time 0."""

from collections.abc import Mapping
from dataclasses import dataclass, fields, replace

import numpy as np

from plumbline.harness.intake.error import RobotError, listed
from plumbline.harness.intake.safe_text import quoted
from plumbline.harness.scene import (
    WORLD,
    Ball,
    Body,
    Distance,
    Drive,
    Fixed,
    Joint,
    Limits,
    MomentArm,
    PlacedShape,
    Plane,
    Prismatic,
    Revolute,
    Samples,
    Spring,
    Tendon,
)
from plumbline.harness.scene.importers.companion import Companion, Massless
from plumbline.harness.scene.importers.consequences import Chain, Massive
from plumbline.harness.scene.importers.kinematics import Line, Posed
from plumbline.harness.scene.importers.materials import Laws
from plumbline.harness.scene.importers.merging import Group, StandIns, between_joints, check_inertia, stand_ins
from plumbline.harness.scene.importers.poses import Array, Pose, pose, quaternion, vector
from plumbline.harness.scene.importers.robot import Closure, Coordinate, Cord, Geometry, Robot, symmetric
from plumbline.harness.scene.importers.ties import coupled


@dataclass(frozen=True, slots=True, eq=False)
class Tree:
    """Terms: bodies, joints, tendons: of the scene. massive: what moves, for the mass matrix. body: by lead, the body's name,
    WORLD for what is fixed and has no shape."""

    bodies: tuple[Body, ...]
    joints: tuple[Joint, ...]
    tendons: tuple[Tendon, ...]
    massive: tuple[Massive, ...]
    body: Mapping[str, str]


class _Names:
    """Names that are taken."""

    def __init__(self) -> None:
        self._taken = {WORLD}

    def fresh(self, name: str) -> str:
        """The name, or the first of name_2, name_3 that is free. Raises: RobotError, where none is one of a scene."""
        if not name or len(name) > 180 or not name.isprintable() or name != name.strip():
            raise RobotError(f"name {quoted(name)}: expected 1 to 180 printable characters without blanks at its ends")
        made, count = name, 2
        while made in self._taken:
            made, count = f"{name}_{count}", count + 1
        self._taken.add(made)
        return made


def tree_of(robot: Robot, groups: Mapping[str, Group], at: Posed, laws: Laws, companion: Companion) -> Tree:
    """Bodies and joints of all groups. Raises: RobotError, naming what no body can be."""
    bodies: list[Body] = []
    joints: list[Joint] = []
    massive: list[Massive] = []
    held: dict[str, str] = {}
    called: dict[str, str] = {}
    above: dict[str, Chain | None] = {}
    body_names, joint_names = _Names(), _Names()
    weightless = between_joints(groups)
    for lead, group in groups.items():
        X = at.pose[lead]
        if group.still:
            made = _still(group, X, laws, body_names)
            bodies += made
            held[lead] = made[0].name if made and robot.filter_world else WORLD
            above[lead] = None
            continue
        lines = at.lines[lead]
        before = None if group.parent is None else above[group.parent]
        free = any(line.coordinate.kind == "free" for line in lines)
        chain = above[lead] = Chain(None if free else before, lines)
        parent = WORLD if group.parent is None else held[group.parent]
        between = None if companion.massless is not None or len(lines) < 2 else stand_ins(lines, group.solid, X)
        if between is not None:
            check_inertia(group, _tensor(group))
            group = replace(group, solid=between.rest)
        for k, line in enumerate(lines[:-1]):
            extra = _between(line, k, group, between, companion.massless, body_names)
            bodies.append(extra)
            if not extra.massless:
                massive += _of_between(extra, Chain(before, lines[: k + 1]), own=between is not None)
            joints.append(_joint(line, parent, extra.name, joint_names, robot))
            called[line.coordinate.name] = joints[-1].name
            parent = extra.name
        if lead in weightless and companion.massless is None:
            twist = at.twist[lead]
            body = Body.between(
                body_names.fresh(lead), vector(X.p), q_WB=quaternion(X.R), v_WB=vector(twist.at(X.p)), w_WB=vector(twist.w)
            )
        else:
            body, stated = _body(group, X, at, laws.material[lead], companion.massless, body_names)
            massive.append(_massive(body, chain, stated))
        bodies.append(body)
        held[lead] = body.name
        if not free:
            joints.append(_joint(lines[-1], parent, body.name, joint_names, robot))
            called[lines[-1].coordinate.name] = joints[-1].name
    owner = {link: lead for lead, group in groups.items() for link in group.members}
    joints = coupled(joints, robot, called)
    joints += [_closure(closure, robot, at, owner, held, joint_names) for closure in robot.closures]
    if companion.ground is not None:
        bodies.append(_ground(companion, body_names))
    tendons = tuple(_tendon(cord, called) for cord in robot.tendons)
    return Tree(tuple(bodies), tuple(joints), tendons, tuple(massive), held)


def _ground(companion: Companion, names: _Names) -> Body:
    assert companion.ground is not None
    return Body(
        name=names.fresh("ground"),
        motion="static",
        material=companion.ground.material,
        collision=(PlacedShape(shape=Plane()),),
        p_WB=(0.0, 0.0, companion.ground.height),
    )


def _placed(geometries: tuple[Geometry, ...], X_BG: Pose) -> tuple[PlacedShape, ...]:
    placed = []
    for geometry in geometries:
        X = X_BG @ geometry.X_LG
        placed.append(PlacedShape(shape=geometry.shape, p_BS=vector(X.p), q_BS=quaternion(X.R)))
    return tuple(placed)


def _still(group: Group, X: Pose, laws: Laws, names: _Names) -> list[Body]:
    """Static bodies of a group's shapes, one for each contact key."""
    made = []
    for key in sorted({geometry.contact for geometry in group.geometries}):
        shapes = tuple(geometry for geometry in group.geometries if geometry.contact == key)
        made.append(
            Body(
                name=names.fresh(group.lead.name),
                motion="static",
                material=laws.still[group.lead.name, key],
                collision=_placed(shapes, Pose(np.eye(3), np.zeros(3))),
                p_WB=vector(X.p),
                q_WB=quaternion(X.R),
            )
        )
    return made


def _stated_inertia(massless: Massless) -> float:
    return 0.4 * massless.mass * massless.radius**2


def _between(line: Line, place: int, group: Group, between: StandIns | None, massless: Massless | None, names: _Names) -> Body:
    """What stands behind a coordinate of a link that is not its last one: no mass, where none is stated and none can be shared.

    Raises: RobotError, where only mass could.
    """
    c = line.coordinate
    if between is not None:
        mass, moment, centre = between.mass, between.moment, between.centres[place]
    elif massless is not None:
        mass, moment, centre = massless.mass, _stated_inertia(massless), line.after.of(c.anchor)
    else:
        coordinates = group.lead.coordinates
        if balls := [each.name for each in coordinates if each.kind == "ball"]:
            # Of a planar joint all coordinates are one element.
            where = c.where if len({each.where for each in coordinates}) == 1 else group.lead.where
            raise RobotError(
                f"{where}: several joints {listed([each.name for each in coordinates])} move one body, ball joint "
                f"{listed(balls)} among them, and a body without mass stands between two joints with one coordinate each; the "
                "body's own mass does where the axes of all but the first meet in a point, which these do not; [massless] "
                "mass = ... in the companion file puts bodies of that mass between them, and says what they change"
            )
        mass, moment, centre = 0.0, 0.0, line.after.of(c.anchor)
    return Body(
        name=names.fresh(f"{group.lead.name}.{c.name}"[:170]),
        mass=mass,
        inertia=symmetric(moment * np.eye(3)),
        p_WB=vector(centre),
        q_WB=quaternion(line.after.R),
        v_WB=vector(line.twist.at(centre)),
        w_WB=vector(line.twist.w),
    )


def _tensor(group: Group) -> Array:
    assert group.solid is not None
    assert group.solid.inertia is not None
    return group.solid.inertia


def _of_between(body: Body, lines: Chain, *, own: bool) -> list[Massive]:
    """What a body between two joints adds: all of it, or its moment alone where its mass is the link's own."""
    if not own:
        return [_massive(body, lines, stated=True)]
    whole = _massive(body, lines, stated=False)
    return [replace(whole, inertia_W=np.zeros((3, 3))), replace(whole, mass=0.0, between=True)]


def _body(group: Group, X: Pose, at: Posed, material: str, massless: Massless | None, names: _Names) -> tuple[Body, bool]:
    solid, stated = group.solid, False
    if solid is None:
        if massless is None:
            density = "; density = ... fills its shapes" if group.geometries else ""
            raise RobotError(
                f"{group.lead.where}: link{'s' * (len(group.members) > 1)} {listed(list(group.members))} "
                f"{'have no mass and hang' if len(group.members) > 1 else 'has no mass and hangs'} on a joint that moves; "
                f"[massless] mass = ... in the companion file states one{density}"
            )
        mass, centre, tensor, stated = massless.mass, np.zeros(3), _stated_inertia(massless) * np.eye(3), True
    else:
        assert solid.inertia is not None
        mass, centre, tensor = solid.mass, solid.centre, solid.inertia
        check_inertia(group, tensor)
    com = X.of(centre)
    twist = at.twist[group.lead.name]
    body = Body(
        name=names.fresh(group.lead.name),
        mass=mass,
        inertia=symmetric(tensor),
        collision=_placed(group.geometries, Pose(np.eye(3), -centre)),
        visual=_placed((*group.geometries, *group.drawn), Pose(np.eye(3), -centre)) if group.drawn else None,
        material=material,
        p_WB=vector(com),
        q_WB=quaternion(X.R),
        v_WB=vector(twist.at(com)),
        w_WB=vector(twist.w),
    )
    return body, stated


def _massive(body: Body, lines: Chain, stated: bool) -> Massive:
    R = pose(body.p_WB, body.q_WB).R
    return Massive(body.mass, np.array(body.p_WB), R @ np.array(body.inertia) @ R.T, lines, stated)


def _joint(line: Line, parent: str, child: str, names: _Names, robot: Robot) -> Joint:
    c = line.coordinate
    name, anchor = names.fresh(c.name), vector(line.anchor_W)
    if c.kind == "ball":
        return Ball(name=name, parent=parent, child=child, anchor_W=anchor, collide=robot.collide)
    kind = Revolute if c.kind == "revolute" else Prismatic
    return kind(
        name=name,
        parent=parent,
        child=child,
        anchor_W=anchor,
        axis_W=vector(line.axis_W),
        position=c.reference if c.position is None else c.position,
        limits=_limits(c),
        spring=_spring(c),
        drive=_drive(c),
        effort=Samples(time=(0.0,), target=(c.servo.push,)) if c.servo is not None and c.servo.push else None,
        armature=None if robot.dropped.takes("armature", c.name) else c.armature or None,
        friction_loss=None if robot.dropped.takes("friction_loss", c.name) else c.friction_loss or None,
        speed_limit=c.speed if robot.speed_limits else None,
        collide=robot.collide,
    )


def _tendon(cord: Cord, called: Mapping[str, str]) -> Tendon:
    """Args: called: the joint of each coordinate, by their names."""
    return Tendon(
        name=cord.name,
        arms=tuple(MomentArm(joint=called[name], arm=arm) for name, arm in cord.arms),
        limits=_limits(cord),
        spring=_spring(cord),
        drive=_drive(cord),
    )


def _limits(c: Coordinate | Cord) -> Limits | None:
    return None if c.lower is None and c.upper is None else Limits(lower=c.lower, upper=c.upper)


def _spring(c: Coordinate | Cord) -> Spring | None:
    if c.stiffness == 0 and c.damping == 0:
        return None
    return Spring(stiffness=c.stiffness, damping=c.damping, rest=c.rest if c.stiffness else 0.0)


def _drive(c: Coordinate | Cord) -> Drive | None:
    if c.servo is None:
        return None
    numbers = {field.name: getattr(c.servo, field.name) for field in fields(Drive)}
    return Drive(**numbers | {"feedforward": c.servo.feedforward or None})


def _closure(
    closure: Closure, robot: Robot, at: Posed, owner: Mapping[str, str], held: Mapping[str, str], names: _Names
) -> Joint:
    a, b = held[owner[closure.link_A]], held[owner[closure.link_B]]
    p_A, p_B = at.pose[closure.link_A].of(closure.anchor_A), at.pose[closure.link_B].of(closure.anchor_B)
    if closure.kind == "spring":
        return _line_spring(closure, robot, (a, b), (p_A, p_B), names)
    gap = float(np.linalg.norm(p_A - p_B))
    turned = np.eye(3) if closure.R_AB is None else at.pose[closure.link_A].R @ closure.R_AB @ at.pose[closure.link_B].R.T
    askew = float(np.linalg.norm(turned - np.eye(3))) / np.sqrt(2)
    if gap > LOOSE or askew > LOOSE:
        raise RobotError(
            f"{robot.source}: connection {quoted(closure.name, 80)}: its two sides lie {gap:.3g} m and {askew:.3g} rad "
            "apart at the start, expected at most "
            f"{LOOSE:g} m; start in a pose where the loop is closed ([joints.NAME] position = ..., or keyframe = ...)"
        )
    if a == b:
        raise RobotError(
            f"{robot.source}: connection {quoted(closure.name, 80)} joins {quoted(a, 80)} to itself, expected two bodies"
        )
    if b == WORLD:
        a, b = b, a
    name = names.fresh(closure.name)
    if closure.kind == "fixed":
        return Fixed(name=name, parent=a, child=b, collide=True)
    return Ball(name=name, parent=a, child=b, anchor_W=vector((p_A + p_B) / 2), collide=True)


def _line_spring(closure: Closure, robot: Robot, ends: tuple[str, str], points: tuple[Array, Array], names: _Names) -> Joint:
    """A spring between points of two bodies."""
    (a, b), (p_A, p_B) = ends, points
    if a == b or float(np.linalg.norm(p_A - p_B)) < LOOSE:
        raise RobotError(
            f"{robot.source}: spring {quoted(closure.name, 80)} begins and ends on {quoted(a, 80)} or at one point, "
            "expected two bodies and a distance"
        )
    if b == WORLD:
        a, b, p_A, p_B = b, a, p_B, p_A
    return Distance(
        name=names.fresh(closure.name),
        parent=a,
        child=b,
        anchor_W=vector(p_A),
        child_anchor_W=vector(p_B),
        spring=Spring(stiffness=closure.stiffness, damping=closure.damping, rest=closure.rest),
        collide=True,
    )


LOOSE = 1e-5
"""How far apart the two points of a closed loop may lie at the start [m]: rounding of a file's six digits."""
