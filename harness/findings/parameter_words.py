"""Parameters, steps and integrators in words: what tells a scene from its case as it is, and what a parameter is called where
people read of it, with its unit, since a name like `n` says nothing outside of its case. An engine may cut the step that it is
asked for, and whoever reads of a step reads of that.
"""

import json
from collections.abc import Iterable, Mapping, Sequence
from functools import lru_cache
from typing import TYPE_CHECKING, Any, NamedTuple

from plumbline.harness.findings.once import once
from plumbline.harness.findings.spoken import SPOKEN

if TYPE_CHECKING:
    from plumbline.harness.store.store import Store

STEP = "dt"
"""The name that a time step [s] stands by among parameters."""


class Counted(NamedTuple):
    """What a number counts: one, and several."""

    one: str
    several: str


class Quantity(NamedTuple):
    """What a number measures, and its unit, 1 for none."""

    name: str
    unit: str


WORDS: Mapping[str, Counted | Quantity] = {
    **{name: Counted(*words) for name, words in SPOKEN["counted"].items()},
    **{name: Quantity(*words) for name, words in SPOKEN["measured"].items()},
}
"""By the parameter, or by case and parameter where cases mean different things by it."""
PHRASED: Mapping[str, str] = {"thin": "one ray in {}"}
"""What is said of a value where name and number do not make a phrase."""


def called(case: str, parameter: str) -> str:
    """A parameter of a case as a quantity: 'number of balls', 'wall thickness'; the name in words where nobody knows better."""
    match _words_of(case, parameter):
        case Counted(several=several):
            return f"number of {several}"
        case Quantity(name=name):
            return name
    return parameter.replace("_", " ")


def axis_title(case: str, parameter: str, unit: str | None = None) -> str:
    """The title of an axis: 'number of balls', 'wall thickness [m]'. Args: unit: where the case's axis has one of its own."""
    known = _unit_of(case, parameter) if unit is None else unit
    return called(case, parameter) + ("" if known == "1" else f" [{known}]")


def said(case: str, parameter: str, value: Any) -> str:
    """A parameter with its value: '100 balls', 'wall thickness 0.02 m', 'seen by rays'; a word speaks for itself."""
    if isinstance(value, str):
        return value.replace("_", " ")
    if isinstance(value, bool) or not isinstance(value, int | float):
        return f"{parameter.replace('_', ' ')} {('off', 'on')[value] if isinstance(value, bool) else value}"
    number = f"{value:g}" if isinstance(value, float) else str(value)
    if parameter in PHRASED:
        return PHRASED[parameter].format(number)
    if isinstance(words := _words_of(case, parameter), Counted):
        return f"{number} {words.one if value == 1 else words.several}"
    unit = _unit_of(case, parameter)
    return f"{called(case, parameter)} {number}" + ("" if unit == "1" else f" {unit}")


def _words_of(case: str, parameter: str) -> Counted | Quantity | None:
    return WORDS.get(f"{case}.{parameter}", WORDS.get(parameter))


def _unit_of(case: str, parameter: str) -> str:
    words = _words_of(case, parameter)
    return words.unit if isinstance(words, Quantity) else "1"


def differing(given: Iterable[Mapping[str, Any]], own: Mapping[str, Any]) -> list[str]:
    """The parameters that differ from the case's own values in one of these scenes at least; never the seed."""
    scenes = list(given)
    names = dict.fromkeys(name for scene in scenes for name in scene if name != "seed")
    return [name for name in names if any(scene.get(name) != own.get(name) for scene in scenes)]


def other_values(given: Mapping[str, Any], own: Mapping[str, Any]) -> dict[str, Any]:
    """What one scene was given in place of the case's own values, by name."""
    return {name: given[name] for name in differing([given], own)}


def where_of(catalogue: Mapping[str, Any], case: str, parameters: str) -> str:
    """What a scene was given (JSON) in place of its case's own values, in words."""
    own = catalogue.get("cases", {}).get(case, {}).get("parameters") or {}
    return in_words(other_values(json.loads(parameters), own))


def in_words(values: Mapping[str, Any] | Sequence[tuple[str, Any]]) -> str:
    """'wall thickness 0.01, continuous on, dt 1/240 s'; nothing for a case as it is."""
    pairs = values.items() if isinstance(values, Mapping) else values
    return ", ".join(
        f"{name} 1/{1 / value:.4g} s" if name == STEP else f"{_words(name)} {_words(value)}" for name, value in pairs
    )


def _words(value: Any) -> str:
    """A name or a value: switches are on or off, and names are words."""
    if isinstance(value, bool):
        return "on" if value else "off"
    return value.replace("_", " ") if isinstance(value, str) else str(value)


def integrator_called(name: str) -> str:
    """'semi-implicit Euler' for 'semi_implicit_euler'; one that has no other name goes by its own."""
    return SPOKEN["integrators"].get(name) or name.replace("_", " ")


@lru_cache(maxsize=4096)
def substeps_of(resolved: str) -> int:
    """How many sub-steps an engine took for a step, by what it says that it used (JSON); 1 of one that says nothing of them."""
    settings = json.loads(resolved or "{}")
    return int(settings.get("substeps") or 1) if isinstance(settings, dict) else 1


@once
def substeps_taken(store: "Store") -> Mapping[str, int]:
    """The sub-steps of each trial that took several, by its name."""
    trials = store.trials
    taken = {str(t): substeps_of(str(r)) for t, r in zip(trials["trial"], trials["resolved"], strict=True)}
    return {trial: count for trial, count in taken.items() if count > 1}


def whole_part(dt: float) -> str:
    """A time step [s] as people write it, '1/240 s'; '' where it is no whole part of a second."""
    parts = round(1 / dt)
    return f"1/{parts} s" if parts > 1 and abs(parts * dt - 1) < 1e-6 else ""


def beside(substeps: int | None) -> str:
    """What stands beside a time step: ' (4 sub-steps)', or nothing where it was taken whole."""
    return f" ({substeps} sub-steps)" if substeps is not None and substeps > 1 else ""


def step_in_words(dt: float, substeps: int | None = 1) -> str:
    """A time step [s] as people write it, with what became of it: '1/60 s (4 sub-steps)'."""
    return (whole_part(dt) or f"{dt:.4g} s") + beside(substeps)
