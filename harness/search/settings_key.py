"""What tells the settings of one trial from those of another: all that decides an answer, and no source of advice."""

import json
from collections.abc import Hashable
from dataclasses import fields
from operator import attrgetter
from typing import Any

from plumbline.harness.adapter import Settings
from plumbline.harness.study.one_knob import OPTION

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
