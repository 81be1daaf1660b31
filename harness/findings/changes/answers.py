"""What engines answer, exactly: the same bits are the same answer; others are as good, better or worse; a verdict may flip.

So it is between two run folders, and of a trial that was run again.
"""

import json
import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, Literal

from plumbline.harness.adapter.settings import only_here
from plumbline.harness.findings.changes.matching import TrialPair, located
from plumbline.harness.findings.changes.values import Change, ChangeKind, Sense
from plumbline.harness.findings.prices import LEAST
from plumbline.harness.store.record import Record
from plumbline.harness.store.store import Store
from plumbline.harness.trial.ensemble import HELD

SHARE = 0.01
"""Of the bound, or of the error where that is more: what changes by less decides no verdict; it shows in the third digit."""
_RANK = {"passed": 0, "failed": 1, "diverged": 2, "crashed": 3, "oom": 3, "timeout": 3, "unsupported": 4, "unavailable": 5}
"""How far a status is from an answer that holds; an interrupted trial says nothing."""


def as_good(status: str, before: str) -> bool:
    """Is a status no farther from an answer that holds than another one?"""
    return _RANK.get(status, 0) <= _RANK.get(before, len(_RANK))


@dataclass(frozen=True, slots=True)
class _Reading:
    """One metric of a pair. Terms: excess: the difference over what is tolerated. fields: of a `Change` that say what was
    measured; low..high of the ratio by what the truths may be off, None where they are exact."""

    sense: Sense
    excess: float
    fields: Mapping[str, Any]


class _Readings:
    """The metrics that judge a trial, read from both folders."""

    def __init__(self, store_a: Store, store_b: Store) -> None:
        self._cases: Mapping[str, Any] = store_b.catalogue.get("cases", {})
        self._values = [_by_trial(store) for store in (store_a, store_b)]
        self._last_bit = [_last_bit(store, values) for store, values in zip((store_a, store_b), self._values, strict=True)]

    def of(self, pair: TrialPair) -> list[_Reading]:
        """Of the headline and of all that has a bound, the farthest beyond tolerance first."""
        case = self._cases.get(pair.b.case, {})
        here, there = (values.get(row.trial, {}) for values, row in zip(self._values, (pair.a, pair.b), strict=True))
        judging = [
            name
            for name in here
            if name in there and (name in (case.get("headline"), HELD) or not math.isnan(_number(there[name].at_most)))
        ]
        return sorted(
            (self._reading(pair, case, here[name], there[name]) for name in judging), key=lambda reading: -reading.excess
        )

    def _reading(self, pair: TrialPair, case: Mapping[str, Any], a: Any, b: Any) -> _Reading:
        before, after, bound = float(a.value), float(b.value), _number(b.at_most)
        off_a, off_b = (_number(getattr(row, "truth_error", 0.0), 0.0) for row in (a, b))
        better = next(
            (check.get("better", "lower") for check in case.get("checks", ()) if check["metric"] == a.metric), "lower"
        )
        higher = better == "higher" or a.metric == HELD
        last_bit = max(
            bits.get((_cell(row), a.metric), 0.0) for bits, row in zip(self._last_bit, (pair.a, pair.b), strict=True)
        )
        floor = LEAST * float(case.get("scale") or 0.0) if a.metric == case.get("headline") else 0.0
        tolerated = max(
            off_a + off_b,
            last_bit,
            floor,
            SHARE * max(abs(before), abs(after)),
            SHARE * (0.0 if math.isnan(bound) else abs(bound)),
        )
        step = after - before
        if not math.isfinite(step):
            same = before == after or (math.isnan(before) and math.isnan(after))
            excess, sense = 0.0 if same else math.inf, _way(math.isfinite(before), same)
        else:
            excess = abs(step) / tolerated if tolerated > 0 else 0.0
            sense = _way((step > 0) != higher, excess <= 1)
        known = off_a + off_b > 0 and before > off_a
        positive = math.isfinite(step) and before > 0 and after > 0
        fields = {
            "metric": str(a.metric),
            "unit": str(b.unit),
            "before": before,
            "after": after,
            "ratio": after / before if positive else None,
            "low": max(after - off_b, 0.0) / (before + off_a) if positive and known else None,
            "high": (after + off_b) / (before - off_a) if positive and known else None,
        }
        return _Reading(sense, excess, fields)


def _way(worse: bool, tolerated: bool) -> Sense:
    return "within tolerance" if tolerated else "worse" if worse else "better"


def _number(value: Any, none: float = math.nan) -> float:
    return none if value is None or value != value else float(value)


