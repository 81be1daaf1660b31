"""A robot and what its user says of it: root, start, ranges, drives; what is neither expressed nor dropped is refused."""

import shlex
from collections.abc import Iterable, Mapping
from dataclasses import replace
from types import MappingProxyType

from plumbline.harness.intake.error import RobotError, listed
from plumbline.harness.intake.import_wishes import DROPPABLE, Drop, Omissions, Wishes
from plumbline.harness.intake.near_miss import did_you_mean
from plumbline.harness.intake.safe_text import quoted
from plumbline.harness.scene import Motion, Samples
from plumbline.harness.scene.importers.companion import Companion, JointWish
from plumbline.harness.scene.importers.fidelity import Fidelity
from plumbline.harness.scene.importers.robot import Coordinate, Need, Robot, Servo

NONE: Mapping[str, Samples] = MappingProxyType({})
_NO_WISH = JointWish()


def valid_name(given: Iterable[str], valid: Iterable[str], what: str, source: str) -> None:
    """Refuse a name that a robot does not have, with those that it has. Raises: RobotError."""
    known = list(valid)
    for name in given:
        if name not in known:
            hint = did_you_mean(name, known, "'{}'")
            raise RobotError(
                f"{source}: {what} {quoted(name, 80)} is not of the robot, expected one of {listed(known, 12) or 'none'}{hint}"
            )


def rooted(robot: Robot, companion: Companion, wishes: Wishes) -> Robot:
    """The robot with its root held as the user says, or as alone is possible; it has to be said where both are.

    Raises: RobotError.
    """
    root, rows = wishes.root or companion.root or robot.root, list[Fidelity]()
    name = robot.links[0].name
    if root is None and companion.massless is None and not _weighs(robot):
        root = "fixed"
        why = "it has no mass, so that nothing else is possible"
        rows += Fidelity.exact("root", name, "fixed", consequence=why)
        if wishes.tell is not None:
            wishes.tell(f"{robot.source}: root {quoted(name, 80)} is held fixed: {why}")
    if root is None:
        run = f"plumbline run {shlex.quote(robot.source)} --root"
        raise RobotError(
            f"{robot.source}: a file of this kind does not say how its root {quoted(name, 80)} is held, and an "
            'arm looks like a quadruped; --root fixed or --root floating says it, or root = "fixed" in the companion file:\n'
            f"  {run} fixed\n  {run} floating"
        )
    if robot.root is not None and root != robot.root:
        raise RobotError(f"{robot.source}: root is {root!r}, but the file says {robot.root!r}; expected no other")
    if root == "floating" and robot.root is None:
        first = replace(robot.links[0], coordinates=(Coordinate(name=f"{name}.root", kind="free"),))
        robot = replace(robot, links=(first, *robot.links[1:]))
    return replace(robot, root=root).told(rows)


def _weighs(robot: Robot) -> bool:
    """Has the root any mass, with all that is fixed to it?"""
    fixed = {robot.links[0].name}
    for link in robot.links[1:]:
        if not link.coordinates and link.parent in fixed:
            fixed.add(link.name)
    return any(link.solid is not None and link.solid.mass > 0 for link in robot.links if link.name in fixed)


def undropped(robot: Robot) -> Robot:
    """The robot with rows for what the user leaves out.

    Raises: RobotError, naming all that has no word in a scene and is not dropped, and a pattern that no joint meets.
    """
    robot.dropped.check((c.name for c in robot.coordinates()), robot.source)
    needs = (*robot.needs, *_of_coordinates(robot))
    open_needs = [left for need in needs if (left := left_of(need, robot.dropped)) is not None]
    if open_needs:
        lines = [
            f"{robot.source}: {need.element} {listed(need.names)}: {_said(need)}: a scene has no word for "
            f"{DROPPABLE[need.kind]}; --drop {need.kind} leaves it out, and says so"
            for need in open_needs
        ]
        raise RobotError("\n".join(lines))
    return robot.told(
        *(
            Fidelity.left_out(
                need.element,
                need.names,
                f"{need.kind.replace('_', ' ')} was dropped by the user{': ' + need.size if need.size else ''}",
            )
            for need in needs
        )
    )


