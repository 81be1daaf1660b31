"""What fails, by its cause, as rows and words for a page."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

from plumbline.harness.findings.causes import FAILED, CaseResult, Cause, causes
from plumbline.harness.findings.once import once
from plumbline.harness.store.store import Store
from plumbline.reports.tables.own_scenes import by_case
from plumbline.reports.tables.verdicts import CaseVerdict, verdicts
from plumbline.reports.words.catalogue import cases, engines, named_tracks, setting_words
from plumbline.reports.words.known_findings import by_engine
from plumbline.reports.words.text import join_words, plural


@dataclass(frozen=True, slots=True)
class Failing:
    """A case that fails: its title, and the cell that says by how much."""

    case: str
    title: str
    cell: CaseVerdict


@dataclass(frozen=True, slots=True)
class Failure:
    """One cause with what it makes fail.

    Terms: setting: the track, or the setting, in words; what: the cause; verdict: 'fails 4 cases', with what cures them.
    """

    cause: Cause
    setting: str
    what: str
    verdict: str
    cases: Sequence[Failing]


@once
def failing(store: Store) -> tuple[Failure, ...]:
    """All causes of failures at the cases' own steps, on the tracks that the study names, engine by engine and track by track;
    in each cause the heaviest first."""
    apart, named = by_case(store), named_tracks(store)
    cells = {key: cell for key, cell in verdicts(store).items() if key[0] not in apart and key[2] in named and cell.trial}
    answers = [
        CaseResult(case, engine, track, cell.trial, cell.own.name if cell.own.name in (*FAILED, "passed") else "")
        for (case, engine, track), cell in cells.items()
    ]
    shelf = [finding for group in by_engine(store).values() for finding in group]
    return tuple(_worded(store, cause, cells) for cause in causes(store, answers, shelf))


def _worded(store: Store, cause: Cause, cells: dict[tuple[str, str, str], CaseVerdict]) -> Failure:
    listed = [
        Failing(answer.case, str(cases(store)[answer.case]["title"]), cells[answer.case, answer.engine, answer.track])
        for answer in cause.failures
    ]
    count = len(listed)
    verdict = (
        f"{plural(count, 'case')} {'fails' if count == 1 else 'fail'}"
        if cause.by == "unexplained"
        else f"fails {plural(count, 'case')}"
    )
    tracks = [track for track in engines(store)[cause.engine]["tracks"] if track != cause.track]
    if cause.cured and len(tracks) == 1:
        several = (
            "all of which pass"
            if len(cause.cured) == count
            else f"of which {len(cause.cured)} {'passes' if len(cause.cured) == 1 else 'pass'}"
        )
        verdict += f", {'which passes' if count == 1 else several} {tracks[0]}"
    setting = setting_words(store, cause.engine, cause.track)
    return Failure(cause, setting, _what(cause), verdict, sorted(listed, key=_weight, reverse=True))


def _what(cause: Cause) -> str:
    if cause.finding is not None:
        return cause.finding.cause or cause.finding.title
    if cause.by == "effect":
        return f"{join_words(effect.replace('_', ' ') for effect in cause.effects)}, not as the scene asks"
    if cause.by == "emulated":
        return f"laws that the adapter makes ({join_words(feature.replace('_', ' ') for feature in cause.features)})"
    return "no declared cause,"


def _weight(listed: Failing) -> float:
    return listed.cell.margin.times if listed.cell.margin is not None else math.inf
