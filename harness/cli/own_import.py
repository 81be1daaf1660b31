"""Between a robot file and a run of it: the import, kept in the run folder, and what is refused before anything runs."""

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from plumbline.harness.cli.guard import say
from plumbline.harness.cli.robot_options import imported_from, is_robot

if TYPE_CHECKING:
    from plumbline.harness.scene import Scene
    from plumbline.harness.scene.importers.fidelity import Imported
    from plumbline.harness.scene.importers.replay import Log


SAME_START = 1e-6

"""Radians or metres: a log that begins so near the file's start has it."""


def scene_to_run(name: str, folder: Path, options: dict[str, Any]) -> str:
    """The path of the scene file that is run: a file of our own as it is, another format's import in the run folder.

    Raises: RobotError, SceneError, OSError.
    """
    path = Path(name)
    asked = any(options.values())
    if not is_robot(path) and not asked:
        return name

    from plumbline.harness.scene.importers.replay import read_log
    from plumbline.harness.store.imported_scenes import keep

    imported = imported_from(path, options, looks=True)
    of_run = {key: options[key] for key in ("dt", "duration") if options.get(key) is not None}
    imported = replace(imported, **of_run)
    log = options.get("states")
    states = None if log is None else read_log(log)
    if states is not None:
        imported = _from_its_pose(imported, states)
    if options.get("commands") or options.get("interpolate") or options.get("gains"):
        imported = _replayed(imported, options)
    refuse_too_long(imported)
    counts = {word: sum(row.outcome == word for row in imported.fidelity) for word in ("exact", "approximated", "left_out")}
    summary = ", ".join(f"{count} kinds of elements {word.replace('_', ' ')}" for word, count in counts.items())
    say(f"{imported.source}: {summary}; show --table fidelity lists them", err=True)
    for row in imported.fidelity:
        if row.element == "start" and row.outcome == "exact":
            say(f"joint '{row.name}' starts at {row.becomes}: {row.consequence} {row.value:.3g} {row.unit}", err=True)
    if imported.dropped:
        say(f"dropped by the user: {', '.join(imported.dropped)}", err=True)
    return str(keep(folder, imported, states))


def refuse_too_long(imported: "Imported") -> None:
    """Nothing is kept or run of what takes more steps than are allowed. Raises: RobotError."""
    from plumbline.harness.case.scene_file import DURATION, LADDER
    from plumbline.harness.intake.error import RobotError
    from plumbline.harness.study.foreseen_cost import too_many_steps

    if excess := too_many_steps(imported.duration or DURATION, imported.dt or LADDER[0]):
        raise RobotError(f"{imported.source}: {excess}")


def _replayed(imported: "Imported", options: "dict[str, Any]") -> "Imported":
    """The import whose joints follow --commands, for as long as they last unless a duration is said. Raises: RobotError."""
    from plumbline.harness.intake.error import RobotError
    from plumbline.harness.scene.importers.replay import Gains, read_log, replayed

    if options["commands"] is None:
        raise RobotError("--interpolate and --gains are about --commands, which is not given")
    log = read_log(options["commands"])
    duration = imported.duration or max(log.time[-1] - log.time[0], log.time[1] - log.time[0] if len(log.time) > 1 else 1.0)
    gains = None if options["gains"] is None else Gains(stiffness=options["gains"][0], damping=options["gains"][1])

    def under(scene: "Scene", tell: Callable[[str], object]) -> "Scene":
        return replayed(scene, log, duration=duration, gains=gains, joined=options["interpolate"], tell=tell)

    undropped = None if imported.undropped is None else under(imported.undropped, lambda _: None)
    scene = under(imported.scene, partial(say, err=True))
    return replace(imported, scene=scene, undropped=undropped, duration=duration)


def _from_its_pose(imported: "Imported", log: "Log") -> "Imported":
    """The import with its joints where a recorded robot has them first, which is said. Raises: RobotError."""
    from plumbline.harness.scene import Prismatic, Revolute
    from plumbline.harness.scene.importers.replay import recorded
    from plumbline.harness.scene.importers.start_pose import started_at

    firsts = {name: values[0] for name, values in recorded(imported.scene, log).items()}
    stood = {joint.name: joint.position for joint in imported.scene.joints if isinstance(joint, Prismatic | Revolute)}
    elsewhere = {name: first for name, first in firsts.items() if abs(first - stood[name]) > SAME_START}
    if not elsewhere:
        return imported
    words = ", ".join(f"{name} at {first:.4g} in place of {stood[name]:.4g}" for name, first in elsewhere.items())
    say(f"{log.source}: joints start where the recorded robot does: {words}", err=True)
    undropped = None if imported.undropped is None else started_at(imported.undropped, elsewhere, log.source)
    scene = started_at(imported.scene, elsewhere, log.source)
    coordinates = {name: elsewhere.get(name, value) for name, value in imported.coordinates.items()}
    return replace(imported, scene=scene, undropped=undropped, coordinates=coordinates)
