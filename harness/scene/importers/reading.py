"""From a file of any format to a scene: format by its ending, companion beside it, then merged, posed, joined and told."""

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

import numpy as np

from plumbline.harness.intake.documents import named
from plumbline.harness.intake.error import RobotError, listed
from plumbline.harness.intake.import_wishes import Drop, Omissions, Wishes
from plumbline.harness.intake.safe_text import quoted, readable
from plumbline.harness.scene import (
    EARTH_GRAVITY,
    WORLD,
    Camera,
    DepthCamera,
    PlacedShape,
    Prismatic,
    Revolute,
    Samples,
    Scene,
    Surface,
)
from plumbline.harness.scene.file import load, uncollected
from plumbline.harness.scene.importers import scenarios
from plumbline.harness.scene.importers.companion import Base, Companion, beside, load_companion
from plumbline.harness.scene.importers.consequences import consequences
from plumbline.harness.scene.importers.decomposition import as_polyhedra, in_pieces
from plumbline.harness.scene.importers.fidelity import Fidelity, Imported
from plumbline.harness.scene.importers.files import Folders, packages_above
from plumbline.harness.scene.importers.importer import Reading
from plumbline.harness.scene.importers.joint_tree import Tree, tree_of
from plumbline.harness.scene.importers.kinematics import Posed, Twist, posed
from plumbline.harness.scene.importers.known import OWN_ENDINGS, importer_of, robot_endings
from plumbline.harness.scene.importers.looks import coloured, drawn_bodies, looks_of, mounted
from plumbline.harness.scene.importers.materials import Laws, laws_of, one_friction
from plumbline.harness.scene.importers.merging import Group, check_masses, grouped
from plumbline.harness.scene.importers.poses import IDENTITY, Array, Pose, pose, turn
from plumbline.harness.scene.importers.replay import load_commands
from plumbline.harness.scene.importers.robot import Robot
from plumbline.harness.scene.importers.scenarios import poses_of, swept
from plumbline.harness.scene.importers.settling import NONE, followed, rooted, settled, undropped, wordless_kinds
from plumbline.harness.scene.importers.ties import tied, untied
from plumbline.harness.scene.importers.units import scaled, suspected

_OF_A_RUN = ("duration", "dt", "look_at", "seed", "one_friction", "convex", "commands")


def _own(path: Path, wishes: Wishes, companion: Companion, commands: Mapping[str, Samples] = NONE) -> Imported:
    """A scene file ending in .toml or .json. Args: commands: targets over time by joint. Raises: SceneError, RobotError."""
    scene = load(path)
    default = Companion()
    for name in Companion.__dataclass_fields__:
        if name not in _OF_A_RUN and getattr(companion, name) != getattr(default, name):
            raise RobotError(
                f"{named(path)}: {name} in its companion file is for robot files; a scene says it itself, "
                f"expected some of {', '.join(_OF_A_RUN)}"
            )
    if wishes.drop or wishes.packages or wishes.root or wishes.scenario:
        raise RobotError(f"{named(path)}: --drop, --package, --root and --scenario are for robot files; a scene says it itself")
    rows: list[Fidelity] = []
    if wishes.one_friction or companion.one_friction:
        surfaces, rows = one_friction(scene.surfaces)
        scene = replace(scene, surfaces=surfaces)
    if wishes.convex is not None:
        scene, more = in_pieces(scene, wishes.convex, named(path), wishes.tell)
        rows = [*rows, *more]
    scene = commanded(scene, commands, f"{named(path)}: {companion.commands}")
    return Imported(
        name=path.stem,
        scene=scene,
        source=named(path),
        fidelity=tuple(rows),
        coordinates={joint.name: joint.position for joint in scene.joints if joint.type in ("revolute", "prismatic")},
        links={body.name: body.name for body in scene.bodies},
        duration=companion.duration,
        dt=companion.dt,
        look_at=companion.look_at,
        seed=companion.seed,
    )


