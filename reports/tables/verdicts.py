"""The verdict matrix: how the trials of each case, engine and track ended; and an engine's own rows of it, from worst to
best.

What fails, by its cause, as rows and words for a page.
"""

import math
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from plumbline.harness.findings.causes import FAILED, CaseResult, Cause, Margin, causes, margins
from plumbline.harness.findings.once import once
from plumbline.harness.store.store import Store
from plumbline.reports.tables.own_scenes import by_case, chips
from plumbline.reports.tables.trial_results import at_own_step
from plumbline.reports.words.catalogue import cases, engines, families, named_tracks, setting_words
from plumbline.reports.words.emulated_features import EmulatedLaw, every_law
from plumbline.reports.words.known_findings import by_engine
from plumbline.reports.words.status import STATUSES, StatusWord, outcome, reasons, worst
from plumbline.reports.words.text import TIMES, amount, join_words, plural, unit_text

DECADES = 3
"""Powers of ten beyond a bound, or within it, that the shade of a cell tells apart."""
LEAST = 1e-3
"""Share of a bound below which no more is said."""


@dataclass(frozen=True, slots=True)
class CaseVerdict:
    """How an engine did in a case on a track.

    Terms: counts: (outcome, count) of all trials, from good to bad. worst: of them; reason: why it was not better. own: the
    outcome at the case's own step; trial: the one that stands for it there, the worst where there are several; margin: by how
    much that keeps or misses its checks, None where it has no number.
    """

    counts: tuple[tuple[StatusWord, int], ...]
    worst: StatusWord
    reason: str
    own: StatusWord
    trial: str = ""
    margin: Margin | None = None

    @property
    def trials(self) -> int:
        """How many trials stand behind the cell."""
        return sum(count for _, count in self.counts)

    @property
    def words(self) -> str:
        """The margin in a few characters, or the outcome where there is none."""
        return margin_words(self.margin) if self.margin is not None and self.own.answered else self.own.name

    @property
    def shade(self) -> int:
        """0 at the bound, `DECADES` that many powers of ten beyond it or within it, or where there is no number at all."""
        if self.margin is None or not self.own.answered or not 0 < self.margin.times < math.inf:
            return 0 if self.own.rank == 1 else DECADES
        return min(DECADES, math.floor(abs(math.log10(self.margin.times)) + 0.5))

    @property
    def steps(self) -> str:
        """'4 of 6 steps pass', where not all trials ended as the one at the case's own step."""
        passed = sum(count for status, count in self.counts if status.name == "passed")
        return f"{passed} of {self.trials} steps pass" if len(self.counts) > 1 else ""


def margin_words(margin: Margin) -> str:
    """'34\N{MULTIPLICATION SIGN}': the value over its bound; '2 m > 0' where nothing is allowed."""
    if not math.isfinite(margin.times):
        unit = "" if margin.unit in ("", "1") else f" {unit_text(margin.unit)}"
        told = f"{amount(margin.value, 2)}{unit} {'<' if margin.at_most > margin.value else '>'} {amount(margin.at_most, 2)}"
        return told if math.isfinite(margin.value) else "no number"
    if margin.times < LEAST:
        return f"<{amount(LEAST)}{TIMES}"
    # A margin just beyond the bound would read as one at it.
    digits = 4 if 1 < margin.times < 1.01 else 3 if 1 < margin.times < 1.1 else 2
    return f"{amount(float(f'{margin.times:.{digits}g}'), digits)}{TIMES}"


@once
def verdicts(store: Store) -> dict[tuple[str, str, str], CaseVerdict]:
    """Verdicts by (case, engine, track); a cell without a trial has no entry."""
    cells = {}
    known = margins(store)
    own: dict[tuple[str, str, str], list[tuple[int, float, str]]] = {}
    for case, engine, track, trial, status in at_own_step(store, store.asked)[
        ["case", "engine", "track", "trial", "status"]
    ].itertuples(index=False):
        rank = outcome(status).rank
        own.setdefault((case, engine, track), []).append((rank, known[trial].times if trial in known else 0.0, trial))
    statuses = dict(zip(store.asked["trial"], store.asked["status"], strict=True))
    # Of the columns that are read alone: to group the others along costs ten times as much.
    ended, said = store.asked[["case", "engine", "track", "trial", "status"]], reasons(store)
    for key, group in ended.groupby(["case", "engine", "track"], sort=False):
        bad = worst(group["status"])
        worst_of = [trial for status, trial in zip(group["status"], group["trial"], strict=True) if outcome(status) == bad]
        # An engine that was not run at the case's own step is read at its worst.
        trial = max(own[key])[2] if key in own else str(worst_of[0])
        cells[key] = CaseVerdict(
            counted(Counter(group["status"])), bad, said[worst_of[0]], outcome(statuses[trial]), trial, known.get(trial)
        )
    # That all numbers of a scene of one's own are finite is no verdict on it.
    return cells | {key: CaseVerdict(((word, 1),), word, sentence, word) for key, (word, sentence) in chips(store).items()}


