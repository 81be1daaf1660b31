"""What the first page and the page on selection show: the answer for each purpose, and the evidence from which a browser works
it out anew."""

import json
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from glob import escape
from typing import Any

from markupsafe import Markup

from plumbline.harness.findings.once import once
from plumbline.harness.findings.selection import CRITERIA, Selection, Wish, choose, preset_names, read_preset
from plumbline.harness.findings.selection.choose import EXPRESSED
from plumbline.harness.findings.selection.evidence import DECADES_OF_SPEED, Datum
from plumbline.harness.findings.selection.rank import DOUBT_OF_WEIGHTS, DRAWS, SEED, Place
from plumbline.harness.findings.selection.words import (
    CLEAR,
    FEW,
    SENTENCES,
    beyond,
    decisive,
    error_percent,
    gaps,
    percent,
    trade,
    turn_sentences,
    who_leads,
)
from plumbline.harness.store.store import Store
from plumbline.reports.tables.own_scenes import by_case
from plumbline.reports.tables.trial_results import stepless
from plumbline.reports.words.catalogue import FAMILIES, cases, engine_title, setting_words
from plumbline.reports.words.text import TIMES, amount, settings_text, slug


@once
def answer(store: Store) -> Selection:
    """At equal weights, over all cases, without the reference engine."""
    return choose(store, Wish())


def asked_of_several(store: Store) -> bool:
    """Were two engines of others asked at least, and is one left? That nothing else can express a scene is an answer too."""
    chosen = answer(store)
    return chosen.rank is not None and chosen.asked > 1


@dataclass(frozen=True)
class Grounds:
    """What the answer for a purpose leans on.

    Terms:
        purpose: its name, '' of all cases alike. heading: what it is, in words.
        rows: where an engine falls short of what is asked, worst first, by criterion, case and engine.
        full: how many do not fall short. file: of all of them.
    """

    purpose: str
    heading: str
    rows: Sequence[tuple[tuple[str, str, str], Datum]]
    full: int
    file: str


def evidence_by_purpose(store: Store) -> Iterator[tuple[Grounds, Selection]]:
    """That of all cases alike, and that of each purpose, with the answers."""
    for name, chosen in {"": answer(store), **answers_by_purpose(store)}.items():
        rows = sorted(chosen.evidence.table.items(), key=lambda row: (row[1].value, *row[0]))
        short = [row for row in rows if row[1].value < 1]
        title = read_preset(name).title if name else "All cases alike"
        heading = f"{title}: {len(chosen.evidence.cases)} cases, {amount(100 * chosen.wish.max_error)} % error asked for"
        file = f"evidence-{name}.csv" if name else "evidence.csv"
        yield Grounds(name, heading, short, len(rows) - len(short), file), chosen


@dataclass(frozen=True)
class EngineStanding:
    """An engine in the answer for a purpose.

    Terms:
        first: the share of resamples in which it leads, None where there is no contest; share: the same in words.
        leads: is it named alone? within: cases within the error asked for, of those that count, '5/7'.
        speed: in the mean of the cases, error: of the median case, in words.
        setting: its track in words, settings: what that means.
    """

    engine: str
    number: int
    first: float | None
    share: str
    leads: bool
    within: str
    speed: str
    error: str
    track: str
    setting: str
    settings: str


@dataclass(frozen=True)
class PurposeAnswer:
    """A purpose in the shortest: the answer in a sentence, notes beside it, a command that would decide it, engines' standings.

    Terms:
        error: asked for, in words.
        few: are its cases too few for more than a rough share?
        own: is it a scene of the user's own, and nothing else?
    """

    name: str
    title: str
    why: str
    answer: str
    notes: Sequence[str]
    command: str
    standings: Mapping[str, EngineStanding]
    cases: int
    error: str
    few: bool
    own: bool


OWN = "All that this scene was asked counts alike: who ends where the others do, how fast, and who ends at all."
FEWEST = 3
"""Cases of a purpose below which nothing is said of it."""


@once
def answers_by_purpose(store: Store) -> Mapping[str, Selection]:
    """Of each built-in purpose of which the run has cases enough."""
    listed = sorted(preset_names(), key=lambda name: read_preset(name).order)
    chosen = {name: choose(store, read_preset(name).wish()) for name in listed}
    return {name: a for name, a in chosen.items() if a.rank is not None and len(a.evidence.cases) >= FEWEST}


@once
def needs(store: Store) -> list[PurposeAnswer]:
    """The scenes of the user's own, and the built-in purposes of which the run has cases enough."""
    if not asked_of_several(store):
        return []
    own = [_own_need(store, case) for case in by_case(store)]
    presets = ((name, read_preset(name), chosen) for name, chosen in answers_by_purpose(store).items())
    return [
        *(need for need in own if need is not None),
        *(_need(store, name, preset.title, preset.why, chosen) for name, preset, chosen in presets),
    ]


def _own_need(store: Store, case: str) -> PurposeAnswer | None:
    """The purpose of a scene of the user's own: itself. Where nothing else was run, its answer is that of all cases."""
    whole = answer(store)
    mine = whole if whole.evidence.cases.keys() == {case} else choose(store, Wish(cases={escape(case): 1.0}))
    return None if mine.rank is None else _need(store, slug(case), str(cases(store)[case]["title"]), OWN, mine, own=True)


