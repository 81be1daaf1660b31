"""Options that every command which reads a robot takes, and the import that they ask for."""

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
    from plumbline.harness.scene.importers.fidelity import Imported


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


_OPTIONS = (
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
Command = TypeVar("Command", bound=Callable[..., Any])


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
_RUN = (
    click.option("--dt", type=Seconds(1e-9, 1.0), metavar="X", help="The coarsest time step [s] of the ladder [1/240]."),
    click.option("--duration", type=Seconds(1e-6, 1e6), metavar="X", help="How long the scene runs [s] [5]."),
    click.option("--commands", type=_LOG, metavar="LOG", help="Joints follow a CSV or npz: time, knee, hip:torque, ..."),
    click.option("--states", type=_LOG, metavar="LOG", help="A recorded robot to compare with: time and positions of joints."),
    click.option("--interpolate", is_flag=True, help="Join the values of --commands by straight lines; else they are held."),
    click.option("--gains", type=PairOfGains(), metavar="K,D", help="Stiffness and damping of drives that --commands needs."),
    click.option("--budget", type=Seconds(0.0, 1e7), metavar="T", help="How long you wait for it, like 60, 5m, 2h [2m]."),
)


def run_options(command: Command) -> Command:
    """The command with --dt, --duration, --commands, --states, --interpolate, --gains and --budget."""
    for option in reversed(_RUN):
        command = option(command)
    return command


def robot_options(command: Command) -> Command:
    """The command with --drop, --package, --root, --scenario, --start, --convex, --one-friction and --strict."""
    for option in reversed(_OPTIONS):
        command = option(command)
    return command


def wishes_of(options: dict[str, Any]) -> Wishes:
    """What these options wish. Raises: RobotError."""
    return Wishes(
        drop=frozenset(options["drop"]),
        packages=package_roots(tuple(options["packages"])),
        root=options["root"],
        scenario=options["scenario"],
        start=options["start"],
        one_friction=options["one_friction"],
        convex=options["convex"],
        strict=options["strict"],
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
    wishes = replace(wishes_of(options), looks=looks, tell=partial(say, err=True))

    from plumbline.harness.scene.importers.reading import read

    return read(path, wishes)
