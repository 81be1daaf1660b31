"""What the page on selection shows: the answer at equal weights, and the evidence from which a browser works it out anew."""

import json
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import lru_cache, partial
from glob import escape
from typing import Any

from markupsafe import Markup

from plumbline.harness.findings.selection import CRITERIA, Answer, Wish, choose, preset_names, read_preset
from plumbline.harness.findings.selection.choose import EXPRESSED
from plumbline.harness.findings.selection.evidence import BOUND, Datum
from plumbline.harness.findings.selection.words import FEW, SENTENCES, headline
from plumbline.harness.store.store import Store
from plumbline.reports.tables.own_scenes import by_case
from plumbline.reports.tables.realtime_speed import Pace, pace_of
from plumbline.reports.tables.trial_results import stepless
from plumbline.reports.words.catalogue import FAMILIES, cases, engine_title, setting_words
from plumbline.reports.words.text import settings_text, slug


@lru_cache(maxsize=1)
def answer(store: Store) -> Answer:
    """At equal weights, over all cases, without our own engine."""
    return choose(store, Wish())


def asked_of_several(store: Store) -> bool:
    """Were two engines of others asked at least, and is one left? That nothing else can express a scene is an answer too."""
    found = answer(store)
    return found.rank is not None and found.asked > 1


def evidence_rows(store: Store) -> list[tuple[tuple[str, str, str], Datum]]:
    """All data with their criteria, cases and engines, worst first."""
    return sorted(answer(store).evidence.table.items(), key=lambda row: (row[1].value, *row[0]))


def live(store: Store) -> Markup:
    """The same as JSON for the page's script; '<' is written so that nothing in it can end the element."""
    found = answer(store)
    evidence = found.evidence
    about, known = store.catalogue.get("engines", {}), cases(store)
    names, engines = list(evidence.cases), list(evidence.engines)
    criteria = [name for name in CRITERIA if any(key[0] == name for key in evidence.table)]
    families = list(dict.fromkeys(evidence.families[case] for case in names))
    content = {
        "criteria": criteria,
        "families": [{"name": family, "title": FAMILIES.get(family, family)} for family in families],
        "cases": [{"name": name, "title": known[name]["title"], "family": evidence.families[name]} for name in names],
        "engines": [
            {
                "name": name,
                "title": engine_title(store, name),
                "track": setting_words(store, name, evidence.tracks[name]),
                "features": list(about.get(name, {}).get("features", ())),
            }
            for name in engines
        ],
        "cells": [
            [
                criteria.index(criterion),
                names.index(case),
                engines.index(engine),
                _short(d.value),
                _short(d.low),
                _short(d.high),
                int(d.bounded),
            ]
            for (criterion, case, engine), d in evidence.table.items()
        ],
        "costs": [
            [names.index(case), engines.index(engine), price.cost, int(price.verdict == BOUND)]
            for (case, engine), price in evidence.costs.items()
        ],
        "presets": [_preset(name, evidence.families) for name in preset_names()],
        "sentences": dict(SENTENCES),
        "few": FEW,
        "own": [names.index(case) for case in names if case in evidence.own],
        "asked": found.asked,
        "others": any(drop.requirement != EXPRESSED for drop in found.dropped),
    }
    return Markup(json.dumps(content, separators=(",", ":")).replace("<", "\\u003c").replace("&", "\\u0026"))


@dataclass(frozen=True)
class Choice:
    """An engine that stands first, alone or level. Terms: setting: its track, or what a search went on to, in
    words; settings: what that means. slowest, fastest: over the
    cases of the purpose, None where none of its trials there is clocked and errs by a per cent or less. paced: in how many."""

    engine: str
    track: str
    setting: str
    settings: str
    slowest: Pace | None
    fastest: Pace | None
    paced: int


@dataclass(frozen=True)
class Need:
    """A purpose in the shortest: what it is, the answer with its doubt, who stands first with which settings and at which cost,
    on how many cases. own: is it a scene of the user's own, and nothing else?"""

    name: str
    title: str
    why: str
    answer: str
    choices: tuple[Choice, ...]
    cases: int
    own: bool = False


OWN = (
    "All that this scene was asked counts alike: who ends where the others do, what a per cent of error costs, who ends at all."
)
FEWEST = 3
"""Cases of a purpose below which nothing is said of it."""


@lru_cache(maxsize=1)
def needs(store: Store) -> list[Need]:
    """The scenes of the user's own, and the built-in purposes of which the run has cases enough."""
    if not asked_of_several(store):
        return []
    titled, found = partial(engine_title, store), []
    for name in preset_names():
        preset = read_preset(name)
        answer = choose(store, preset.wish(), draws=2000)
        if answer.rank is None or len(answer.evidence.cases) < FEWEST:
            continue
        first = tuple(_choice(store, answer, place.engine) for place in answer.rank.places if place.number == 1)
        found.append(Need(name, preset.title, preset.why, headline(answer, titled), first, len(answer.evidence.cases)))
    return [*(own for case in by_case(store) if (own := _own_need(store, case, titled)) is not None), *found]


def _own_need(store: Store, case: str, titled: Callable[[str], str]) -> Need | None:
    """The purpose of a scene of the user's own: itself. Where nothing else was run, its answer is that of all cases."""
    whole = answer(store)
    mine = whole if whole.evidence.cases.keys() == {case} else choose(store, Wish(cases={escape(case): 1.0}), draws=2000)
    if mine.rank is None:
        return None
    first = tuple(_choice(store, mine, place.engine) for place in mine.rank.places if place.number == 1)
    return Need(slug(case), str(cases(store)[case]["title"]), OWN, headline(mine, titled), first, 1, own=True)


def _choice(store: Store, answer: Answer, engine: str) -> Choice:
    track = answer.evidence.tracks[engine]
    settings = _settings(store, engine, track)
    known = [pace for case in answer.evidence.cases if (pace := pace_of(store, case, engine, track)) is not None]
    paces = sorted(known, key=lambda pace: pace.times)
    return Choice(
        engine,
        track,
        setting_words(store, engine, track),
        settings,
        paces[0] if paces else None,
        paces[-1] if paces else None,
        len(paces),
    )


def _settings(store: Store, engine: str, track: str) -> str:
    """Those of a track by the catalogue; of any other settings by one of its trials, whose step says nothing of the others."""
    tracks = store.catalogue.get("engines", {}).get(engine, {}).get("tracks", {})
    if track in tracks:
        return settings_text(tracks[track])
    texts = store.trials["settings"][(store.trials["engine"] == engine) & (store.trials["track"] == track)]
    return settings_text(stepless(str(texts.iloc[0]))) if len(texts) else ""


def _short(value: float) -> float:
    return float(f"{value:.4g}")


def _preset(name: str, families: Mapping[str, str]) -> dict[str, Any]:
    preset = read_preset(name)
    wish = preset.wish()
    return {
        "name": name,
        "title": preset.title,
        "why": preset.why,
        "weights": {criterion: wish.weight(criterion) for criterion in CRITERIA},
        "cases": {case: wish.weight_of_case(case, family) for case, family in families.items()},
    }
