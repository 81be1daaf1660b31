"""The two tracks of an engine compared over the catalogue: in which cases does 'default' do better than 'tuned'?

'default' does better if it keeps all checks that 'tuned' keeps and another one, or if it keeps them and 'tuned' errs more; see
`harness.search.dominance` for what counts as more.
"""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import pytest

from plumbline.harness.adapter import Adapter, TradeOff
from plumbline.harness.case import Case
from plumbline.harness.run.campaign import carry_out
from plumbline.harness.search.dominance import Comparison, Question, compared, run_of
from plumbline.harness.store.store import Store
from plumbline.harness.study.experiment import Experiment
from plumbline.harness.study.study import Study
from tests.in_process import in_this_process

__all__ = ["Tracks", "comparisons", "disagreements", "listed", "over_the_ladder", "run_both_tracks"]

LEAST = 1e-9
"""Of two errors, the ratio below which they are as good as infinitely far apart."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Tracks:
    """Both tracks of an engine in one case at one time step.

    Terms: beside: 'default' beside 'tuned'; None if 'default' gave no answer. reason: of the outcome of 'tuned'.
    """

    case: str
    dt: float
    beside: Comparison | None
    reason: str = ""

    @property
    def worse(self) -> bool:
        """Does 'default' do better?"""
        return self.beside is not None and (self.beside.more or self.beside.errs_less)

    @property
    def ratio(self) -> float:
        """The error of 'tuned' over that of 'default', above the floor; 1 if neither has one."""
        ratio = 1.0 if self.beside is None or np.isnan(self.beside.ratio) else self.beside.ratio
        return 1 / max(ratio, LEAST)

    def __str__(self) -> str:
        """The figures in a line."""
        held = "no answer" if self.beside is None else f"checks held {self.beside.held[0]}, by default {self.beside.held[1]}"
        return f"{self.case} at dt {self.dt:.4g}: tuned errs {self.ratio:.3g} times as much, {held}; {self.reason}"


def over_the_ladder(steps: Iterable[Tracks]) -> float:
    """The geometric mean of the ratios over a ladder: a single step may owe its error to the phase of a contact."""
    return float(np.exp(np.mean(np.log(np.clip([one.ratio for one in steps], LEAST, 1 / LEAST)))))


def run_both_tracks(folder: Path, cases: Mapping[str, Case], engines: Mapping[str, Adapter], ladder: bool) -> Store:
    """Every case on both tracks of every engine, in this process, without clocks and recordings.

    Of what a case only observes, its headline alone is measured: nothing else is compared.
    """
    asked = {
        name: replace(case, observe=tuple(metric for metric in case.observe if metric.name == case.headline))
        for name, case in cases.items()
    }
    experiment = Experiment(name="tracks", dt="ladder" if ladder else "case", timing=False, deadline=300.0)
    study = Study(name="tracks", recordings=False, experiments=(experiment,))
    with pytest.MonkeyPatch.context() as patch:
        in_this_process(patch, asked)
        return carry_out(study, folder, asked, engines, workers=1, resume=False)


def comparisons(store: Store, cases: Mapping[str, Case]) -> dict[str, list[Tracks]]:
    """All of a run, by engine; cases at their own parameters, each seed for itself."""
    found: dict[str, list[Tracks]] = {}
    pairs: dict[tuple[str, str, float, int], dict[str, dict[str, object]]] = {}
    for row in store.trials.to_dict("records"):
        pairs.setdefault((row["engine"], row["case"], float(row["dt"]), int(row["seed"])), {})[row["track"]] = row
    for (engine, case, dt, _), rows in pairs.items():
        question = Question.of(cases[case])
        tuned, default = (
            run_of(question, str(rows[track]["status"]), store.measured.get(str(rows[track]["trial"]), ()))
            for track in ("tuned", "default")
        )
        beside = compared(question, tuned, default)
        found.setdefault(engine, []).append(Tracks(case=case, dt=dt, beside=beside, reason=str(rows["tuned"]["reason"])))
    return found


def listed(adapter: Adapter, at: str) -> dict[str, TradeOff]:
    """By case, where an adapter says that 'default' does better: at the 'own step' or over the 'ladder'."""
    return {case: one for one in adapter.trade_offs if not one.knob and at in one.at for case in one.cases}


def disagreements(worse: Mapping[str, str], said: Iterable[str]) -> list[str]:
    """What is worse and not said, and what is said and not worse, each in words. Args: worse: case to its figures."""
    said = set(said)
    return [
        *(f"not listed in trade_offs: {figures}" for case, figures in worse.items() if case not in said),
        *(f"listed in trade_offs, but no longer worse: {case}" for case in sorted(said) if case not in worse),
    ]
