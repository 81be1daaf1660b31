"""Finding plug-ins: adapters and cases, by walking a folder and by entry points; nothing is listed by hand.

A name found twice, or a file that does not end in its constant, is an error; an import error is raised, never hidden. A third
party's plug-in that cannot be loaded is named with the reason, and costs no other one: an engine is unavailable then, a case is
left out.
"""

import importlib
import pkgutil
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import cache
from importlib.metadata import EntryPoint
from pathlib import Path
from typing import Any

from plumbline.harness.adapter import Adapter, Feature, Settings, Simulation, Unavailable
from plumbline.harness.case import Case
from plumbline.harness.case.undropped import OWN
from plumbline.harness.intake.apart import NoAnswer, apart
from plumbline.harness.intake.error import PlumblineError
from plumbline.harness.intake.near_miss import did_you_mean
from plumbline.harness.intake.strangers import PATIENCE, points, trouble
from plumbline.harness.scene import Scene
from plumbline.harness.study import environments
from plumbline.harness.study.engine_versions import asked, engine_of, version_asked

_LONGEST_VERSION = 100
SCENE_PREFIX = OWN


class PluginError(PlumblineError):
    """A plug-in that breaks its contract; the message names it and what was expected."""


def _built_in(kind: str) -> Mapping[str, str]:
    """File names of a package of ours ('adapters' or 'cases') to module paths, in the order of the listing."""
    package = f"plumbline.{kind}"
    paths = tuple(importlib.import_module(package).__path__)
    return _listing(package, paths, tuple(Path(path).stat().st_mtime_ns for path in paths))


@cache
def _listing(package: str, paths: tuple[str, ...], changed: tuple[int, ...]) -> Mapping[str, str]:  # noqa: ARG001
    """As `_built_in`. Args: changed: when the folders were [ns]; Python's own importer takes it for a sign of new files too."""
    return {m.name: f"{package}.{m.name}" for m in pkgutil.iter_modules(paths) if not m.name.startswith("_")}


def names(kind: str) -> tuple[str, ...]:
    """The names of all plug-ins of a kind ('adapters' or 'cases'), without importing one.

    Raises:
        PluginError: where a third party's plug-in takes a built-in name.
    """
    inside, outside = _built_in(kind), points(f"plumbline.{kind}")
    for name in inside.keys() & outside.keys():
        raise PluginError(
            f"entry point plumbline.{kind} '{name}' ({outside[name].value}): the name is built in; choose another"
        )
    return (*inside, *outside)


def module_of(kind: str, name: str) -> str | None:
    """The module of a plug-in of a kind ('adapters' or 'cases'), which is not imported; None where there is none."""
    name = engine_of(name) if kind == "adapters" else name
    point = points(f"plumbline.{kind}").get(name)
    return _built_in(kind).get(name, None if point is None else point.module)


def _constant(kind: str, name: str, constant: str, expected: type[Adapter] | type[Case]) -> Any:
    inside = _built_in(kind)
    if name in inside:
        constructed = getattr(importlib.import_module(inside[name]), constant, None)
        where = inside[name]
    else:
        point = points(f"plumbline.{kind}").get(name)
        if point is None:
            raise PluginError(
                f"{kind[:-1]} '{name}': not found, expected one of {', '.join(names(kind))}{did_you_mean(name, names(kind))}"
            )
        if reason := trouble(point):
            raise PluginError(f"{kind[:-1]} '{name}': {reason}")
        constructed, where = point.load(), point.value
    if not isinstance(constructed, expected):
        raise PluginError(f"{where}: {constant} is {type(constructed).__name__}, expected {expected.__name__}")
    if constructed.name != name:
        raise PluginError(f"{where}: {constant}.name is '{constructed.name}', expected '{name}' like its file")
    return constructed


@dataclass(frozen=True, kw_only=True)
class _Lost(Adapter):
    """In the place of a third party's adapter that cannot be loaded. Terms: reason: why."""

    reason: str

    def version(self) -> str:
        raise Unavailable(self.reason)

    def build(self, scene: Scene, settings: Settings) -> Simulation:  # noqa: ARG002  # none can be built
        raise Unavailable(self.reason)