def _by_trial(store: Store) -> dict[str, dict[str, Any]]:
    values: dict[str, dict[str, Any]] = {}
    for row in store.measurements.itertuples():
        values.setdefault(str(row.trial), {})[str(row.metric)] = row
    return values


def _cell(row: Any) -> tuple[Any, ...]:
    return row.case, row.parameters, row.engine, row.track, row.dt


def _last_bit(store: Store, values: Mapping[str, Mapping[str, Any]]) -> dict[tuple[tuple[Any, ...], str], float]:
    """How far the last bit of one coordinate moves each metric, where a run was nudged by it: no answer of a motion that
    multiplies that bit is known better."""
    names = [json.loads(text).get("name", "") for text in store.trials["alteration"]]
    if "nudged" not in names:
        return {}
    rows = list(zip(store.trials.itertuples(), names, strict=True))
    plain = {_cell(row): values.get(row.trial, {}) for row, name in rows if not name}
    moved: dict[tuple[tuple[Any, ...], str], float] = {}
    for row, name in rows:
        if name == "nudged":
            for metric, nudged in values.get(row.trial, {}).items():
                first = plain.get(_cell(row), {}).get(metric)
                if first is not None and math.isfinite(step := abs(float(nudged.value) - float(first.value))):
                    moved[_cell(row), metric] = step
    return moved


def answer_changes(store_a: Store, store_b: Store, pairs: Sequence[TrialPair]) -> Iterator[Change]:
    """A row for each pair whose verdict, bits or measured values differ; its metric is the one that changed most."""
    readings = _Readings(store_a, store_b)
    for pair in pairs:
        if pair.a.status != pair.b.status:
            yield _flip(pair, readings.of(pair), store_b.catalogue)
            continue
        judged = readings.of(pair)
        moved = [each for each in judged if each.fields["before"] != each.fields["after"] and each.excess > 0]
        if pair.same_bits and moved:
            # The engine said the same: the metric, the bound or the truth is another.
            yield _change("error", "neither", pair, moved[0], store_b.catalogue, "the same bits, measured otherwise")
        elif not pair.same_bits and (isinstance(pair.b.trajectory_hash, str) or moved):
            worst = min(judged, key=lambda reading: (_ORDER.index(reading.sense), -reading.excess), default=None)
            yield _change("error", "within tolerance" if worst is None else worst.sense, pair, worst, store_b.catalogue)


_ORDER: tuple[Sense, ...] = ("worse", "better", "within tolerance", "neither")


def _flip(pair: TrialPair, judged: Sequence[_Reading], catalogue: Mapping[str, Any]) -> Change:
    before, after = (_RANK.get(row.status) for row in (pair.a, pair.b))
    silent = before is None or after is None or pair.a.status == "unavailable"
    sense: Sense = "neither" if silent or before == after else "worse" if (after or 0) > (before or 0) else "better"
    measured = judged[0] if judged and not pair.lost else None
    change = _change("verdict", sense, pair, measured, catalogue, str(pair.b.reason))
    return replace(change, before=str(pair.a.status), after=str(pair.b.status))


def _change(
    kind: ChangeKind, sense: Sense, pair: TrialPair, reading: _Reading | None, catalogue: Mapping[str, Any], detail: str = ""
) -> Change:
    fields = {} if reading is None else reading.fields
    return Change(kind=kind, sense=sense, detail=detail, **located(pair.a, pair.b, catalogue), **fields)


Likeness = Literal["bit-identical", "as good", "different"]
AS_GOOD: Likeness = "as good"


def likeness(store: Store, then: Mapping[str, Any], now: Record, processor: str) -> Likeness:
    """How two runs of a trial compare.

    Other bits are as good where the settings promise their bits on one machine alone, this is another one, and the status and
    each bounded metric are the same, a metric to a hundredth of its bound or of itself.

    Args: then: the row of `Store.trials`. processor: of this machine.
    """
    if now.status != then["status"]:
        return "different"
    if now.trajectory_hash == then["trajectory_hash"]:
        return "bit-identical"
    elsewhere = store.machine.get("processor") != processor
    measured = store.measurements[store.measurements["trial"] == then["trial"]]
    before = {row.metric: float(row.value) for row in measured.itertuples()}
    alike = all(
        _alike(before.get(one.metric, math.nan), one.value, one.at_most) for one in now.measurements if one.at_most is not None
    )
    return AS_GOOD if elsewhere and only_here(now.resolved) and alike else "different"


def _alike(before: float, after: float, bound: float | None) -> bool:
    most = max(abs(before), abs(after), 0.0 if bound is None or math.isnan(bound) else abs(bound))
    return before == after or abs(after - before) <= SHARE * most