def totals(store: Store) -> Mapping[tuple[str, str], Mapping[str, int]]:
    """Cases of every outcome at their own step by (engine, track), zeros included, whose checks say what is right."""
    counts: dict[tuple[str, str], dict[str, int]] = {}
    for (case, engine, track), cell in verdicts(store).items():
        if case not in by_case(store):
            mine = counts.setdefault((engine, track), dict.fromkeys(STATUSES, 0))
            mine[cell.own.name] = mine.get(cell.own.name, 0) + 1
    return counts


def cells_by_family(store: Store) -> list[tuple[str, list[dict[str, Any]]]]:
    """Titles of families with their cases that have a verdict; in each, what the engines of others fail most stands first."""
    cells, known = verdicts(store), engines(store)
    failing: Counter[str] = Counter()
    for (case, engine, _), cell in cells.items():
        if not known[engine]["ours"] and cell.own.rank >= outcome("failed").rank:
            failing[case] += 1
    judged = {case for case, _, _ in cells}
    grouped = [(title, [case for case in listed if case["name"] in judged]) for title, listed in families(store)]
    return [(title, sorted(listed, key=lambda case: -failing[case["name"]])) for title, listed in grouped if listed]


def counted(counts: Mapping[str, int]) -> tuple[tuple[StatusWord, int], ...]:
    """Counts from good to bad."""
    return tuple(sorted(((outcome(name), count) for name, count in counts.items()), key=lambda pair: pair[0].rank))


def cases_of(store: Store, engine: str) -> list[tuple[Mapping[str, Any], Mapping[str, CaseVerdict]]]:
    """The cases that were put to an engine, each with its verdicts by track: the worst outcome on any track first, and among
    equals the larger margin."""
    cells = verdicts(store)
    listed = [
        (case, mine)
        for name, case in cases(store).items()
        if name not in by_case(store)
        and (mine := {track: cells[name, engine, track] for track in named_tracks(store) if (name, engine, track) in cells})
    ]
    return sorted(listed, key=lambda listed_case: max(map(_weight, listed_case[1].values())), reverse=True)


def tracks_of(store: Store, engine: str) -> list[str]:
    """The tracks and settings that the study names on which an engine has a verdict."""
    judged = {track for _, name, track in verdicts(store) if name == engine}
    return [track for track in named_tracks(store) if track in judged]


def _weight(cell: CaseVerdict) -> tuple[int, float]:
    return cell.own.rank, cell.margin.times if cell.margin is not None else 0.0


def by_reason(known_failures: Mapping[str, str]) -> list[tuple[str, list[str]]]:
    """Checks that fail for one reason stand together under it."""
    checks: dict[str, list[str]] = {}
    for check, reason in known_failures.items():
        checks.setdefault(reason, []).append(check)
    return list(checks.items())


def versions_of(store: Store, engine: str) -> list[str]:
    """Those that the trials say."""
    mine = store.trials["engine_version"][store.trials["engine"] == engine]
    return [str(version) for version in mine.unique() if version]


def laws_of(store: Store, engine: str) -> Sequence[tuple[str, EmulatedLaw]]:
    """Every feature that some engine of the run claims, and whose it is on this one; what it lacks first."""
    rows = [(feature, row[engine]) for feature, row in every_law(store) if engine in row]
    order = ("not offered", "emulated", "in part emulated", "own")
    return sorted(rows, key=lambda row: order.index(row[1].word))


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
    return Failure(cause, setting, _what(cause), verdict, sorted(listed, key=_heaviness, reverse=True))


def _what(cause: Cause) -> str:
    if cause.finding is not None:
        return cause.finding.cause or cause.finding.title
    if cause.by == "effect":
        return f"{join_words(effect.replace('_', ' ') for effect in cause.effects)}, not as the scene asks"
    if cause.by == "emulated":
        return f"laws that the adapter makes ({join_words(feature.replace('_', ' ') for feature in cause.features)})"
    return "no declared cause,"


def _heaviness(listed: Failing) -> float:
    return listed.cell.margin.times if listed.cell.margin is not None else math.inf
