"""What a run folder says of each engine and case, on one scale: 1 is as good as is asked, 0 is of no use.

Errors and prices are compared by their logarithms: a hundred times the bound, or a hundred times the cheapest, is no use.
"""

import json
import math
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import lru_cache
from statistics import median
from typing import Any, TypeVar

from plumbline.harness.findings.agreement import AGREED_TRUTH
from plumbline.harness.findings.limits_found import CONSTANT, searches_if_described
from plumbline.harness.findings.prices import PER_SECOND, Price, priced
from plumbline.harness.findings.selection.wish import Wish
from plumbline.harness.findings.steps_taken import substeps_of, substeps_taken
from plumbline.harness.findings.tables.agreement import TABLE as AGREEMENT
from plumbline.harness.findings.tables.determinism import agreements as repetitions
from plumbline.harness.metric.titles import metric_title
from plumbline.harness.store.rows import records
from plumbline.harness.store.store import Store

BOUND = "at most"
"""The verdict on a price that is none: the coarsest step that was run errs less already, so that it is an upper bound."""

DECADES = 2.0
"""Powers of ten from what is as good as asked down to no use."""

_ANSWERED = ("passed", "failed")
_NOT_ASKED = ("unavailable", "interrupted")
_JUDGED = ["trial", "case", "engine", "track", "dt", "resolved", "status", "reason"]
"""Columns of a trial that are read here."""
_AGREED = {"agrees": 1.0}
"""Of the verdicts on a scene without a truth; any other is an answer that the others do not share, or none."""


@dataclass(frozen=True, kw_only=True)
class Datum:
    """One engine in one case by one criterion. value: 0 to 1. low, high: its interval; equal to it where it has none. trial:
    the run that it leans on. says: the figure behind it, with its unit. track, dt [s], substeps: the settings of that run.
    bounded: is nothing known but that it lies between the two, of which the value is the middle?"""

    value: float
    low: float
    high: float
    trial: str = ""
    says: str = ""
    track: str = ""
    dt: float | None = None
    substeps: int = 1
    bounded: bool = False


Table = Mapping[tuple[str, str, str], Datum]
"""By criterion, case and engine."""


@dataclass(frozen=True, kw_only=True)
class Evidence:
    """All of it. engines: in the store's order. cases: that count, to weights. families: of these. tracks: on which each engine
    is judged, the better of its own. table: criterion, case and engine to what is known, where it is known of all engines.
    incomplete: criterion and case where it is not. covered: of each engine the share of all pairs of which something is known.
    costs: prices by case and engine. own: the cases that are scenes of the user's own."""

    engines: tuple[str, ...] = ()
    cases: Mapping[str, float] = field(default_factory=dict)
    families: Mapping[str, str] = field(default_factory=dict)
    tracks: Mapping[str, str] = field(default_factory=dict)
    table: Table = field(default_factory=dict)
    incomplete: tuple[tuple[str, str], ...] = ()
    covered: Mapping[str, float] = field(default_factory=dict)
    costs: Mapping[tuple[str, str], Price] = field(default_factory=dict)
    own: frozenset[str] = frozenset()


def _useful(times: float) -> float:
    """1 up to once, 0 from 10^DECADES times on, by the logarithm between."""
    return min(1.0, max(0.0, 1.0 - math.log10(times) / DECADES)) if times > 0 and math.isfinite(times) else float(times <= 0)


def _margin(row: Mapping[str, object], measured: Sequence[Mapping[str, object]]) -> tuple[float, str]:
    """By how many times the worst check of a trial is beyond its bound, and which."""
    if row["status"] == "passed":
        return 1.0, "every check holds"
    worst, says = 1.0, str(row["reason"])
    for m in measured:
        value, bound = m["value"], m["at_most"]
        if m["passed"] is not False or not isinstance(value, float) or not isinstance(bound, float):
            continue
        pair = sorted((abs(value), abs(bound)))
        times = pair[1] / pair[0] if pair[0] > 0 else math.inf
        if times > worst:
            worst, says = times, f"{metric_title(str(m['metric']))} {float(f'{times:.2g}'):g} times beyond its bound"
    return (worst if worst > 1.0 else math.inf), says


_By = TypeVar("_By", bound=tuple[str, ...])


def _of_cases(data: Mapping[_By, Datum], cases: Mapping[str, float]) -> dict[_By, Datum]:
    return {key: datum for key, datum in data.items() if key[0] in cases}


@lru_cache(maxsize=1)
def _judged(store: Store) -> Mapping[tuple[str, str, str], list[dict[str, Any]]]:
    """The trials that say something of an engine, with the columns `_JUDGED`, by case, engine and track."""
    groups: dict[tuple[str, str, str], list[dict[str, Any]]] = {}
    for row in records(store.asked.loc[~store.asked["status"].isin(_NOT_ASKED), _JUDGED]):
        groups.setdefault((row["case"], row["engine"], row["track"]), []).append(row)
    return groups


