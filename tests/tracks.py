"""The two tracks of an engine compared over the catalogue: in which cases does 'tuned' err more than 'default'?

Errors are those of the case's headline, the mean over its seeds. 'tuned' is worse where its error is more than 1.1 times that
of 'default', or where it does not pass and 'default' does. Errors below a floor are one and the same to this question; it is
the largest of

* the truth's own error: nothing is known of what lies below it;
* 1e-9 of the case's scale, below which the price list draws no difference either: a run of 1e5 steps rounds by so much;
* a hundredth of the bound that the case derives for its headline. Bounds are leading terms (a step's way, g dt T/2) and stand
  for an answer that is right; both tracks are then right a hundredfold, and the terms that the derivation leaves out (the share
  of a step in a run, dt/T) decide which of them is the smaller.
"""

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from harness.adapter import Adapter
from harness.case import Case
from harness.findings.prices import number
from harness.run.campaign import carry_out
from harness.store.store import Store
from harness.study.experiment import Experiment
from harness.study.study import Study
from tests.in_process import in_this_process

__all__ = [
    "LADDER",
    "WORSE",
    "Answer",
    "Comparison",
    "compare",
    "comparisons",
    "disagreements",
    "over_the_ladder",
    "run_both_tracks",
]

WORSE = 1.1
"""The ratio of errors above which 'tuned' is worse."""
LEAST = 1e-9
"""Of the case's scale."""
SHARE = 0.01
"""Of the headline's bound."""
LADDER = "/ladder"
"""What a pair that is worse over the ladder is called by, behind the name of the case."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Answer:
    """One trial.

    Terms: error: of the headline, nan without one; off: the truth's own error; status, reason: as recorded. substep [s]: the
    step that was taken, None without an answer. values: of what was judged, by metric, with how far the truth may be off.
    """

    status: str
    error: float = math.nan
    off: float = 0.0
    reason: str = ""
    substep: float | None = None
    values: Mapping[str, tuple[float, float]] = field(default_factory=dict)

    def passes(self, case: Case, dt: float, substep: float | None) -> bool:
        """Does it keep the bounds of a run in steps of `substep` [s]? Its own, where these are what it took."""
        if self.status != "failed" or substep is None or self.substep is None or substep <= self.substep:
            return self.status == "passed"
        judged = ((check, *self.values[check.metric.name]) for check in case.checks if check.metric.name in self.values)
        return all(
            check.passes(value - (off if check.metric.better == "lower" else 0.0), dt, case.parameters, substep)
            for check, value, off in judged
        )


@dataclass(frozen=True, slots=True, kw_only=True)
class Comparison:
    """Both tracks of an engine in one case at one time step. Terms: ratio: of the errors, above the floor; inf: no answer."""

    case: str
    dt: float
    default: float
    tuned: float
    ratio: float
    lost: bool
    reason: str = ""

    @property
    def worse(self) -> bool:
        """Does 'tuned' err more, or not pass where 'default' does?"""
        return self.lost or self.ratio > WORSE

    def __str__(self) -> str:
        """The figures in a line."""
        lost = f"; passed, and no longer: {self.reason}" if self.lost else ""
        figures = f"default {self.default:.4g}, tuned {self.tuned:.4g} ({self.ratio:.3g} times)"
        return f"{self.case} at dt {self.dt:.4g}: {figures}{lost}"


def compare(case: Case, dt: float, default: Sequence[Answer], tuned: Sequence[Answer]) -> Comparison:
    """The two tracks at a time step dt [s], each with an answer for every seed."""
    headline = next(metric for metric in case.metrics if metric.name == case.headline)
    before, after = (float(np.mean([abs(one.error) for one in some])) for some in (default, tuned))
    if math.isnan(after):
        # Without an answer, 'tuned' is no worse only where 'default' has none either.
        ratio = 1.0 if math.isnan(before) else math.inf
    elif math.isnan(before):
        ratio = 0.0
    elif headline.better == "higher":
        ratio = before / after if after > 0 else (math.inf if before > 0 else 1.0)
    else:
        taken = max((one.substep for one in (*default, *tuned) if one.substep is not None), default=dt)
        bounds = [check.bound(dt, case.parameters, taken) for check in case.checks if check.metric.name == case.headline]
        off = max(one.off for one in (*default, *tuned))
        floor = max(off, LEAST * case.scale, SHARE * max([0.0, *bounds]))
        ratio = max(after, floor) / max(before, floor)
    # A bound is the stricter, the shorter the steps that are taken: what took more of them is not worse for that alone.
    coarse = max((one.substep for one in default if one.substep is not None), default=None)
    lost = all(one.status == "passed" for one in default) and not all(one.passes(case, dt, coarse) for one in tuned)
    reason = next((one.reason or one.status for one in tuned if one.status != "passed"), "")
    return Comparison(case=case.name, dt=dt, default=before, tuned=after, ratio=ratio, lost=lost, reason=reason)


def over_the_ladder(steps: Iterable[Comparison]) -> float:
    """The geometric mean of the ratios over a ladder: a single step may owe its error to the phase of a contact."""
    return float(np.exp(np.mean(np.log(np.clip([one.ratio for one in steps], LEAST, 1 / LEAST)))))


def run_both_tracks(folder: Path, cases: Mapping[str, Case], engines: Mapping[str, Adapter], ladder: bool) -> Store:
    """Every case on both tracks of every engine, in this process, without clocks and recordings.

    Of what a case only observes, its headline alone is measured: nothing else is compared.
    """
    compared = {
        name: replace(case, observe=tuple(metric for metric in case.observe if metric.name == case.headline))
        for name, case in cases.items()
    }
    experiment = Experiment(name="tracks", dt="ladder" if ladder else "case", timing=False, deadline=300.0)
    study = Study(name="tracks", recordings=False, experiments=(experiment,))
    with pytest.MonkeyPatch.context() as patch:
        in_this_process(patch, compared)
        return carry_out(study, folder, compared, engines, workers=1, resume=False)


def comparisons(store: Store, cases: Mapping[str, Case]) -> dict[str, list[Comparison]]:
    """All of a run, by engine; cases at their own parameters."""
    errors: dict[str, dict[str, Mapping[str, Any]]] = {}
    for row in store.measurements.to_dict("records"):
        errors.setdefault(row["trial"], {})[row["metric"]] = row
    found: dict[tuple[str, str, float], dict[str, list[Answer]]] = {}
    for row in store.trials.to_dict("records"):
        told = errors.get(row["trial"], {})
        measured = told.get(cases[row["case"]].headline, {})
        answer = Answer(
            status=row["status"],
            error=number(measured.get("value")),
            off=float(np.nan_to_num(number(measured.get("truth_error")))),
            reason=str(row["reason"] or ""),
            substep=None if math.isnan(number(row["substep"])) else float(row["substep"]),
            values={
                name: (number(one["value"]), number(one["truth_error"]))
                for name, one in told.items()
                if one["passed"] in (True, False)
            },
        )
        tracks = found.setdefault((row["engine"], row["case"], float(row["dt"])), {})
        tracks.setdefault(row["track"], []).append(answer)
    compared: dict[str, list[Comparison]] = {}
    for (engine, case, dt), tracks in found.items():
        compared.setdefault(engine, []).append(compare(cases[case], dt, tracks["default"], tracks["tuned"]))
    return compared


def disagreements(worse: Mapping[str, str], listed: Mapping[str, str]) -> list[str]:
    """What is worse and not listed, and what is listed and not worse, each in words. Args: worse: name to its figures."""
    return [
        *(f"not listed in trade_offs: {figures}" for name, figures in worse.items() if name not in listed),
        *(f"listed in trade_offs, but no longer worse: {name}" for name in listed if name not in worse),
        *(f"listed in trade_offs without a reason: {name}" for name, reason in listed.items() if not reason.strip()),
    ]
