"""One knob at another value: which such turns there are, what settings they make and are called, and which lies between two;
and what tells the settings of one trial from those of another.
"""

import json
from collections.abc import Hashable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, fields, replace
from operator import attrgetter
from typing import Any

from plumbline.harness.adapter import Settings

OPTION = "options."
"""How a knob begins that is one of `Settings.options`."""


@dataclass(frozen=True, slots=True)
class KnobTurn:
    """A knob ('iterations', 'options.cone', ...) and the value that it is turned to."""

    knob: str
    value: Any

    @property
    def name(self) -> str:
        """The knob as tables call it: 'iterations', 'cone'."""
        return self.knob.removeprefix(OPTION)

    def __str__(self) -> str:
        """'iterations 5', 'cone elliptic'."""
        return f"{self.name} {self.value}"


def turned(settings: Settings, knob: str, value: Any) -> Settings:
    """The settings with one knob at another value."""
    source = f"'{knob}' turned by a sweep"
    if knob.startswith(OPTION):
        return replace(settings, options={**settings.options, knob.removeprefix(OPTION): value}, source=source)
    return replace(settings, **{knob: value}, source=source)


def position(settings: Settings, knob: str) -> Any:
    """The value at which a knob stands; None if that is left to the engine."""
    if knob.startswith(OPTION):
        return settings.options.get(knob.removeprefix(OPTION))
    return getattr(settings, knob)


def turns(settings: Settings, knobs: Iterable[str], values: Mapping[str, Sequence[Any]]) -> Iterator[KnobTurn]:
    """Every turn of one of these knobs to a value at which it does not stand."""
    for knob in knobs:
        yield from (KnobTurn(knob, value) for value in values[knob] if value != position(settings, knob))


def differing(before: Settings, after: Settings) -> list[KnobTurn]:
    """Each knob in which two groups of settings differ, turned to the second; one that it leaves to the engine cannot be."""
    names = ("substeps", "iterations", "integrator", "solver", "tolerance")
    knobs = [*names, *(OPTION + name for name in dict.fromkeys([*before.options, *after.options]))]
    turns = [KnobTurn(knob, position(after, knob)) for knob in knobs if position(before, knob) != position(after, knob)]
    return [turn for turn in turns if turn.value is not None]


def turn_between(before: Mapping[str, Any], after: Mapping[str, Any]) -> KnobTurn | None:
    """The turn that makes one group of settings of another, both as `Settings.plain`; None if they differ in no knob, or in
    more than one."""
    flat = [
        {name: value for name, value in settings.items() if name not in ("options", "source")}
        | {OPTION + name: value for name, value in settings.get("options", {}).items()}
        for settings in (before, after)
    ]
    moved = [name for name in dict.fromkeys([*flat[0], *flat[1]]) if flat[0].get(name) != flat[1].get(name)]
    return KnobTurn(moved[0], flat[1].get(moved[0])) if len(moved) == 1 else None


def label_of(track: str, turned: Iterable[tuple[str, object]]) -> str:
    """'tuned, iterations 40': what trials, tables and pages call the settings that a search went on to from a track.

    Args: turned: the knobs with their values.
    """
    return ", ".join((track, *(f"{knob} {value}" for knob, value in turned)))


_FIELDS = tuple(one.name for one in fields(Settings) if one.name not in ("options", "source"))
"""Those of `Settings` that decide an answer, beside its options."""
_values_of = attrgetter(*_FIELDS)


def key_of(settings: Settings, knob: str = "") -> Hashable:
    """Equal for settings that differ in nothing, or in this knob alone, which may be the time step ('dt')."""
    values: tuple[Hashable, ...] = _values_of(settings)
    if knob in _FIELDS:
        values = tuple(None if name == knob else value for name, value in zip(_FIELDS, values, strict=True))
    return values, frozenset((name, _told(value)) for name, value in settings.options.items() if knob != OPTION + name)


def _told(value: Any) -> str:
    """The value of an option: of what is nested as in JSON, which takes ten times as long as a number or a text."""
    return repr(value) if type(value) in (bool, int, float, str) else json.dumps(value, sort_keys=True)
