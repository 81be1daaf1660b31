"""Third parties' plug-ins: each is loaded in a process of its own before this one loads it, so that none takes others along.

A plug-in that loads is not tried again until a file of its package changes; one that does not is tried each time.
"""

import hashlib
import json
import sys
from contextlib import suppress
from dataclasses import asdict, dataclass
from functools import cache
from importlib.machinery import PathFinder
from importlib.metadata import EntryPoint, EntryPoints, entry_points
from pathlib import Path
from typing import Any

from plumbline.harness.intake.apart import NoAnswer, apart
from plumbline.harness.intake.user_cache import cache_folder, keep, read_kept

PATIENCE = 10.0
"""Seconds that a plug-in may take to load, beside those that its process takes to start."""


@dataclass(frozen=True, slots=True)
class Facts:
    """What is known of a plug-in without calling it; as `reports.page.Page` has it."""

    name: str = ""
    title: str = ""
    order: int = 0
    listed: bool = True


_FACTS = {"name": str, "title": str, "order": int, "listed": bool}


def points(group: str) -> dict[str, EntryPoint]:
    """The entry points of a group by name."""
    return {point.name: point for point in _all(tuple(sys.path)).select(group=group)}


@cache
def _all(path: tuple[str, ...]) -> EntryPoints:  # noqa: ARG001  # what is found depends on it
    """Those of all packages, which takes a tenth of a second to read, once for each `path` of the interpreter."""
    return entry_points()  # type: ignore[return-value]  # the stub knows what they are from Python 3.12 on


def trouble(point: EntryPoint) -> str:
    """Why a plug-in cannot be loaded; '' where it can."""
    return _tried(point.name, point.value, point.group)[0]


def facts(point: EntryPoint) -> Facts:
    """What a plug-in that can be loaded has of `Facts`."""
    return _tried(point.name, point.value, point.group)[1]


@cache
def _tried(name: str, value: str, group: str) -> tuple[str, Facts]:
    """Why it cannot be loaded, and what it has."""
    seen = _place(f"facts {sys.version} {group} {name} {value}", value)
    if seen is not None and (stored := read_kept(seen)) is not None:
        return "", Facts(**json.loads(stored))
    try:
        facts_of_it = apart(Facts, PATIENCE, loaded, name, value, group)
    except NoAnswer as error:
        return f"{value}: {error}", Facts()
    if seen is not None:
        keep(seen, json.dumps(asdict(facts_of_it)).encode())
    return "", facts_of_it


def loaded(name: str, value: str, group: str) -> dict[str, object]:
    """Load a plug-in, and ask what every listing asks of its kind: the version of an engine, the scene of a case.

    Returns: the fields of `Facts` that it has.
    Raises: whatever it raises; ImportError, with the name of today where it is one of before.
    """
    try:
        plugin: Any = EntryPoint(name, value, group).load()
    except ImportError as error:
        room = (error.name or "").partition(".")[0]
        hint = f"; import plumbline.{room} instead" if room in ("adapters", "cases", "engine", "harness", "reports") else ""
        raise type(error)(f"{error}{hint}") from None
    if group == "plumbline.adapters":
        with suppress(Exception):  # which `version_of` tells
            plugin.version()
    if group == "plumbline.cases" and hasattr(plugin, "scene"):
        plugin.scene(plugin.parameters)
    return {name: getattr(plugin, name) for name, kind in _FACTS.items() if isinstance(getattr(plugin, name, None), kind)}


def _place(what: str, value: str) -> Path | None:
    """The file that says that a plug-in has loaded, by all that it depends on; None where its files are not found."""
    spec = PathFinder.find_spec(value.partition(":")[0].partition(".")[0])
    if spec is None:
        return None
    folders = [Path(folder) for folder in spec.submodule_search_locations or ()]
    files = sorted(file for folder in folders for file in folder.rglob("*.py")) or [Path(spec.origin or "")]
    digest = hashlib.sha256(what.encode())
    try:
        for file in files:
            digest.update(f"{file}\0".encode() + file.read_bytes())
    except OSError:
        return None
    return cache_folder("plugins") / digest.hexdigest()
