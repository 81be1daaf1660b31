"""What a run folder says of each engine and case, on one scale: 1 is as good as is asked, 0 is of no use.

Errors and speeds are compared by their logarithms: ten times the error asked for, or a hundredth of the highest speed, is of no
use. Each engine is judged at one of its settings, the same in all cases of a purpose.
"""

import math
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from operator import attrgetter, itemgetter
from statistics import geometric_mean, median
from typing import Any, TypeVar

from plumbline.harness.findings.agreement.found import AGREED_TRUTH, agreements
from plumbline.harness.findings.limits_found import CONSTANT, searches_if_described
from plumbline.harness.findings.once import once
from plumbline.harness.findings.parameter_words import substeps_of, substeps_taken
from plumbline.harness.findings.prices import priced
from plumbline.harness.findings.selection.wish import Wish
from plumbline.harness.findings.speed import BEYOND, Side, Speed, speeds
from plumbline.harness.findings.tables.determinism import repetitions
from plumbline.harness.metric.titles import metric_title
from plumbline.harness.store.rows import grouped, number, records
from plumbline.harness.store.store import Store

DECADES_OF_ERROR, DECADES_OF_SPEED = math.log10(BEYOND), 2.0
"""Powers of ten from what is as good as asked down to no use."""
SEVERAL = 3
"""Runs of an engine in a case below which their share with an answer says nothing of how robust it is."""

_ANSWERED = ("passed", "failed")
_NOT_ASKED = ("unavailable", "interrupted")
_JUDGED = ["trial", "case", "engine", "track", "dt", "resolved", "status", "reason"]
"""Columns of a trial that are read here."""
_AGREED = {"agrees": 1.0}
"""Of the verdicts on a scene without a truth; any other is an answer that the others do not share, or none."""


@dataclass(frozen=True, kw_only=True)
class Datum:
    """One engine in one case by one criterion. value: 0 to 1. low, high: its 95 % interval; equal to it where it has none.
    trial: the run that it leans on. says: the figure behind it, with its unit. track, dt [s], substeps: that run's settings.
    figure: the error as a share of the case's scale, or the speed in times real time; None of other criteria."""

    value: float
    low: float
    high: float
    trial: str = ""
    says: str = ""
    track: str = ""
    dt: float | None = None
    substeps: int = 1
    figure: float | None = None

    @classmethod
    def of(cls, value: float, low: float | None = None, high: float | None = None, **about: Any) -> "Datum":
        """Args: low, high: the value itself unless given."""
        return cls(value=value, low=value if low is None else low, high=value if high is None else high, **about)


Table = Mapping[tuple[str, str, str], Datum]
"""By criterion, case and engine."""


@dataclass(frozen=True, kw_only=True)
class Evidence:
    """All of it. engines: in the store's order. cases: that count, to weights. families: of these. tracks: on which each engine
    is judged. table: criterion, case and engine to what is known, where it is known of all engines. incomplete: criterion and
    case where it is not. covered: of each engine the share of pairs known of most engines. speeds: by case and
    engine, on these tracks. own: the cases that are scenes of the user's own."""

    engines: tuple[str, ...] = ()
    cases: Mapping[str, float] = field(default_factory=dict)
    families: Mapping[str, str] = field(default_factory=dict)
    tracks: Mapping[str, str] = field(default_factory=dict)
    table: Table = field(default_factory=dict)
    incomplete: tuple[tuple[str, str], ...] = ()
    covered: Mapping[str, float] = field(default_factory=dict)
    speeds: Mapping[tuple[str, str], Speed] = field(default_factory=dict)
    own: frozenset[str] = frozenset()

    def error(self, engine: str) -> float | None:
        """The median over the cases of an engine's error, a share of their scale; None where it has none in half of them."""
        mine = [datum for (of, _, name), datum in self.table.items() if (of, name) == ("accuracy", engine)]
        figures = [datum.figure for datum in mine if datum.figure is not None]
        return median(figures) if figures and 2 * len(figures) >= len(mine) else None

    @cached_property
    def compared(self) -> tuple[str, ...]:
        """The cases in which each engine has a speed, of the engines that have one in half of the cases."""
        mine = {engine: {case for case, name in self.speeds if name == engine} for engine in self.engines}
        fast = [cases for cases in mine.values() if 2 * len(cases) >= len(self.cases)]
        return tuple(case for case in self.cases if fast and all(case in cases for cases in fast))

    def speed(self, engine: str) -> float | None:
        """The geometric mean of an engine's speeds over the cases `compared`, in times real time, so that ratios of such means
        are means of ratios; None where it lacks one."""
        mine = [self.speeds[case, engine].times.value for case in self.compared if (case, engine) in self.speeds]
        return geometric_mean(mine) if mine and len(mine) == len(self.compared) else None

    def beyond(self, engine: str) -> tuple[str, ...]:
        """The cases in which an engine errs by more than was asked, or breaks another check."""
        judged = self.table.items()
        return tuple(case for (of, case, name), datum in judged if (of, name) == ("accuracy", engine) and datum.value < 1)

    def within(self, engine: str) -> tuple[int, int]:
        """In how many cases an engine errs by no more than was asked and holds every other check, and of how many."""
        judged = sum((of, name) == ("accuracy", engine) for of, _, name in self.table)
        return judged - len(self.beyond(engine)), judged


