"""Versions of an engine by name: `mujoco==3.3.0` and `mujoco=its.whl` on the command line, `mujoco 3.3.0` everywhere else."""

import hashlib
import re
from dataclasses import dataclass
from fnmatch import fnmatchcase
from pathlib import Path

from plumbline.harness.intake.error import PlumblineError
from plumbline.harness.intake.safe_text import quoted

_VERSION = re.compile(r"[0-9A-Za-z][0-9A-Za-z.!+_-]{0,49}")
_WHEEL = re.compile(r"(?P<distribution>[^-]+)-(?P<version>[^-]+)(-\d[^-]*)?-[^-]+-[^-]+-[^-]+\.whl")
"""Source: Python Packaging User Guide, 'Binary distribution format': file name convention."""
_DIGITS = 12
"""Of a wheel's digest in its version: two builds that call themselves the same are two engines."""


class VersionError(PlumblineError):
    """A version of an engine that cannot be meant; the message says what was given and what is expected."""


@dataclass(frozen=True, slots=True)
class EngineVersion:
    """One version of an engine.

    Terms: engine: the adapter's name. version: '' for the one that the adapter's lock file pins. wheel: the file that holds it;
    None where an index does.
    """

    engine: str
    version: str = ""
    wheel: Path | None = None

    @property
    def name(self) -> str:
        """What it is called in records, tables and pages."""
        return f"{self.engine} {self.version}".rstrip()


def version_wanted(text: str) -> EngineVersion | None:
    """The version that `ENGINE==VERSION` or `ENGINE=WHEEL` asks for; None for a plain name. Raises: VersionError, OSError."""
    engine, asks, wanted = text.partition("=")
    if not asks:
        return None
    if wanted.startswith("="):
        version = wanted[1:]
        if not engine or not _VERSION.fullmatch(version):
            raise VersionError(f"{quoted(text)}, expected ENGINE==VERSION like mujoco==3.3.0")
        return EngineVersion(engine, version)
    wheel = Path(wanted)
    named = _WHEEL.fullmatch(wheel.name)
    if not engine or named is None or not wheel.is_file():
        why = "no such file" if named is not None else "not named like a wheel"
        raise VersionError(f"{quoted(text)}: {why}, expected ENGINE=FILE.whl or ENGINE==VERSION")
    digest = hashlib.sha256(wheel.read_bytes()).hexdigest()[:_DIGITS]
    release, plus, local = named["version"].partition("+")
    return EngineVersion(engine, f"{release}+{local}{'.' if plus else ''}{digest}", wheel.resolve())


def engine_of(name: str) -> str:
    """The engine that a name belongs to: mujoco for `mujoco` and for `mujoco 3.3.0`."""
    return name.partition(" ")[0]


def version_asked(name: str) -> str:
    """The version in a name; '' for the one that is installed beside plumbline."""
    return name.partition(" ")[2]


def asked(name: str) -> str:
    """What the command line calls an engine of this name, `mujoco==3.3.0`; a wheel's version is found there by its digest."""
    return "==".join(filter(None, (engine_of(name), version_asked(name))))


def named_by(name: str, pattern: str) -> bool:
    """Does a pattern over engines name this one, by its whole name or by that of its engine?"""
    return fnmatchcase(name, pattern) or fnmatchcase(engine_of(name), pattern)
