"""Our own scene files, which say everything themselves."""

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

from plumbline.harness.intake.documents import named
from plumbline.harness.intake.error import RobotError, listed
from plumbline.harness.intake.import_wishes import Wishes
from plumbline.harness.intake.safe_text import quoted
from plumbline.harness.scene import Prismatic, Revolute, Samples, Scene
from plumbline.harness.scene.file import load
from plumbline.harness.scene.importers.companion import Companion
from plumbline.harness.scene.importers.decomposition import in_pieces
from plumbline.harness.scene.importers.fidelity import Fidelity
from plumbline.harness.scene.importers.imported import Imported
from plumbline.harness.scene.importers.materials import one_friction
from plumbline.harness.scene.importers.settling import NONE

_OF_A_RUN = ("duration", "dt", "look_at", "seed", "one_friction", "convex", "commands")


def read(path: Path, wishes: Wishes, companion: Companion, commands: Mapping[str, Samples] = NONE) -> Imported:
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