@lru_cache(maxsize=1)
def _accuracy(store: Store) -> dict[tuple[str, str, str], Datum]:
    """By case, engine and track; worked out once for all that is asked of one store."""
    failed = store.measurements[store.measurements["passed"].eq(False).fillna(False)]
    measured: dict[str, list[Mapping[str, object]]] = {}
    for m in records(failed):
        measured.setdefault(str(m["trial"]), []).append(m | {"passed": False})
    data: dict[tuple[str, str, str], Datum] = {}
    for (case, engine, track), group in _judged(store).items():
        own = store.catalogue.get("cases", {}).get(case, {}).get("dt") or median(row["dt"] for row in group)
        row = min(group, key=lambda row: abs(math.log(row["dt"] / own)))
        about: dict[str, Any] = {"trial": str(row["trial"]), "track": str(track), "dt": float(row["dt"])}
        about["substeps"] = substeps_of(str(row["resolved"]))
        if row["status"] not in _ANSWERED:
            data[case, engine, track] = Datum(value=0.0, low=0.0, high=0.0, says=f"{row['status']}: {row['reason']}", **about)
            continue
        times, says = _margin(row, measured.get(str(row["trial"]), ()))
        value = _useful(times)
        data[case, engine, track] = Datum(value=value, low=value, high=value, says=says, **about)
    for row in AGREEMENT.rows(store):
        if (row["case"], row["engine"], row["track"]) in data:
            value = _AGREED.get(str(row["verdict"]), 0.0)
            finest = json.loads(row["trials"])[-1:]
            trial = str(finest[0]) if finest else ""
            about = {"trial": trial, "track": str(row["track"]), "says": str(row["verdict"])}
            data[row["case"], row["engine"], row["track"]] = Datum(value=value, low=value, high=value, **about)
    return data


@lru_cache(maxsize=1)
def _robustness(store: Store) -> dict[tuple[str, str, str], Datum]:
    data: dict[tuple[str, str, str], Datum] = {}
    for (case, engine, track), group in _judged(store).items():
        silent = [row for row in group if row["status"] not in _ANSWERED]
        answered = len(group) - len(silent)
        share = answered / len(group)
        says = f"{answered} of {len(group)} runs have an answer"
        trial = str((silent or group)[0]["trial"])
        data[case, engine, track] = Datum(value=share, low=share, high=share, trial=trial, says=says, track=str(track))
    return data


@lru_cache(maxsize=1)
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
        datum = Datum(value=low, low=low, high=high, says=says, **about)
        known = data.get((search.case, search.engine))
        if known is None or datum.value > known.value:
            data[search.case, search.engine] = datum
    return data


@lru_cache(maxsize=1)
def _determinism(store: Store) -> dict[tuple[str, str], Datum]:
    groups: dict[tuple[str, str], list[bool]] = {}
    trials: dict[tuple[str, str], str] = {}
    for repetition in repetitions(store):
        if repetition.must and repetition.verdict in ("bit-identical", "differs"):
            key = repetition.case, repetition.engine
            groups.setdefault(key, []).append(repetition.verdict == "bit-identical")
            trials.setdefault(key, repetition.trial)
    return {
        key: Datum(
            value=(share := sum(same) / len(same)),
            low=share,
            high=share,
            trial=trials[key],
            says=f"{sum(same)} of {len(same)} repetitions have the same bits",
        )
        for key, same in groups.items()
    }


def _prices(store: Store, cases: Mapping[str, float], target: float) -> dict[tuple[str, str], Price]:
    """At the nearest target, in cases whose costs are those of steps; the costliest variant of a case.

    The coarsest step of a scene of the user's own is theirs: what an engine costs there, all at the same step, is its price."""
    own = _own(store)
    data: dict[tuple[str, str], Price] = {}
    listed = [price for price in priced(store).prices if price.case in cases and price.unit == PER_SECOND]
    targets = sorted({price.target for price in listed}, key=lambda t: abs(math.log(t / target)))
    for price in listed:
        if price.target == targets[0] and price.verdict != "not clocked":
            known = data.get((price.case, price.engine))
            if known is None or price.cost is None or (known.cost is not None and price.cost > known.cost):
                asked = price.verdict == BOUND and price.case in own
                data[price.case, price.engine] = replace(price, verdict="priced") if asked else price
    return data


def _better_track(
    engine: str,
    by_track: Mapping[tuple[str, str, str], Datum],
    cases: Mapping[str, float],
    costs: Mapping[tuple[str, str], Price],
) -> str:
    """Of an engine's tracks the one that errs less over all cases; where they are level, that of most of its prices; the tuned
    one where these are level too, which is for that."""
    totals: dict[str, float] = {}
    for (case, name, track), datum in by_track.items():
        if name == engine:
            totals[track] = totals.get(track, 0.0) + cases[case] * datum.value
    priced_on = Counter(price.track for (_, name), price in costs.items() if name == engine and price.cost is not None)
    return max(sorted(totals, reverse=True), key=lambda track: (totals[track], priced_on[track]), default="")