def left_of(need: Need, dropped: Omissions) -> Need | None:
    """What of a need is not left out; None for nothing."""
    joints = need.names if need.element == "joint" else ()
    names = tuple(name for name in need.names if not dropped.takes(need.kind, name if name in joints else None))
    return replace(need, names=names) if names else None


def wordless_kinds(robot: Robot) -> frozenset[str]:
    """The kinds of those elements of the robot that a scene has no word for."""
    return frozenset(need.kind for need in (*robot.needs, *_of_coordinates(robot)))


def _said(need: Need) -> str:
    return f"{need.kind} {need.size}".replace("_", " ").strip()


def _of_coordinates(robot: Robot) -> list[Need]:
    """Rotors and dry friction of balls and free joints, which no scene has."""
    needs = list[Need]()
    coordinates = [c for c in robot.coordinates() if c.kind in ("ball", "free")]
    kinds: tuple[tuple[Drop, str], ...] = (("armature", "kg m2 or kg"), ("friction_loss", "N m or N"))
    for kind, unit in kinds:
        having = [c for c in coordinates if getattr(c, kind) > 0]
        most = max((getattr(c, kind) for c in having), default=0.0)
        needs += Need.of(kind, "joint", (c.name for c in having), f"of up to {most:.3g} {unit}")
    return needs


def settled(robot: Robot, companion: Companion, commands: Mapping[str, Samples] = NONE) -> Robot:
    """The robot with the companion's start, ranges and drives in its coordinates.

    Args: commands: targets over time by joint, of its file of commands. Raises: RobotError.
    """
    scalars = [c.name for c in robot.coordinates() if c.kind in ("revolute", "prismatic")]
    valid_name(companion.joints, scalars, "joint", robot.source)
    valid_name(commands, scalars, f"{companion.commands}: column", robot.source)
    for name in commands:
        if (wish := companion.joints.get(name)) is not None and (wish.motion is not None or wish.target is not None):
            raise RobotError(
                f"{robot.source}: joint {quoted(name, 80)} has a column in {companion.commands} and a "
                f"{'motion' if wish.motion is not None else 'target'} in the companion file, expected one of them"
            )
    known = [link.name for link in robot.links]
    valid_name(companion.materials, known, "material of a link", robot.source)
    valid_name(companion.look_at, [*known, *scalars], "look_at", robot.source)
    rows: list[Fidelity] = []
    links = tuple(
        replace(
            link,
            coordinates=tuple(_coordinate(c, companion, commands.get(c.name), rows) for c in link.coordinates),
            geometries=tuple(replace(g, contact=companion.materials[link.name]) for g in link.geometries)
            if link.name in companion.materials
            else link.geometries,
        )
        for link in robot.links
    )
    settled_robot = replace(robot, links=links, speed_limits=companion.speed_limits)
    return settled_robot.told(rows, _bounds(settled_robot))


def _coordinate(c: Coordinate, companion: Companion, samples: Samples | None, rows: list[Fidelity]) -> Coordinate:
    if c.kind not in ("revolute", "prismatic"):
        return c
    wish = companion.joints.get(c.name, _NO_WISH)
    if wish.limits == "none":
        c = replace(c, lower=None, upper=None, needs_range=False)
    elif wish.limits is not None:
        lower, upper = wish.limits
        if lower > upper:
            raise RobotError(f"joints > {quoted(c.name, 80)} > limits: [{lower:g}, {upper:g}], expected lower <= upper")
        c = replace(c, lower=lower, upper=upper, needs_range=False)
    if c.needs_range:
        raise RobotError(
            f"{c.where}: a {c.kind} joint without lower and upper, which the format reads as 0 to 0: locked; "
            f'[joints.{quoted(c.name, 80)}] limits = [lower, upper] in the companion file says what is meant, limits = "none" '
            "leaves it open"
        )
    if c.tie is not None and wish.position is not None:
        raise RobotError(
            f"joints > {quoted(c.name, 80)} > position: the joint follows {quoted(c.tie.joint, 80)}, which says where it starts"
        )
    position = _start(c, wish, companion)
    if wish.position is None and companion.start == "inside":
        position = _inside(c, position, rows)
    c = replace(c, position=position, velocity=wish.velocity or c.velocity)
    _outside(c, rows)
    servo = _servo(c, wish, companion, wish.motion if samples is None else samples)
    return c if servo is c.servo else replace(c, servo=servo)