def _useful(times: float, decades: float) -> float:
    """1 up to once, 0 from 10^decades times on, by the logarithm between."""
    return min(1.0, max(0.0, 1.0 - math.log10(times) / decades)) if times > 0 and math.isfinite(times) else float(times <= 0)


def _beyond(row: Mapping[str, object], measured: Sequence[Mapping[str, object]], headline: str) -> tuple[float, str]:
    """By how many times the worst check of a trial is beyond its bound, and which; that of the error asked for left out."""
    worst, says = 1.0, ""
    for m in measured:
        value, bound = m["value"], m["at_most"]
        if m["metric"] == headline or not isinstance(value, float) or not isinstance(bound, float):
            continue
        pair = sorted((abs(value), abs(bound)))
        times = pair[1] / pair[0] if pair[0] > 0 else math.inf
        if times > worst:
            beyond = f"{float(f'{times:.2g}'):g} times its bound" if math.isfinite(times) else f"{value:.2g}, bound {bound:.2g}"
            worst, says = times, f"{metric_title(str(m['metric']))} {beyond}"
    if worst == 1.0 and row["status"] == "failed" and not any(m["metric"] == headline for m in measured):
        return math.inf, str(row["reason"])
    return worst, says


_By = TypeVar("_By", bound=tuple[str, ...])


def _of_cases(data: Mapping[_By, Datum], cases: Mapping[str, float]) -> dict[_By, Datum]:
    return {key: datum for key, datum in data.items() if key[0] in cases}


@once
def _judged(store: Store) -> Mapping[Side, list[dict[str, Any]]]:
    """The trials that say something of an engine, with the columns `_JUDGED`, by case, engine and track."""
    judged = store.asked.loc[~store.asked["status"].isin(_NOT_ASKED), _JUDGED]
    return grouped(records(judged), itemgetter("case", "engine", "track"))


@once
def _failing(store: Store) -> Mapping[str, list[dict[str, Any]]]:
    """The measurements that failed a check, by trial."""
    failed = store.measurements[store.measurements["passed"].eq(False).fillna(False)]
    return grouped(records(failed), itemgetter("trial"))


@once
def _accuracy(store: Store, target: float) -> dict[Side, Datum]:
    """By case, engine and track, of the run that the speed is taken from; without one, of the run at the case's own step."""
    prices, fast, about_cases = priced(store), speeds(store, target), store.catalogue.get("cases", {})
    data: dict[Side, Datum] = {}
    for (case, engine, track), group in _judged(store).items():
        speed, about = fast.get((case, engine, track)), about_cases.get(case, {})
        own = about.get("dt") or median(row["dt"] for row in group)
        row = min(group, key=lambda row: abs(math.log(row["dt"] / own)))
        if speed is not None:
            row = next(row for row in group if row["trial"] == speed.at.trial)
        settings: dict[str, Any] = {"trial": str(row["trial"]), "track": str(track), "dt": float(row["dt"])}
        settings["substeps"] = substeps_of(str(row["resolved"]))
        if row["status"] not in _ANSWERED:
            data[case, engine, track] = Datum.of(0.0, says=f"{row['status']}: {row['reason']}", **settings)
            continue
        error = speed.error if speed is not None else prices.error(settings["trial"], case)
        headline = str(about.get("headline", "")) if error is not None else ""
        times, says = _beyond(row, _failing(store).get(settings["trial"], ()), headline)
        if error is not None and error / target >= times:
            times, says = error / target, f"an error of {error:.2g} of the scale"
        value = _useful(times, DECADES_OF_ERROR)
        data[case, engine, track] = Datum.of(value, says=says or "every check holds", figure=error, **settings)
    for agreement in agreements(store):
        for side in agreement.sides:
            if (key := (agreement.case, side.engine, side.track)) in data:
                trial = side.limit.rungs[-1].trial if side.limit.rungs else ""
                about = {"trial": trial, "track": side.track, "says": side.word}
                data[key] = Datum.of(_AGREED.get(side.word, 0.0), figure=data[key].figure, **about)
    return data