def gather(store: Store, wish: Wish, engines: Sequence[str]) -> Evidence:
    """What the store says of these engines in the cases that count."""
    catalogue = store.catalogue.get("cases", {})
    named = [str(case) for case in dict.fromkeys(store.trials["case"])]
    families = {case: str(catalogue.get(case, {}).get("family") or case.partition("_")[0]) for case in named}
    cases = {case: weight for case in named if (weight := wish.weight_of_case(case, families[case])) > 0}
    accuracy, robustness = _of_cases(_accuracy(store), cases), _of_cases(_robustness(store), cases)
    costs = {key: price for key, price in _prices(store, cases, wish.max_error).items() if key[1] in engines}
    tracks = {engine: _better_track(engine, accuracy, cases, costs) for engine in engines}
    found: dict[tuple[str, str, str], Datum] = {}
    for criterion, by_track in (("accuracy", accuracy), ("robustness", robustness)):
        for (case, engine, track), datum in by_track.items():
            if engine in tracks and track == tracks[engine]:
                found[criterion, case, engine] = datum
    for criterion, by_engine in (("limits", _limits(store)), ("determinism", _determinism(store))):
        here = _of_cases(by_engine, cases)
        found |= {(criterion, case, engine): datum for (case, engine), datum in here.items() if engine in tracks}
    found |= _capability(store, cases, tracks) | _of_prices(costs)
    table, incomplete = _complete(found, engines)
    return Evidence(
        engines=tuple(engines),
        cases=cases,
        families=families,
        tracks=tracks,
        table=table,
        incomplete=incomplete,
        covered=_covered(found, engines),
        costs=costs,
        own=_own(store) & cases.keys(),
    )


def _own(store: Store) -> frozenset[str]:
    return frozenset(
        str(name) for name, about in store.catalogue.get("cases", {}).items() if about.get("truth") == AGREED_TRUTH
    )


def _capability(store: Store, cases: Mapping[str, float], tracks: Mapping[str, str]) -> dict[tuple[str, str, str], Datum]:
    return {
        ("capability", case, engine): datum
        for (case, engine), datum in _capabilities(store).items()
        if case in cases and engine in tracks
    }


@lru_cache(maxsize=1)
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
        data[str(case), str(engine)] = Datum(value=value, low=value, high=value, trial=str(row["trial"]), says=says)
    return data


def _unit_of_prices(prices: Sequence[Price]) -> float | None:
    """The cost that counts as 1 in a case: the least price, or the largest bound that is no more than it.

    Of two bounds below the least price the larger is taken, so that neither is ahead of the other, and what costs more is
    behind both by no more than either shows.
    """
    exact = min((price.cost for price in prices if price.cost and price.verdict != BOUND), default=math.inf)
    return max((p.cost for p in prices if p.cost and p.verdict == BOUND and p.cost <= exact), default=_finite(exact))


def _finite(cost: float) -> float | None:
    return cost if math.isfinite(cost) else None


def _of_prices(costs: Mapping[tuple[str, str], Price]) -> dict[tuple[str, str, str], Datum]:
    """Prices over the unit of their case. A bound is an interval from what it shows up to as good as is asked: where it is
    above another's price, neither is shown to be the cheaper."""
    data: dict[tuple[str, str, str], Datum] = {}
    for case in dict.fromkeys(case for case, _ in costs):
        here = {engine: price for (of, engine), price in costs.items() if of == case}
        unit = _unit_of_prices(list(here.values()))
        if unit is None:
            continue
        for engine, price in here.items():
            about: dict[str, Any] = {"trial": price.trial, "track": price.track, "dt": price.dt}
            about["substeps"] = price.substeps or 1
            if price.cost is None:
                best = f", best {price.best_error:.2g}" if price.best_error is not None else ""
                data["price", case, engine] = Datum(value=0, low=0, high=0, says=f"{price.verdict}{best}", **about)
                continue
            low, high = (price.low or price.cost), (price.high or price.cost)
            says = f"{float(f'{1 / price.cost:.3g}'):g} times real time"
            if price.verdict == BOUND:
                least = _useful(price.cost / unit)
                says = f"at least {says}: no coarser step was run"
                middle = (least + 1) / 2
                data["price", case, engine] = Datum(value=middle, low=least, high=1.0, says=says, bounded=least < 1, **about)
                continue
            values = {"value": price.cost / unit, "low": high / unit, "high": low / unit}
            useful: dict[str, Any] = {name: _useful(times) for name, times in values.items()}
            data["price", case, engine] = Datum(says=says, **useful, **about)
    return data


def _covered(found: Table, engines: Sequence[str]) -> dict[str, float]:
    pairs = {key[:2] for key in found}
    return {engine: sum((*pair, engine) in found for pair in pairs) / max(len(pairs), 1) for engine in engines}


def _complete(found: Table, engines: Sequence[str]) -> tuple[Table, tuple[tuple[str, str], ...]]:
    """What is known of every engine, and the pairs of criterion and case that are not: those compare nothing."""
    pairs = dict.fromkeys((criterion, case) for criterion, case, _ in found)
    open_ = tuple(pair for pair in pairs if any((*pair, engine) not in found for engine in engines))
    return {key: datum for key, datum in found.items() if key[:2] not in open_}, open_
