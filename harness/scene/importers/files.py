"""Which files a robot file may lead to: those in its own folder and under the roots that the user names, links resolved."""

import re
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

from plumbline.harness.intake.allowance import beyond
from plumbline.harness.intake.documents import InputError, named, regular
from plumbline.harness.intake.error import RobotError
from plumbline.harness.intake.safe_text import quoted
from plumbline.harness.scene.importers.xml_text import elements

_LEVELS = 8
"""Folders above a file that are looked through for the package that it is part of."""
_SCHEME = re.compile(r"([A-Za-z][A-Za-z0-9+.-]+):(?!\\)(.*)", re.DOTALL)


@dataclass(frozen=True, slots=True)
class Folders:
    """Where references may lead. Terms: home: the folder of the file. packages: by name."""

    home: Path
    packages: Mapping[str, Path]

    def found(self, reference: str, where: str, base: Path | None = None) -> Path | None:
        """The file that a reference names, relative ones from `base` (the home unless said); None where there is none.

        Raises: RobotError, where it leads outside or is no reference to a file.
        """
        if not reference or len(reference) > 1000 or not reference.isprintable():
            raise RobotError(f"{where} is {quoted(reference)}, expected the path of a file")
        scheme = _SCHEME.fullmatch(reference)
        if scheme is None:
            path = (base or self.home) / reference
        elif scheme[1] in ("package", "model"):
            name, _, rest = scheme[2].lstrip("/").partition("/")
            if name not in self.packages:
                return None
            path = self.packages[name] / rest
        else:
            raise RobotError(f"{where} is {quoted(reference)}: only paths and package://NAME/PATH are followed")
        try:
            target = path.resolve()
        except (OSError, RuntimeError, ValueError):
            raise RobotError(f"{where} is {quoted(reference)}, expected a path that leads somewhere") from None
        roots = [self.home.resolve(), *(root.resolve() for root in self.packages.values())]
        if not any(target.is_relative_to(root) for root in roots):
            raise RobotError(
                f"{where} is {quoted(reference)}, which leads out of {named(self.home)} and of every package; "
                "--package NAME=DIR adds a folder that files may lie in"
            )
        return target if target.exists() else None

    def strays(self, reference: str) -> bool:
        """Is it an absolute path that leads out of all folders, as those of another machine do?"""
        return Path(reference).is_absolute() and not any(
            Path(reference).is_relative_to(root) for root in (self.home.resolve(), *self.packages.values())
        )

    def missing(self, reference: str) -> str:
        """Why a reference has led to nothing, with the words that mend it."""
        scheme = _SCHEME.fullmatch(reference)
        if scheme is not None:
            name = scheme[2].lstrip("/").partition("/")[0]
            if name not in self.packages:
                return f"package {quoted(name, 80)} is not known; --package {quoted(name, 80)[1:-1]}=DIR says where it lies"
        if self.strays(reference):
            return (
                "an absolute path that leads out of the robot's folder; --package NAME=DIR adds a folder that files may lie in"
            )
        return "there is no such file"


def content(path: Path, where: str, limit: str = "bytes") -> bytes:
    """The bytes of a regular file of at most the allowed number. Args: limit: its name. Raises: RobotError."""
    label = where if where == named(path) else f"{where}: {named(path)}"
    try:
        regular(path)
        size = path.stat().st_size
        if excess := beyond(limit, size, "bytes"):
            raise RobotError(f"{label}: {excess}")
        return path.read_bytes()
    except InputError as error:
        raise RobotError(f"{where}: {error}") from None
    except FileNotFoundError:
        looked_in = "" if path.is_absolute() else f" in {named(Path.cwd())}"
        raise RobotError(f"{label}: there is no such file{looked_in}") from None
    except OSError as error:
        raise RobotError(f"{label}: not readable: {error.strerror}; expected a file") from None


def text_of(path: Path, where: str) -> str:
    """The text of a regular file in UTF-8. Raises: RobotError."""
    raw = content(path, where)
    try:
        return raw.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = raw.count(b"\n", 0, error.start) + 1
        raise RobotError(
            f"{named(path)}: line {line}: byte 0x{raw[error.start]:02x} is no UTF-8; expected a text in UTF-8"
        ) from None


def packages_above(path: Path) -> dict[str, Path]:
    """The packages that a file lies in, by name: folders above it with a package.xml (ROS) or a model.config (Gazebo).

    Source: ROS REP 149, package.xml: <name>; a model of Gazebo has the name of its folder.
    """
    packages: dict[str, Path] = {}
    for folder in [*path.resolve().parents][:_LEVELS]:
        manifest, model = folder / "package.xml", folder / "model.config"
        if manifest.is_file():
            with suppress(RobotError):  # what is no package is none
                name = elements(text_of(manifest, named(manifest)), named(manifest)).first("name")
                if name is not None and name.text.strip():
                    packages.setdefault(name.text.strip(), folder)
        if model.is_file():
            packages.setdefault(folder.name, folder)
    return packages