@once
def _robustness(store: Store) -> dict[Side, Datum]:
    data: dict[Side, Datum] = {}
    for (case, engine, track), group in _judged(store).items():
        if len(group) >= SEVERAL:
            silent = [row for row in group if row["status"] not in _ANSWERED]
            answered = len(group) - len(silent)
            says = f"{answered} of {len(group)} runs have an answer"
            trial = str((silent or group)[0]["trial"])
            data[case, engine, track] = Datum.of(answered / len(group), trial=trial, says=says, track=str(track))
    return data


@once
def _limits(store: Store) -> dict[tuple[str, str], Datum]:
    """The farthest of an engine's tracks in each case, without remedies; between what held and the next that was tried."""
    data: dict[tuple[str, str], Datum] = {}
    taken = substeps_taken(store)
    for search in searches_if_described(store):
        if search.remedy or search.parts or search.verdict in ("unavailable", "stopped", CONSTANT):
            continue
        held = search.holds[-1] if search.holds else None
        low, high = (held.reach, max(held.further, held.reach)) if held else (0.0, 0.0)
        says = f"{search.axis} held to {search.held:.3g} {search.unit}" if search.held is not None else search.verdict
        about: dict[str, Any] = {"trial": search.trial_held or search.trial_broke, "track": search.track, "dt": search.dt}
        about["substeps"] = taken.get(about["trial"], 1)
        datum = Datum.of(low, low, high, says=says, **about)
        known = data.get((search.case, search.engine))
        if known is None or datum.value > known.value:
            data[search.case, search.engine] = datum
    return data


@once
def _determinism(store: Store) -> dict[tuple[str, str], Datum]:
    binding = (each for each in repetitions(store) if each.must and each.verdict in ("bit-identical", "differs"))
    data = {}
    for key, mine in grouped(binding, attrgetter("case", "engine")).items():
        same = sum(each.verdict == "bit-identical" for each in mine)
        says = f"{same} of {len(mine)} repetitions have the same bits"
        data[key] = Datum.of(same / len(mine), trial=mine[0].trial, says=says)
    return data


@once
def _unclocked(store: Store) -> frozenset[tuple[str, str]]:
    """Cases and engines with an answer and no time of a step: nothing is known of their speed."""
    timed = store.asked[store.asked["status"].isin(_ANSWERED)]
    paced = timed["cpu_per_sim_s"].map(lambda cost: math.isfinite(number(cost)))
    return frozenset(zip(timed["case"], timed["engine"], strict=True)) - frozenset(
        zip(timed["case"][paced], timed["engine"][paced], strict=True)
    )


def _speed(store: Store, chosen: Mapping[tuple[str, str], Speed], accuracy: Table, unit: Mapping[str, float]) -> Table:
    """Speeds over the highest of their case; an engine without a run that counts is of no use there.

    Args: accuracy: on the same tracks. unit: the highest speed by case."""
    data: dict[tuple[str, str, str], Datum] = {}
    for (_, case, engine), judged in accuracy.items():
        speed = chosen.get((case, engine))
        if case not in unit or (speed is None and (case, engine) in _unclocked(store)):
            continue
        if speed is None:
            says = "no run passes its checks" if judged.figure is not None or judged.value > 0 else judged.says
            data["speed", case, engine] = Datum.of(0.0, says=says, trial=judged.trial, track=judged.track, dt=judged.dt)
            continue
        value, low, high = (_useful(unit[case] / times, DECADES_OF_SPEED) for times in (speed.times.value, *speed.times.ends))
        data["speed", case, engine] = Datum.of(
            value,
            low,
            high,
            trial=speed.at.trial,
            says=speed.words,
            track=judged.track,
            dt=speed.at.dt,
            substeps=speed.at.substeps,
            figure=speed.times.value,
        )
    return data


def _settings(engine: str, accuracy: Mapping[Side, Datum], fast: Mapping[Side, Speed], cases: Mapping[str, float]) -> str:
    """The track of an engine that is best in accuracy and speed over all cases, of those that were run in most of them.

    A setting that a search went on to stands in few cases, and says nothing of the others. Of equals the one that sorts last:
    'tuned' before 'default'."""
    of = [side for side in accuracy if side[1] == engine]
    ran = {track: sum(side[2] == track for side in of) for track in {side[2] for side in of}}
    most = max(ran.values(), default=0)
    highest = _highest({(case, f"{name} {track}"): speed for (case, name, track), speed in fast.items() if case in cases})

    def score(track: str) -> float:
        total = 0.0
        for side in of:
            if side[2] == track:
                speed = fast.get(side)
                useful = 0.0 if speed is None else _useful(highest[side[0]] / speed.times.value, DECADES_OF_SPEED)
                total += cases[side[0]] * (accuracy[side].value + useful)
        return total

    return max(sorted((track for track in ran if ran[track] == most), reverse=True), key=score, default="")