def _start(c: Coordinate, wish: JointWish, companion: Companion) -> float:
    if wish.position is not None:
        return wish.position
    if companion.start == "middle" and c.lower is not None and c.upper is not None:
        return (c.lower + c.upper) / 2
    return c.reference if c.position is None else c.position


def _inside(c: Coordinate, position: float, rows: list[Fidelity]) -> float:
    """The position, or the bound of its range that is nearest to it, with a row that says so."""
    lower, upper = (position if bound is None else bound for bound in (c.lower, c.upper))
    nearest = min(max(position, lower), upper)
    if nearest != position:
        rows += Fidelity.told(
            "start at the bound", c.name, abs(nearest - position), nearest=nearest, unit="rad" if c.kind == "revolute" else "m"
        )
    return nearest


def _outside(c: Coordinate, rows: list[Fidelity]) -> None:
    low, high = c.lower, c.upper
    assert c.position is not None
    beyond = max(low - c.position if low is not None else 0.0, c.position - high if high is not None else 0.0)
    if beyond > 0:
        rows += Fidelity.told("start outside", c.name, beyond, position=c.position, unit="rad" if c.kind == "revolute" else "m")


def _servo(c: Coordinate, wish: JointWish, companion: Companion, motion: Motion | None) -> Servo | None:
    asked = (wish.stiffness, wish.damping, wish.target, wish.feedforward)
    drives = companion.drives
    if (drives is None or c.tie is not None) and all(value is None for value in asked) and motion is None:
        return c.servo
    base = c.servo or Servo()
    general = (base.stiffness, base.damping) if drives is None else (drives.stiffness, drives.damping)
    stiffness = general[0] if wish.stiffness is None else wish.stiffness
    damping = general[1] if wish.damping is None else wish.damping
    # Bounds that are not alike both ways are those about a push; a limit of the user's is alike.
    push = base.push if wish.limit is None else 0.0
    feedforward = (base.feedforward + base.push if wish.feedforward is None else wish.feedforward) - push
    if stiffness == 0 and damping == 0 and feedforward == 0 and push == 0 and motion is None:
        return None
    target = wish.target if wish.target is not None else (base.target if c.servo is not None else c.position or 0.0)
    limit = wish.limit or base.limit or c.effort
    return Servo(
        stiffness=stiffness,
        damping=damping,
        target=target,
        target_velocity=wish.target_velocity,
        limit=limit,
        motion=motion or base.motion,
        feedforward=feedforward,
        push=push,
    )


def followed(robot: Robot) -> Robot:
    """The robot, each of whose moving targets has a drive that follows it. Raises: RobotError."""
    for c in robot.coordinates():
        if c.servo is not None and c.servo.motion is not None and c.servo.stiffness == 0:
            raise RobotError(
                f"{robot.source}: joint {quoted(c.name, 80)}: its target moves, and it has no drive that follows; "
                "[drives] stiffness = ... in the companion file states one, --scenario hold makes one"
            )
    return robot


def _bounds(robot: Robot) -> list[Fidelity]:
    """What is said of efforts and speeds."""
    coordinates = list(robot.coordinates())
    limited = [c for c in coordinates if c.effort is not None]
    swift = {c.name: c.speed for c in coordinates if c.speed is not None}
    rows = Fidelity.exact("effort", [c.name for c in limited if c.servo is not None], "limit of the drive")
    idle = [c.name for c in limited if c.servo is None]
    rows += Fidelity.left_out("effort", idle, "bounds a motor, and these joints have no drive")
    least = {"value": min(swift.values(), default=None), "unit": "rad/s or m/s"}
    if robot.speed_limits:
        words = "a hard bound of the rate; MuJoCo and Bullet have none; the least is"
        rows += Fidelity.exact("velocity limit", list(swift), "speed_limit", consequence=words, **least)
    else:
        words = "not a law of the scene unless the companion says speed_limits = true; the least bound is"
        rows += Fidelity.left_out("velocity limit", list(swift), words, **least)
    locked = [c.name for c in coordinates if c.lower is not None and c.lower == c.upper]
    rows += Fidelity.exact("limit", locked, "a range of one value", consequence="the joint is locked by its limits")
    return rows
