"""Where a scene stands beside its case: the parameters that were given other values than the case's own, and the time step."""

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

STEP = "dt"
"""The name that a time step [s] stands by among parameters."""


def differing(given: Iterable[Mapping[str, Any]], own: Mapping[str, Any]) -> list[str]:
    """The parameters that differ from the case's own values in one of these scenes at least; never the seed."""
    scenes = list(given)
    names = dict.fromkeys(name for scene in scenes for name in scene if name != "seed")
    return [name for name in names if any(scene.get(name) != own.get(name) for scene in scenes)]


def other_values(given: Mapping[str, Any], own: Mapping[str, Any]) -> dict[str, Any]:
    """What one scene was given in place of the case's own values, by name."""
    return {name: given[name] for name in differing([given], own)}


def in_words(values: Mapping[str, Any] | Sequence[tuple[str, Any]]) -> str:
    """'wall thickness 0.01, continuous on, dt 1/240 s'; nothing for a case as it is."""
    pairs = values.items() if isinstance(values, Mapping) else values
    return ", ".join(
        f"{name} 1/{1 / value:.4g} s" if name == STEP else f"{_words(name)} {_words(value)}" for name, value in pairs
    )


def whole_part(dt: float) -> str:
    """A time step [s] as people write it, '1/240 s'; '' where it is no whole part of a second."""
    parts = round(1 / dt)
    return f"1/{parts} s" if parts > 1 and abs(parts * dt - 1) < 1e-6 else ""


def _words(value: Any) -> str:
    """A name or a value: switches are on or off, and names are words."""
    if isinstance(value, bool):
        return "on" if value else "off"
    return value.replace("_", " ") if isinstance(value, str) else str(value)