def _highest(chosen: Mapping[tuple[str, str], Speed]) -> dict[str, float]:
    highest: dict[str, float] = {}
    for (case, _), speed in chosen.items():
        highest[case] = max(speed.times.value, highest.get(case, 0.0))
    return highest


def gather(store: Store, wish: Wish, engines: Sequence[str]) -> Evidence:
    """What the store says of these engines in the cases that count."""
    catalogue = store.catalogue.get("cases", {})
    named = [str(case) for case in dict.fromkeys(store.trials["case"])]
    families = {case: str(catalogue.get(case, {}).get("family") or case.partition("_")[0]) for case in named}
    cases = {case: weight for case in named if (weight := wish.weight_of_case(case, families[case])) > 0}
    accuracy, fast = _of_cases(_accuracy(store, wish.max_error), cases), speeds(store, wish.max_error)
    tracks = {engine: _settings(engine, accuracy, fast, cases) for engine in engines}
    found: dict[tuple[str, str, str], Datum] = {}
    for criterion, by_track in (("accuracy", accuracy), ("robustness", _of_cases(_robustness(store), cases))):
        found |= {
            (criterion, case, engine): datum for (case, engine, track), datum in by_track.items() if tracks.get(engine) == track
        }
    chosen = {
        (case, engine): speed for (case, engine, track), speed in fast.items() if case in cases and tracks.get(engine) == track
    }
    judged = {key: datum for key, datum in found.items() if key[0] == "accuracy"}
    found |= _speed(store, chosen, judged, _highest(chosen))
    for criterion, by_engine in (
        ("limits", _limits(store)),
        ("determinism", _determinism(store)),
        ("capability", _capabilities(store)),
    ):
        here = _of_cases(by_engine, cases)
        found |= {(criterion, case, engine): datum for (case, engine), datum in here.items() if engine in tracks}
    table, incomplete = _complete(found, engines)
    return Evidence(
        engines=tuple(engines),
        cases=cases,
        families=families,
        tracks=tracks,
        table=table,
        incomplete=incomplete,
        covered=_covered(found, engines),
        speeds=chosen,
        own=_own(store) & cases.keys(),
    )


def _own(store: Store) -> frozenset[str]:
    return frozenset(
        str(name) for name, about in store.catalogue.get("cases", {}).items() if about.get("truth") == AGREED_TRUTH
    )


@once
def _capabilities(store: Store) -> dict[tuple[str, str], Datum]:
    """By case and engine."""
    data: dict[tuple[str, str], Datum] = {}
    trials = store.asked.loc[~store.asked["status"].isin(_NOT_ASKED), [*_JUDGED, "steps"]]
    for (case, engine), group in trials.groupby(["case", "engine"], sort=False):
        # An engine that took steps expresses the scene, whatever could not be measured of its answer.
        lacking = group[group["status"].eq("unsupported") & group["steps"].eq(0)]
        value = float(len(lacking) < len(group))
        row = (lacking if len(lacking) else group).iloc[0]
        says = str(row["reason"]) if not value else "can be expressed"
        data[str(case), str(engine)] = Datum.of(value, trial=str(row["trial"]), says=says)
    return data


def _covered(found: Table, engines: Sequence[str]) -> dict[str, float]:
    """Of each engine the share of the pairs of criterion and case that are known of half of the engines at least."""
    known = Counter(key[:2] for key in found if key[2] in engines)
    pairs = [pair for pair, count in known.items() if 2 * count >= len(engines)]
    return {engine: sum((*pair, engine) in found for pair in pairs) / max(len(pairs), 1) for engine in engines}


def _complete(found: Table, engines: Sequence[str]) -> tuple[Table, tuple[tuple[str, str], ...]]:
    """What is known of every engine, and the pairs of criterion and case that are not: those compare nothing."""
    pairs = dict.fromkeys((criterion, case) for criterion, case, _ in found)
    open_ = tuple(pair for pair in pairs if any((*pair, engine) not in found for engine in engines))
    return {key: datum for key, datum in found.items() if key[:2] not in open_}, open_
