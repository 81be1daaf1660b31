"""How much an input may ask for, before any work is done for it: every limit has a name, a value and a way to raise it."""

import math
import os
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import asdict, dataclass, fields
from functools import cache

from plumbline.harness.intake.error import PlumblineError
from plumbline.harness.intake.safe_text import quoted

VARIABLE = "PLUMBLINE_LIMITS"
"""The environment variable that sets limits, like 'bodies=200000,bytes=1e8'; processes that are started inherit it."""


class AllowanceError(PlumblineError, ValueError):
    """A limit that is none; the message names it, its value and those that there are."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Allowance:
    """The greatest numbers that are taken from a file.

    Terms:
        bytes of a scene or study file. meshes: bytes of all meshes of a robot. depth of arrays and tables in each other. digits
        of a number. parts: arrays and tables.
        bodies, joints and sensors of a scene. things: every whole number that a study gives a case, of whatever it counts.
        vertices, and faces, of all shapes together. rays, pixels and readings of all sensors over the whole duration.
        steps of a trial. samples: recorded instants times bodies. trials of a study, searches apart.
    """

    bytes: int = 16_000_000
    meshes: int = 64_000_000
    depth: int = 64
    digits: int = 1000
    parts: int = 1_000_000
    bodies: int = 100_000
    joints: int = 100_000
    sensors: int = 1000
    things: int = 10_000
    vertices: int = 2_000_000
    rays: int = 1_000_000_000
    steps: int = 100_000_000
    samples: int = 20_000_000
    trials: int = 200_000


DEEPEST = 300
"""The greatest depth that may be allowed: parsers of files, vendors' among them, call themselves at each level."""
_NAMES = tuple(field.name for field in fields(Allowance))


def _limit(text: str, where: str) -> tuple[str, int]:
    name, equals, number = (word.strip() for word in text.partition("="))
    if name not in _NAMES or not equals:
        raise AllowanceError(f"{where}: {quoted(text)}, expected NAME=VALUE with one of {', '.join(_NAMES)}")
    try:
        value = float(number) if len(number) < 30 else math.nan
    except ValueError:
        value = math.nan
    most = DEEPEST if name == "depth" else 1e15
    if not 1 <= value <= most or value != int(value):
        raise AllowanceError(f"{where}: {name} is {quoted(number)}, expected a whole number from 1 to {most:g}")
    return name, int(value)


def raised(settings: Iterable[str], where: str, over: Allowance | None = None) -> Allowance:
    """The allowance with settings 'NAME=VALUE' laid over another one; `where` says who set them. Raises: AllowanceError."""
    values: dict[str, int] = {}
    for text in settings:
        name, value = _limit(text, where)
        if name in values:
            raise AllowanceError(f"{where}: {name} stands twice, {values[name]} and {value}, expected once")
        values[name] = value
    before = asdict(over or Allowance())
    if "bytes" in values:
        # Who allows more bytes means to read larger meshes; a triangle takes 50 of them, a vertex of a text half as many.
        with_bytes = {"meshes": values["bytes"], "vertices": values["bytes"] // 25}
        before |= {name: max(before[name], value) for name, value in with_bytes.items()}
    return Allowance(**(before | values))


def allowance() -> Allowance:
    """What is allowed in this process. Raises: AllowanceError."""
    return _told(os.environ.get(VARIABLE, ""))


@cache
def _told(text: str) -> Allowance:
    return raised(filter(None, text.split(",")), f"environment variable {VARIABLE}")


@contextmanager
def allowing(settings: Iterable[str], where: str) -> Iterator[None]:
    """Let these settings hold here and in every process that is started from here. Raises: AllowanceError."""
    before = os.environ.get(VARIABLE)
    limits: Mapping[str, int] = asdict(raised(settings, where, allowance()))
    os.environ[VARIABLE] = ",".join(f"{name}={value}" for name, value in limits.items())
    try:
        yield
    finally:
        if before is None:
            del os.environ[VARIABLE]
        else:
            os.environ[VARIABLE] = before


def beyond(name: str, count: float, unit: str = "") -> str:
    """In words, how far a count lies above the limit of that name; '' where it does not."""
    most: int = getattr(allowance(), name)
    if count <= most:
        return ""
    return f"{count:.12g} {unit or name}, expected at most {most}; --limit {name}=VALUE allows more"
