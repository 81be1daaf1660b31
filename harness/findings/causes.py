"""Failures: by how much a trial keeps or misses its checks, and their causes. Those with one cause are one finding: the cases
that an engine fails on a track, by what is declared of them.

A cause is read off typed fields alone, the first of these that applies:

* an effect that the trial's notices call surplus or missing, where the same engine passes the same case on another track
  without that notice, or where the table of effects says that it matters there;
* a finding about the engine whose script says that it makes answers wrong (`cause`) and names the case, on that track;
* a law of the case that the adapter makes;
* none: what nobody has explained is said to be so.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Literal

from plumbline.harness.findings.emulations import made
from plumbline.harness.findings.once import once
from plumbline.harness.findings.tables.effects import verdicts_if_described
from plumbline.harness.findings.vendor_findings import Finding
from plumbline.harness.store.rows import grouped
from plumbline.harness.store.store import Store

By = Literal["effect", "finding", "emulated", "unexplained"]
_ORDER: Mapping[By, int] = {"effect": 0, "finding": 1, "emulated": 2, "unexplained": 3}
FAILED = ("failed", "diverged", "timeout", "crashed", "oom")
"""Outcomes that count against an engine; one that cannot express a scene has not failed it."""


@dataclass(frozen=True, slots=True)
class CaseResult:
    """How an engine did in a case on a track: the trial that stands for it, and its status."""

    case: str
    engine: str
    track: str
    trial: str
    status: str


@dataclass(frozen=True, slots=True)
class Cause:
    """What makes an engine fail on a track, and where.

    Terms: by: from where it is known. effects: names of the effects, of `by` 'effect'. features: those that the adapter makes,
    of 'emulated'. finding: that says it, None where none does. failures: one a case. cured: the cases among them that the
    engine passes on another track.
    """

    engine: str
    track: str
    by: By
    effects: tuple[str, ...]
    features: tuple[str, ...]
    finding: Finding | None
    failures: tuple[CaseResult, ...]
    cured: tuple[str, ...]


_Key = tuple[str, str, By, tuple[str, ...], tuple[str, ...], str]


def causes(store: Store, answers: Sequence[CaseResult], shelf: Sequence[Finding]) -> tuple[Cause, ...]:
    """What is declared first and what most cases fail by before the rest; a case counts once for each engine and track."""
    passed = grouped((a for a in answers if a.status == "passed"), lambda answer: (answer.case, answer.engine))
    weights = {
        (verdict.case, verdict.engine, verdict.track, effect): verdict.matters
        for verdict in verdicts_if_described(store)
        if len(verdict.effects) == 1 and verdict.matters is not None
        for effect in verdict.effects
    }
    named = {finding.name: finding for finding in shelf}
    groups: dict[_Key, list[CaseResult]] = {}
    for answer in answers:
        if answer.status in FAILED:
            others = passed.get((answer.case, answer.engine), [])
            effects = _effects(store, answer, others, weights)
            groups.setdefault(_key(store, answer, effects, shelf), []).append(answer)
    listed = [
        Cause(
            engine=engine,
            track=track,
            by=by,
            effects=effects,
            features=features,
            finding=named.get(finding),
            failures=tuple(failures),
            cured=tuple(answer.case for answer in failures if (answer.case, answer.engine) in passed),
        )
        for (engine, track, by, effects, features, finding), failures in groups.items()
    ]
    return tuple(sorted(listed, key=lambda cause: (_ORDER[cause.by] == _ORDER["unexplained"], -len(cause.failures))))


def _noticed(store: Store, trial: str) -> set[str]:
    return {notice.effect for notice in store.notices.get(trial, ()) if notice.kind != "note" and notice.effect}


def _effects(
    store: Store, answer: CaseResult, passed: Sequence[CaseResult], weights: Mapping[tuple[str, str, str, str], bool]
) -> tuple[str, ...]:
    """Those that are there or not though the scene asks otherwise, and that the failure goes with."""
    without = [_noticed(store, other.trial) for other in passed]
    kept = []
    for effect in sorted(_noticed(store, answer.trial)):
        matters = weights.get((answer.case, answer.engine, answer.track, effect))
        if matters or (matters is None and any(effect not in noticed for noticed in without)):
            kept.append(effect)
    return tuple(kept)


def _key(store: Store, answer: CaseResult, effects: tuple[str, ...], shelf: Sequence[Finding]) -> _Key:
    mine = [finding for finding in shelf if finding.engine == answer.engine and answer.track in finding.tracks]
    if effects:
        said = next((finding.name for finding in mine if set(effects) <= set(finding.effects)), "")
        return answer.engine, answer.track, "effect", effects, (), said
    # Of a finding that says which effects it is about the notices have to say so too.
    shown = next(
        (finding.name for finding in mine if finding.cause and answer.case in finding.cases and not finding.effects), ""
    )
    if shown:
        return answer.engine, answer.track, "finding", (), (), shown
    laws = tuple(dict.fromkeys(law.feature for law in made(store.catalogue, answer.engine, answer.case, answer.track)))
    by: By = "emulated" if laws else "unexplained"
    return answer.engine, answer.track, by, (), laws, ""


@dataclass(frozen=True, slots=True)
class Margin:
    """One check of one trial.

    Terms: times [1]: the value over its bound, the bound over the value where more is better; above 1 the check is missed, inf
    where there is no number to compare. metric, value, at_most, unit: as in the table `measurements`.
    """

    times: float
    metric: str
    value: float
    at_most: float
    unit: str

    @property
    def held(self) -> bool:
        """Is the value within its bound?"""
        return self.times <= 1.0


def _times(value: float, bound: float, more: bool) -> float:
    if not math.isfinite(value):
        return math.inf
    above, below = (bound, abs(value)) if more else (abs(value), bound)
    return above / below if below > 0 else math.inf if above > 0 else 0.0


@once
def margins(store: Store) -> Mapping[str, Margin]:
    """Of each trial with a bounded check, by trial; a value that a check leaves unjudged has none."""
    table = store.measurements
    of_case = dict(zip(store.trials["trial"], store.trials["case"], strict=True))
    more = {
        (name, check["metric"])
        for name, case in store.catalogue.get("cases", {}).items()
        for check in case.get("checks", ())
        if check.get("better") == "higher"
    }
    worst: dict[str, Margin] = {}
    judged = table[table["passed"].notna() & table["at_most"].notna()]
    columns = ("trial", "metric", "value", "at_most", "unit", "passed")
    for trial, metric, value, bound, unit, passed in judged[list(columns)].itertuples(index=False):
        times = _times(float(value), float(bound), (of_case.get(trial), metric) in more)
        # A bound met to the last bit of its rounding is met, one that the check calls missed is missed.
        times = min(times, 1.0) if passed else max(times, math.nextafter(1.0, 2.0))
        if trial not in worst or times > worst[trial].times:
            worst[trial] = Margin(times, str(metric), float(value), float(bound), str(unit))
    return worst
