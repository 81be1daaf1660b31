"""The protocol of an importer: it turns a file of one format into a robot, and is found by its presence."""

from collections.abc import Callable
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, cast

if TYPE_CHECKING:
    from plumbline.harness.scene.importers.companion import Companion
    from plumbline.harness.scene.importers.files import Folders
    from plumbline.harness.scene.importers.robot import Robot


@dataclass(frozen=True, slots=True, kw_only=True)
class Reading:
    """What an importer is handed beside the path.

    Terms:
        folders: where references may lead; they are followed through it alone. companion: what the file beside the robot says.
        convex: the most convex pieces that a mesh is taken apart into; None for its hull. strict: is every word refused that
        the format does not have? tell: is told of what takes long, and of what is left out.
    """

    folders: "Folders"
    companion: "Companion"
    convex: int | None = None
    strict: bool = False
    tell: Callable[[str], object] | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class Importer:
    """One format.

    Terms:
        name: unique, like its file or entry point. title: for people. endings: of its files, lower case, each with its dot; an
        ending belongs to one importer. read: all that a file says, in metres and kilograms unless its companion's units mend
        that; raises RobotError, naming file, line, element and value.
    """

    name: str
    title: str
    endings: tuple[str, ...]
    read: Callable[[Path, Reading], "Robot"]


def late(name: str) -> Callable[[Path, Reading], "Robot"]:
    """The `read` of a module of this folder, imported when it is called: endings are asked for more often than robots."""
    return lambda path, reading: cast("Robot", import_module(f"plumbline.harness.scene.importers.{name}").read(path, reading))