def adapter(name: str) -> Adapter:
    """The adapter of that name; a third party's that cannot be loaded is unavailable. Raises: PluginError.

    That of a version of its own, `mujoco 3.3.0`, is the engine's under this name: all but `version_of` and what builds is the
    same in every environment.
    """
    if version := version_asked(name):
        plain = adapter(engine_of(name))
        return replace(plain, name=name, title=f"{plain.title} {version}")
    point = None if name in _built_in("adapters") else points("plumbline.adapters").get(name)
    if point is None:
        built_in: Adapter = _constant("adapters", name, "ADAPTER", Adapter)
        return built_in
    reason = trouble(point)
    if not reason:
        try:
            engine: Adapter = _constant("adapters", name, "ADAPTER", Adapter)
            reason = _wrong(engine)
        except PluginError as error:
            reason = str(error)
    if not reason:
        return engine
    tracks = {"default": Settings(), "tuned": Settings()}
    return _Lost(name=name, title=name, distribution="", features=Feature.NONE, tracks=tracks, reason=reason)


def _wrong(adapter: Adapter) -> str:
    """What a listing or a study would break on in a third party's adapter; '' where there is nothing."""
    for field in ("title", "distribution"):
        if type(getattr(adapter, field)) is not str:
            return f"adapter '{adapter.name}': {field} is {type(getattr(adapter, field)).__name__}, expected text"
    if not isinstance(adapter.features, Feature):
        return f"adapter '{adapter.name}': features is {type(adapter.features).__name__}, expected Feature"
    tracks = adapter.tracks
    if not isinstance(tracks, Mapping) or not all(isinstance(tracks.get(track), Settings) for track in ("default", "tuned")):
        return f"adapter '{adapter.name}': tracks, expected Settings for 'default' and 'tuned'"
    return ""


def case(name: str) -> Case:
    """The case of that name, or the one made of a scene file for a name 'scene:<path>'. Raises: PluginError, SceneError."""
    if name.startswith(SCENE_PREFIX):
        from plumbline.harness.case.scene_file import own_case  # late: only a scene of the user's own needs its metrics

        return own_case(Path(name.removeprefix(SCENE_PREFIX)), SCENE_PREFIX)
    question: Case = _constant("cases", name, "CASE", Case)
    return question


def adapters() -> dict[str, Adapter]:
    """All adapters by name."""
    return {name: adapter(name) for name in names("adapters")}


def cases(wanted: Callable[[str], bool] = lambda _name: True) -> dict[str, Case]:
    """The cases whose name is wanted, by name, but for those that are left out; no other is imported."""
    lost = left_out("cases")
    return {name: case(name) for name in names("cases") if wanted(name) and name not in lost}


def left_out(kind: str) -> dict[str, str]:
    """Third parties' plug-ins of a kind ('cases', 'pages') that cannot be loaded, each with the reason."""
    return {name: reason for name, point in points(f"plumbline.{kind}").items() if (reason := trouble(point))}


def left_out_in_words(*kinds: str) -> list[str]:
    """The same of these kinds, a sentence each."""
    return [f"{kind[:-1]} '{name}' is left out: {reason}" for kind in kinds for name, reason in left_out(kind).items()]


def version_of(engine: Adapter) -> tuple[str, str | None]:
    """The installed version and None, or 'none' and the reason why the engine is unavailable.

    Of an engine in an environment of its own, what was found there when that was made.
    """
    environment = environments.home_of(engine.name)
    if environment is not None:
        return ("none", environment.reason) if environment.reason else (environment.version, None)
    if version_asked(engine.name) and not environments.inside():
        return "none", f"has no environment here; plumbline run --engine {asked(engine.name)}"
    if engine.extra is not None and not environments.installed(engine.distribution):
        why = engine.extra.hindrance or f"not installed: --engine {engine.name} --yes does so ({engine.extra.price})"
        return "none", why
    point = None if engine.name in _built_in("adapters") else points("plumbline.adapters").get(engine.name)
    if point is None or isinstance(engine, _Lost):
        return _told_version(engine)
    return _version_apart(point.name, point.value, point.group)


def _told_version(engine: Adapter) -> tuple[str, str | None]:
    try:
        version = engine.version()
        if type(version) is not str or not version.isprintable() or not 0 < len(version) <= _LONGEST_VERSION:
            return "none", f"version() gave {repr(version)[:80]}, expected up to {_LONGEST_VERSION} printable characters"
        return version, None
    except Unavailable as error:
        return "none", str(error)
    except Exception as error:
        return "none", f"{type(error).__name__}: {error}"


@cache
def _version_apart(name: str, value: str, group: str) -> tuple[str, str | None]:
    """As `version_of`, of a third party's engine, asked once in a process of its own."""
    try:
        return apart(tuple[str, str | None], PATIENCE, stranger_version, name, value, group)
    except NoAnswer as error:
        return "none", str(error)


def stranger_version(name: str, value: str, group: str) -> tuple[str, str | None]:
    """The version of a third party's engine, in the process that is given up to it."""
    return _told_version(EntryPoint(name, value, group).load())
