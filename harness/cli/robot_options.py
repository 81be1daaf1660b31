"""Options that every command which reads a robot takes, the import that they ask for, and what is refused of it."""

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

import click

from plumbline.harness.cli.guard import say
from plumbline.harness.cli.options import Seconds
from plumbline.harness.intake.documents import document
from plumbline.harness.intake.error import RobotError
from plumbline.harness.intake.import_wishes import DROPPABLE, SCENARIOS, STARTS, Omissions, Wishes, package_roots
from plumbline.harness.intake.safe_text import quoted

if TYPE_CHECKING:
    from plumbline.harness.scene import Scene
    from plumbline.harness.scene.importers.imported import Imported
    from plumbline.harness.scene.importers.replay import Log


Command = TypeVar("Command", bound=Callable[..., Any])


class LeftOutKind(click.ParamType[str]):
    """A kind of elements, or those of the joints whose names a pattern meets: armature@root*."""

    name = "omission"

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> str:
        """The text, once it is known to be one. Raises: click.BadParameter."""
        try:
            Omissions.of((str(value),))
        except RobotError as error:
            self.fail(str(error), param, ctx)
        return str(value)


def drop_option(does: str) -> Callable[[Any], Any]:
    """The option `--drop`. Args: does: what it does, to which the kinds are added."""
    kinds = f"{does}: {', '.join(sorted(DROPPABLE))}; KIND@PATTERN of joints alone whose names meet it, like armature@root*."
    return click.option("--drop", "drop", multiple=True, metavar="KIND[@PATTERN]", type=LeftOutKind(), help=kinds)


def _stacked(*options: Callable[[Any], Any]) -> Callable[[Command], Command]:
    """What gives a command all of these options, in this order in its help."""

    def onto(command: Command) -> Command:
        for option in reversed(options):
            command = option(command)
        return command

    return onto


robot_options = _stacked(
    drop_option("Leave out what a scene or an engine has no word for"),
    click.option(
        "--package", "packages", multiple=True, metavar="NAME=DIR", help="Where package://NAME lies; may be repeated."
    ),
    click.option("--root", type=click.Choice(["fixed", "floating"]), help="How the robot's root is held."),
    click.option(
        "--scenario", type=click.Choice(SCENARIOS), help="What happens to the robot where its companion says nothing."
    ),
    click.option(
        "--start", type=click.Choice(STARTS), help="Joints start at zero, amid their range, or at zero but inside it."
    ),
    click.option(
        "--convex", type=click.IntRange(2, 64), help="Take meshes of URDFs and scenes apart into at most so many convex pieces."
    ),
    click.option("--one-friction", is_flag=True, help="Take static friction to be the kinetic one."),
    click.option(
        "--strict", is_flag=True, help="Refuse elements and attributes that the format of a robot file does not have."
    ),
)
NAMES = (
    "--drop, --package, --root, --scenario, --start, --one-friction, --strict, --dt, --duration, --commands, --states, "
    "--interpolate, --gains, --budget"
)
"""All that is for scenes and robots alone."""


class PairOfGains(click.ParamType["tuple[float, float]"]):
    """Stiffness and damping, both 0 or more: 100,5."""

    name = "gains"

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> tuple[float, float]:
        """Both. Raises: click.BadParameter."""
        try:
            stiffness, damping = (float(text) for text in str(value).split(","))
        except ValueError:
            stiffness = damping = -1.0
        if not (0.0 <= stiffness < 1e12 and 0.0 <= damping < 1e12):
            self.fail(f"{quoted(str(value), 60)}, expected STIFFNESS,DAMPING like 100,5", param, ctx)
        return stiffness, damping


_LOG = click.Path(path_type=Path, dir_okay=False)
run_options = _stacked(
    click.option("--dt", type=Seconds(1e-9, 1.0), metavar="X", help="The coarsest time step [s] of the ladder [1/240]."),
    click.option("--duration", type=Seconds(1e-6, 1e6), metavar="X", help="How long the scene runs [s] [5]."),
    click.option("--commands", type=_LOG, metavar="LOG", help="Joints follow a CSV or npz: time, knee, hip:torque, ..."),
    click.option("--states", type=_LOG, metavar="LOG", help="A recorded robot to compare with: time and positions of joints."),
    click.option("--interpolate", is_flag=True, help="Join the values of --commands by straight lines; else they are held."),
    click.option("--gains", type=PairOfGains(), metavar="K,D", help="Stiffness and damping of drives that --commands needs."),
    click.option("--budget", type=Seconds(0.0, 1e7), metavar="T", help="How long you wait for it, like 60, 5m, 2h [2m]."),
)


def is_robot(path: Path) -> bool:
    """Is it a robot file, by its ending?"""
    if path.suffix in {"", ".json", ".toml"}:
        return False

    from plumbline.harness.scene.importers.known import robot_endings

    return path.suffix.lower() in robot_endings()


def is_scene(name: str) -> bool:
    """Is it a scene or robot file? What cannot be read is refused before anything is imported for it. Raises: InputError."""
    path = Path(name)
    if path.suffix not in {".json", ".toml"}:
        return is_robot(path)
    table = document(path)
    return path.suffix == ".json" or "bodies" in table


def imported_from(path: Path, options: dict[str, Any], *, looks: bool = False) -> "Imported":
    """The import of a file under these options. Args: looks: read how it looks too. Raises: RobotError, SceneError."""
    from plumbline.harness.scene.importers.reading import read

    taken = {name: options[name] for name in ("root", "scenario", "start", "one_friction", "convex", "strict")}
    packages, tell = package_roots(tuple(options["packages"])), partial(say, err=True)
    return read(path, Wishes(drop=frozenset(options["drop"]), packages=packages, looks=looks, tell=tell, **taken))


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
    from plumbline.harness.study.foreseen_cost import too_many_steps

    if excess := too_many_steps(imported.duration or DURATION, imported.dt or LADDER[0]):
        raise RobotError(f"{imported.source}: {excess}")


def _replayed(imported: "Imported", options: dict[str, Any]) -> "Imported":
    """The import whose joints follow --commands, for as long as they last unless a duration is said. Raises: RobotError."""
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