def commanded(scene: Scene, commands: Mapping[str, Samples], where: str) -> Scene:
    """The scene whose drives follow these targets. Raises: RobotError, for a joint that has no drive with a stiffness."""
    driven = [
        joint.name
        for joint in scene.joints
        if isinstance(joint, Revolute | Prismatic) and joint.drive is not None and joint.drive.stiffness > 0
    ]
    for name in commands:
        if name not in driven:
            raise RobotError(
                f"{where}: column {quoted(name, 80)} is no joint with a drive that follows, expected one of "
                f"{listed(driven, 12) or 'none'}"
            )
    joints = tuple(
        replace(joint, drive=replace(joint.drive, motion=commands[joint.name]))
        if joint.name in commands and isinstance(joint, Revolute | Prismatic) and joint.drive is not None
        else joint
        for joint in scene.joints
    )
    return replace(scene, joints=joints)


@uncollected()
def read(path: Path, wishes: Wishes | None = None, companion: Companion | None = None) -> Imported:
    """The scene of one of our own files or of a robot file, with what became of each element.

    Args:
        wishes: of the command line. companion: what the file does not say; the file `NAME.plumb.toml` beside it if None.
    Raises:
        RobotError, SceneError: naming file, line, element, attribute, value and what mends it.
    """
    wishes = wishes or Wishes()
    if path.suffix.lower() not in (*OWN_ENDINGS, *robot_endings()):
        raise RobotError(
            f"{named(path)}: ending {quoted(path.suffix)}, expected one of {', '.join((*OWN_ENDINGS, *robot_endings()))}"
        )
    beside_it, wishes = _wished(path, wishes, companion)
    commands = commands_of(path, beside_it)
    if path.suffix.lower() in OWN_ENDINGS:
        return _own(path, wishes, beside_it, commands)
    robot = _robot(path, beside_it, wishes)
    return imported(robot, beside_it, wishes, commands)


def robot_of(path: Path, wishes: Wishes | None = None) -> tuple[Robot, Companion, Wishes]:
    """The robot that a robot file states, before it is made a scene, in metres and kilograms.

    Its companion and all that is wished, the companion's wishes among them, come with it. Raises: RobotError.
    """
    importer_of(path)
    companion, wishes = _wished(path, wishes or Wishes(), None)
    robot = _robot(path, companion, wishes)
    return robot if companion.units is None else scaled(robot, companion.units), companion, wishes


def commands_of(path: Path, companion: Companion) -> Mapping[str, Samples]:
    """Targets over time by joint, of the file that a companion names, beside the scene or robot. Raises: RobotError."""
    if companion.commands is None:
        return NONE
    where = f"{named(beside(path))}: commands"
    file = Folders(path.parent, {}).found(companion.commands, where)
    if file is None:
        raise RobotError(f"{where} is {quoted(companion.commands)}: there is no such file; expected a CSV file beside it")
    return load_commands(path.parent / companion.commands)


def _wished(path: Path, wishes: Wishes, companion: Companion | None) -> tuple[Companion, Wishes]:
    """What stands beside the file, and what is wished there and on the command line together."""
    beside_it = companion if companion is not None else load_companion(beside(path))
    Omissions.of(beside_it.drop, f"{named(beside(path))}: drop")
    return beside_it, replace(
        wishes,
        drop=wishes.drop | frozenset(beside_it.drop),
        packages={**_inside(path, beside_it), **wishes.packages},
        one_friction=wishes.one_friction or beside_it.one_friction,
        convex=wishes.convex or beside_it.convex,
    )


def _inside(path: Path, companion: Companion) -> dict[str, Path]:
    """The packages that a companion names, which lie beside the robot: only the command line leads elsewhere."""
    roots = {}
    for name, folder in companion.packages.items():
        root = (path.parent / folder).resolve()
        if not root.is_relative_to(path.parent.resolve()) or not root.is_dir():
            raise RobotError(
                f"{named(beside(path))}: packages > {quoted(name, 80)} is {quoted(folder)}, expected a folder beside "
                "the robot; --package NAME=DIR may name any"
            )
        roots[name] = root
    return roots


def _robot(path: Path, companion: Companion, wishes: Wishes) -> Robot:
    reading = Reading(
        folders=Folders(path.parent, {**packages_above(path), **wishes.packages}),
        companion=companion,
        convex=wishes.convex,
        strict=wishes.strict,
        tell=wishes.tell,
    )
    return importer_of(path).read(path, reading)


