"""Our own scene files, which say everything themselves."""

from dataclasses import replace
from pathlib import Path

from harness.intake.documents import named
from harness.intake.import_wishes import Wishes
from harness.intake.refusal import RobotError
from harness.scene.file import load
from harness.scene.importers.companion import Companion
from harness.scene.importers.fidelity import Fidelity
from harness.scene.importers.imported import Imported
from harness.scene.importers.materials import one_friction

__all__ = ["read"]

_OF_A_RUN = ("duration", "look_at", "seed", "one_friction")


def read(path: Path, wishes: Wishes, companion: Companion) -> Imported:
    """A scene file ending in .toml or .json. Raises: SceneError, RobotError."""
    scene = load(path)
    default = Companion()
    for name in Companion.__dataclass_fields__:
        if name not in _OF_A_RUN and getattr(companion, name) != getattr(default, name):
            raise RobotError(
                f"{named(path)}: {name} in its companion file is for robot files; a scene says it itself, "
                f"expected some of {', '.join(_OF_A_RUN)}"
            )
    if wishes.drop or wishes.packages or wishes.root or wishes.scenario or wishes.convex:
        raise RobotError(
            f"{named(path)}: --drop, --package, --root, --scenario and --convex are for robot files; a scene says it itself"
        )
    rows: list[Fidelity] = []
    if wishes.one_friction or companion.one_friction:
        surfaces, rows = one_friction(scene.surfaces)
        scene = replace(scene, surfaces=surfaces)
    return Imported(
        name=path.stem,
        scene=scene,
        source=named(path),
        fidelity=tuple(rows),
        coordinates={joint.name: joint.position for joint in scene.joints if joint.type in ("revolute", "prismatic")},
        links={body.name: body.name for body in scene.bodies},
        duration=companion.duration,
        look_at=companion.look_at,
        seed=companion.seed,
    )
