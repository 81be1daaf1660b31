"""Whose laws: which features of a run's engines are their own, which their adapters make, and which they lack."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from plumbline.harness.findings.emulations import Made, made
from plumbline.harness.store.store import Store
from plumbline.reports.words.called import WORDS
from plumbline.reports.words.catalogue import engines

NAMES = WORDS["features"]
"""What a feature is called in a table, where its own name says too little."""
BATCH = "many worlds in a call"
IN_TURNS = "the harness lets worlds take turns, a few steps each"


@dataclass(frozen=True, slots=True)
class EmulatedLaw:
    """One feature on one engine.

    Terms:
        word: 'own', 'emulated', 'in part emulated' or 'not offered'. made: what its adapter makes.
    """

    word: str
    made: tuple[Made, ...] = ()


def _law(engine: Mapping[str, Any], feature: str, emulations: list[Made]) -> EmulatedLaw:
    if feature not in engine["features"]:
        return EmulatedLaw("not offered")
    mine = tuple(emulation for emulation in emulations if emulation.feature == feature)
    if not mine:
        return EmulatedLaw("own")
    whole = not any(emulation.where for emulation in mine) and set(engine["tracks"]) <= {
        track for emulation in mine for track in emulation.tracks
    }
    return EmulatedLaw("emulated" if whole else "in part emulated", mine)


def _told(store: Store) -> dict[str, dict[str, Any]]:
    """The engines that tell their features."""
    return {name: engine for name, engine in engines(store).items() if engine["features"]}


def _table(store: Store, features: list[str]) -> list[tuple[str, Mapping[str, EmulatedLaw]]]:
    described = _told(store)
    emulations = {name: made(store.catalogue, name) for name in described}
    return [
        (
            NAMES.get(feature, feature.replace("_", " ")),
            {name: _law(described[name], feature, emulations[name]) for name in described},
        )
        for feature in features
    ]


def _batches(store: Store) -> tuple[str, Mapping[str, EmulatedLaw]]:
    """Who steps many worlds in a call of its own."""
    described = _told(store)
    turns = {name: (Made(name, BATCH, IN_TURNS, "", tuple(engine["tracks"])),) for name, engine in described.items()}
    return BATCH, {
        name: EmulatedLaw("own") if engine["batch"] else EmulatedLaw("emulated", turns[name])
        for name, engine in described.items()
    }


def _features(store: Store) -> list[str]:
    """All features that some engine claims, in the order of the one that claims most."""
    claimed = sorted((engine["features"] for engine in engines(store).values()), key=len, reverse=True)
    return list(dict.fromkeys(feature for features in claimed for feature in features))


def every_law(store: Store) -> list[tuple[str, Mapping[str, EmulatedLaw]]]:
    """By feature and engine, for every feature that some engine claims."""
    return [*_table(store, _features(store)), _batches(store)]


def told_apart(store: Store) -> list[tuple[str, Mapping[str, EmulatedLaw]]]:
    """By feature and engine, for the features that some engine lacks or some adapter makes."""
    return [(feature, row) for feature, row in every_law(store) if any(law.word != "own" for law in row.values())]


def own_everywhere(store: Store) -> list[str]:
    """The features that are each engine's own."""
    return [feature for feature, row in _table(store, _features(store)) if all(law.word == "own" for law in row.values())]


def laws_of_case(store: Store, case: Mapping[str, Any]) -> list[tuple[str, Mapping[str, EmulatedLaw]]]:
    """By feature and engine, for what the case uses and not every engine has of its own."""
    used = _table(store, [feature for feature in _features(store) if feature in case["features"]])
    return [(feature, row) for feature, row in used if any(law.word != "own" for law in row.values())]
