"""Which robots the zoo has: those of `mujoco-menagerie`, and those that packages listed in `packages.toml` hold themselves.

A package is read where it is installed and never imported, but for the menagerie's own, which knows where its files lie: in its
cache, in a checkout that MENAGERIE_ROOT names, or with their publisher, from whom it fetches them when they are asked for.
"""

import importlib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from importlib.metadata import Distribution, PackageNotFoundError, distribution
from pathlib import Path
from typing import Annotated, Any

from pydantic import Field, TypeAdapter
from pydantic.dataclasses import dataclass as validated

from plumbline.harness.intake.documents import document
from plumbline.harness.intake.error import PlumblineError
from plumbline.harness.intake.safe_text import quoted, readable
from plumbline.harness.intake.typed_fields import filled
from plumbline.harness.scene.importers.companion import Companion
from plumbline.harness.scene.values import FROZEN, Name

LIST = Path(__file__).with_name("packages.toml")
MENAGERIE = "mujoco-menagerie"


class NotHere(PlumblineError):
    """The files of a robot are not on this machine and cannot be fetched; the message says why."""


@validated(frozen=True, slots=True, kw_only=True, config=FROZEN)
class Listed:
    """A robot of a package. Terms: file: below the package's `under`. companion: what the file does not say."""

    name: Name
    title: Name
    file: str
    licence: str = ""
    companion: Companion = Companion()


@validated(frozen=True, slots=True, kw_only=True, config=FROZEN)
class Package:
    """A package with robots.

    Terms: under: the folder of their files, as its list of files has it. licence: of those that state none of their own. roots:
    by the name that files call it, the folder that package://NAME leads to, as the list of files has it.
    """

    distribution: Name
    under: str
    licence: str
    roots: dict[Name, str] = Field(default_factory=dict)
    robots: Annotated[tuple[Listed, ...], Field(min_length=1)]


@validated(frozen=True, slots=True, kw_only=True, config=FROZEN)
class Packages:
    """The file `packages.toml`."""

    packages: tuple[Package, ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class ZooRobot:
    """One robot of the zoo.

    Terms: name: unique. package, version: what brings it along; version '' where that is not installed. file: within the
    package; of the menagerie the name of a model. licence: of the robot, in the package's own words. roots: see `Package`.
    """

    name: str
    title: str
    package: str
    version: str
    licence: str
    file: str
    roots: Mapping[str, str] = field(default_factory=dict)
    companion: Companion = field(default_factory=Companion)


def robots(listing: Path = LIST) -> list[ZooRobot]:
    """All robots, those of the menagerie first; of a package that is not installed, those that are listed here."""
    packages = filled(TypeAdapter(Packages), document(listing), listing.name).packages
    listed = [
        ZooRobot(
            name=f"{package.distribution.replace('-', '_')}.{each.name}",
            title=each.title,
            package=package.distribution,
            version=version_of(package.distribution),
            licence=each.licence or package.licence,
            file=f"{package.under}/{each.file}",
            roots=package.roots,
            companion=each.companion,
        )
        for package in packages
        for each in package.robots
    ]
    return [*(menagerie() if listing == LIST else ()), *listed]


def menagerie() -> list[ZooRobot]:
    """What the menagerie's own list names; nothing where it is not installed."""
    version = version_of(MENAGERIE)
    if not version:
        return []
    listed: Any = importlib.import_module("mujoco_menagerie")
    return [
        ZooRobot(
            name=f"menagerie.{each.name}",
            title=each.display_name,
            package=MENAGERIE,
            version=version,
            licence=each.license,
            file=each.name,
        )
        for each in listed.robots()
    ]


def version_of(package: str) -> str:
    """The installed version of a package; '' where it is not installed."""
    installed = _distribution(package)
    return "" if installed is None else installed.version


def file_of(robot: ZooRobot) -> Path:
    """Where the robot's file lies. Raises: NotHere."""
    if robot.package == MENAGERIE:
        return _fetched(robot.file)
    installed = _distribution(robot.package)
    if installed is None:
        raise NotHere(f"{robot.package} is not installed: --yes installs it, or pip install 'plumbline[zoo]'")
    path = Path(str(installed.locate_file(robot.file)))
    if not path.is_file():
        raise NotHere(f"{robot.package} {installed.version} has no file {robot.file}")
    return path


def roots_of(robot: ZooRobot) -> dict[str, Path]:
    """Where package://NAME leads to, by its name, for the files of a package that is installed."""
    installed = _distribution(robot.package)
    return {} if installed is None else {name: Path(str(installed.locate_file(folder))) for name, folder in robot.roots.items()}


def at_hand(robot: ZooRobot) -> bool:
    """Are the robot's files on this machine, so that nothing has to be fetched?"""
    if robot.package != MENAGERIE:
        return bool(robot.version)
    listed: Any = importlib.import_module("mujoco_menagerie")
    cache = listed.Cache()
    return cache.root is not None or bool(cache.is_cached(listed.get(robot.file)))


def _distribution(package: str) -> Distribution | None:
    try:
        return distribution(package)
    except PackageNotFoundError:
        return None


def _fetched(model: str) -> Path:
    """The model alone of a robot of the menagerie, without its scene. Raises: NotHere."""
    listed: Any = importlib.import_module("mujoco_menagerie")
    robot = listed.get(model)
    try:
        return Path(robot.xml(robot.default_model))
    except (listed.MenagerieError, OSError) as error:
        raise NotHere(f"{MENAGERIE} did not get its files: {readable(str(error), 300)}") from None


def chosen(all_robots: Sequence[ZooRobot], globs: Sequence[str]) -> list[ZooRobot]:
    """Those that a pattern names; all without one. Raises: PlumblineError, of a pattern that names none."""
    from fnmatch import fnmatchcase

    for glob in globs:
        if not any(fnmatchcase(robot.name, glob) for robot in all_robots):
            example = f"expected a pattern over names like {all_robots[0].name}"
            raise PlumblineError(f"--case {quoted(glob)} names no robot of the zoo, {example}")
    return [robot for robot in all_robots if not globs or any(fnmatchcase(robot.name, glob) for glob in globs)]