def _need(store: Store, name: str, title: str, why: str, chosen: Selection, *, own: bool = False) -> PurposeAnswer:
    titled: Callable[[str], str] = partial(engine_title, store)
    notes, command = notes_and_command(store, chosen)
    return PurposeAnswer(
        name=name,
        title=title,
        why=why,
        answer=who_leads(chosen, titled),
        notes=notes,
        command=command,
        standings={entry.engine: standing for standing, entry in standings(store, chosen)},
        cases=len(chosen.evidence.cases),
        error=f"{amount(100 * chosen.wish.max_error)} %",
        few=not own and len(chosen.evidence.cases) < FEW,
        own=own,
    )


def notes_and_command(store: Store, chosen: Selection) -> tuple[list[str], str]:
    """What the first two trade, who is beyond the error asked for, what would turn the answer or decide it, and what is not
    known; and the command that would decide it."""
    titled: Callable[[str], str] = partial(engine_title, store)

    def called(name: str) -> str:
        return FAMILIES[name].lower() if name in FAMILIES else str(cases(store)[name]["title"])

    what, command = decisive(chosen, titled, called)
    sentences = [trade(chosen, titled), beyond(chosen, titled, called), *turn_sentences(chosen.turns, titled, called), what]
    sentences += gaps(chosen)
    return [sentence for sentence in sentences if sentence], command


def standings(store: Store, chosen: Selection) -> list[tuple[EngineStanding, Place]]:
    """The engines of an answer, best first."""
    return [(_standing(store, chosen, entry), entry) for entry in (chosen.rank.places if chosen.rank is not None else ())]


def _standing(store: Store, chosen: Selection, entry: Place) -> EngineStanding:
    track = chosen.evidence.tracks[entry.engine]
    speed, error = chosen.evidence.speed(entry.engine), chosen.evidence.error(entry.engine)
    within, judged = chosen.evidence.within(entry.engine)
    return EngineStanding(
        engine=entry.engine,
        number=entry.number,
        first=None if chosen.alone else entry.first,
        share="" if chosen.alone else percent(entry.first),
        leads=bool(chosen.alone) or entry.first > CLEAR,
        within=f"{within}/{judged}" if judged else "",
        speed="" if speed is None else f"{amount(speed, 2)}{TIMES}",
        error="" if error is None else error_percent(error),
        track=track,
        setting=setting_words(store, entry.engine, track),
        settings=_settings(store, entry.engine, track),
    )


def _settings(store: Store, engine: str, track: str) -> str:
    """Those of a track by the catalogue; of any other settings by one of its trials, whose step says nothing of the others."""
    tracks = store.catalogue.get("engines", {}).get(engine, {}).get("tracks", {})
    if track in tracks:
        return settings_text(tracks[track])
    texts = store.trials["settings"][(store.trials["engine"] == engine) & (store.trials["track"] == track)]
    return settings_text(stepless(str(texts.iloc[0]))) if len(texts) else ""


def live(store: Store) -> Markup:
    """The evidence for each purpose as JSON for the page's script; '<' is written so that nothing in it can end the element."""
    content = {
        "draws": DRAWS,
        "seed": SEED,
        "doubt": DOUBT_OF_WEIGHTS,
        "decades": DECADES_OF_SPEED,
        "clear": CLEAR,
        "few": FEW,
        "sentences": dict(SENTENCES),
        "purposes": [
            _purpose(store, "", "everything alike", "", Wish(), answer(store)),
            *(
                _purpose(store, name, preset.title, preset.why, preset.wish(), chosen)
                for name, chosen in answers_by_purpose(store).items()
                for preset in (read_preset(name),)
            ),
        ],
    }
    return Markup(json.dumps(content, separators=(",", ":")).replace("<", "\\u003c").replace("&", "\\u0026"))


def _purpose(store: Store, name: str, title: str, why: str, wish: Wish, chosen: Selection) -> dict[str, Any]:
    """What is known for one purpose. cells: criterion, case and engine by number, with value, low and high; of a speed these
    are times real time, and 1 after them if it is a bound. A speed of 0 is of no use."""
    evidence = chosen.evidence
    about, known = store.catalogue.get("engines", {}), cases(store)
    names, engines = list(evidence.cases), list(evidence.engines)
    notes, command = notes_and_command(store, chosen)
    criteria = [criterion for criterion in CRITERIA if any(key[0] == criterion for key in evidence.table)]
    families = list(dict.fromkeys(evidence.families[case] for case in names))
    shown = {s.engine: [s.within, s.speed, s.error] for s, _ in standings(store, chosen)}
    cells: list[list[float | int]] = []
    for (criterion, case, engine), datum in evidence.table.items():
        values = [datum.value, datum.low, datum.high]
        if criterion == "speed":
            speed = evidence.speeds.get((case, engine))
            values = [0, 0, 0, 0] if speed is None else [speed.times.value, *speed.times.ends, int(speed.bound)]
        cells.append([criteria.index(criterion), names.index(case), engines.index(engine), *values])
    return {
        "name": name,
        "title": title,
        "why": why,
        "criteria": criteria,
        "weights": [wish.weight(criterion) for criterion in criteria],
        "families": [{"name": family, "title": FAMILIES.get(family, family)} for family in families],
        "cases": [
            {"title": known[case]["title"], "family": evidence.families[case], "weight": weight, "own": case in evidence.own}
            for case, weight in evidence.cases.items()
        ],
        "engines": [
            {
                "name": engine,
                "title": engine_title(store, engine),
                "setting": setting_words(store, engine, evidence.tracks[engine]),
                "features": list(about.get(engine, {}).get("features", ())),
                "shown": shown.get(engine, ["", "", ""]),
            }
            for engine in engines
        ],
        "cells": cells,
        "asked": chosen.asked,
        "notes": notes,
        "command": command,
        "others": any(drop.requirement != EXPRESSED for drop in chosen.dropped),
    }