def imported(robot: Robot, companion: Companion, wishes: Wishes, commands: Mapping[str, Samples] = NONE) -> Imported:
    """A robot of any format with its user's wishes, as a scene. Args: commands: targets over time by joint.

    Raises: RobotError.
    """
    dropped = wishes.omissions
    whole, unknown = _undropped(robot, companion, wishes, commands)
    if companion.ellipsoids == "polyhedra":
        robot = as_polyhedra(robot)
    robot = robot.told(unknown, suspected(robot, companion.units))
    if dropped.takes("tendon"):
        slack = Fidelity.left_out("tendon", [cord.name for cord in robot.tendons], "tendon was dropped by the user")
        robot = replace(robot, tendons=()).told(slack)
    if companion.units is not None:
        robot = scaled(robot, companion.units)
    if companion.base is not None and robot.gravity is not None:
        raise RobotError(f"{robot.source}: base is for files that do not say where their root is; this one does")
    companion, wishes = scenarios.rooted_for(wishes.scenario, robot, companion, wishes)
    robot = undropped(replace(rooted(robot, companion, wishes), dropped=dropped))
    start = wishes.start or companion.start or ("inside" if wishes.scenario else "zero")
    robot = settled(untied(robot), replace(companion, start=start), commands)
    if wishes.scenario in ("drop", "swing"):
        robot = scenarios.unpowered(robot)
    if wishes.scenario == "swing":
        robot = scenarios.swung(robot)
    robot = tied(robot)
    if wishes.scenario == "drop":
        companion = scenarios.grounded(companion)
    if wishes.scenario in ("hold", "sweep"):
        idle, holds = scenarios.unpowered(robot), wishes.scenario == "hold"
        poses = [_made(variant, companion).tree.massive for variant in ([idle] if holds else poses_of(idle))]
        robot = (scenarios.held_by_drives if holds else swept)(robot, poses)
    made = _made(followed(robot), companion)
    rows = [*robot.rows, *_counted(robot, made), *made.laws.rows, *consequences(made.tree.massive, dropped)]
    surfaces = made.laws.surfaces
    if wishes.one_friction:
        surfaces, more = one_friction(surfaces)
        rows += more
    links = {link: made.tree.body[lead] for lead, group in made.groups.items() for link in group.members}
    scene = _scene(robot, companion, made, surfaces, links)
    looks, seen = _looks(robot, made, scene, links, wishes)
    rows = [*(row for row in rows if not seen or row.element != "visual"), *seen]
    if looks and any(isinstance(sensor, Camera | DepthCamera) for sensor in scene.sensors):
        scene = replace(scene, bodies=drawn_bodies(scene.bodies, looks))
    if wishes.scenario == "drop":
        scene = scenarios.lifted(scene, made.tree.bodies[-1].name, robot.source)
    return Imported(
        name=robot.name,
        scene=scene,
        source=robot.source,
        fidelity=tuple(rows),
        coordinates={
            c.name: c.reference if c.position is None else c.position
            for c in robot.coordinates()
            if c.kind in ("revolute", "prismatic")
        },
        links=links,
        looks=looks,
        dropped=dropped.texts,
        undropped=None if whole == scene else whole,
        duration=companion.duration,
        dt=companion.dt,
        look_at=companion.look_at,
        seed=companion.seed,
    )


_WORDED: frozenset[Drop] = frozenset(("armature", "equality", "friction_loss", "mimic", "self_collision", "tendon"))
"""What may be dropped although a scene has words for it, as far as joints and ties have it."""


def _undropped(
    robot: Robot, companion: Companion, wishes: Wishes, commands: Mapping[str, Samples]
) -> tuple[Scene | None, list[Fidelity]]:
    """The scene as it would be without what the user drops of `_WORDED`, and a row that says why where there is none."""
    dropped = wishes.omissions
    back = (dropped.kinds & _WORDED) - wordless_kinds(robot)
    if not back:
        return None, []
    remaining = frozenset(dropped.restored(back).texts)
    try:
        return imported(robot, companion, replace(wishes, drop=remaining, looks=False, tell=None), commands).scene, []
    except RobotError as error:
        kinds = listed(sorted(back))
        why = f"what that changes is not measured, since it cannot be read with them: {error}"
        return None, Fidelity.left_out("drop", kinds, why)


class _Made:
    """Terms: groups, tree, laws, at: of one robot."""

    def __init__(self, groups: dict[str, Group], at: Posed, laws: Laws, tree: Tree) -> None:
        self.groups, self.at, self.laws, self.tree = groups, at, laws, tree

    @property
    def where(self) -> dict[str, Pose]:
        """The pose in W of each link."""
        return {link: self.at.pose[lead] @ X for lead, group in self.groups.items() for link, X in group.members.items()}


def _made(robot: Robot, companion: Companion) -> _Made:
    base, twist = _base(companion.base)
    groups, at = grouped(robot), posed(robot, base, twist)
    check_masses(groups)
    laws = laws_of(robot, groups, companion)
    return _Made(groups, at, laws, tree_of(robot, groups, at, laws, companion))


def _base(base: Base | None) -> tuple[Pose, Twist]:
    if base is None:
        return IDENTITY, Twist(np.zeros(3), np.zeros(3))
    p = np.array(base.position)
    if base.rpy is not None:
        x, y, z = (turn(axis, angle) for axis, angle in zip(np.eye(3), base.rpy, strict=True))
        X = Pose(z @ y @ x, p)
    else:
        X = pose(p, base.orientation or (1.0, 0.0, 0.0, 0.0))
    w: Array = np.array(base.angular_velocity)
    return X, Twist(w, np.array(base.velocity) - np.cross(w, p))


def _scene(robot: Robot, companion: Companion, made: _Made, surfaces: tuple[Surface, ...], links: Mapping[str, str]) -> Scene:
    gravity = companion.gravity or robot.gravity or EARTH_GRAVITY
    if not made.tree.bodies:
        raise RobotError(
            f"{robot.source}: nothing moves and nothing can be touched: the root is fixed, no joint moves, no shape is left; "
            "--root floating lets it move"
        )
    sensors = mounted((*robot.sensors, *companion.sensors), links, made.where, made.tree.bodies, robot.source)
    try:
        return Scene(
            bodies=coloured(made.tree.bodies, robot.links, links),
            sensors=sensors,
            joints=made.tree.joints,
            tendons=made.tree.tendons or None,
            surfaces=surfaces,
            gravity=gravity,
            apart=_apart(made),
        )
    except ValueError as error:
        raise RobotError(f"{robot.source}: {readable(str(error).removeprefix('scene: '), 600)}") from None


def _looks(
    robot: Robot, made: _Made, scene: Scene, links: Mapping[str, str], wishes: Wishes
) -> tuple[Mapping[str, tuple[PlacedShape, ...]], tuple[Fidelity, ...]]:
    """What is drawn of each body, where that is asked for or a camera looks on; and what is to be said of it."""
    seen = any(isinstance(sensor, Camera | DepthCamera) for sensor in scene.sensors)
    if not (wishes.looks or seen) or not any(link.looks for link in robot.links):
        return {}, ()
    drawn = looks_of(robot.links, links, made.where, scene.bodies)
    return drawn.shapes, drawn.rows


def _apart(made: _Made) -> tuple[tuple[str, str], ...]:
    """The pairs that pass through each other, of materials that there are."""
    used = {body.material for body in made.tree.bodies}
    return tuple(pair for pair in made.laws.apart if used.issuperset(pair))


def _counted(robot: Robot, made: _Made) -> list[Fidelity]:
    """What is carried over as it is: links, joints, and what was merged."""
    links = [link.name for link in robot.links]
    merged = [name for group in made.groups.values() for name in list(group.members)[1:]]
    joints = [c.name for c in robot.coordinates() if c.kind != "free"]
    rows = []
    if len(links) > len(merged):
        alone = [name for name in links if name not in set(merged) and (name != WORLD or made.groups[name].geometries)]
        weightless = {body.name for body in made.tree.bodies if body.massless}
        for becomes, without in (("body", False), ("a body without mass between two joints", True)):
            rows += Fidelity.exact("link", [name for name in alone if (made.tree.body[name] in weightless) == without], becomes)
    rows += Fidelity.exact("link", merged, "merged with what it is fixed to")
    rows += Fidelity.exact("joint", joints, "joint")
    return rows
