"""The largest time step: up to where a run stays whole, and up to where it stays within one per cent.

"Up to" means that every smaller step that was run does so as well: a coarse step that happens to hit is no licence.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from operator import itemgetter
from typing import Any

from plumbline.harness.findings.columns import Cell, Column, Table, Titled, Titles, milli, names, plain, scene
from plumbline.harness.findings.cost_point import CostPoint
from plumbline.harness.findings.once import once
from plumbline.harness.findings.parameter_words import step_in_words, substeps_of
from plumbline.harness.findings.prices import PER_SECOND, priced, unit_of
from plumbline.harness.findings.standing import cheapness, is_reference, leaders
from plumbline.harness.statistics.interval import Interval
from plumbline.harness.store.rows import grouped, records
from plumbline.harness.store.store import Store

WITHIN = 0.01
"""Of the case's scale."""
FEWEST = 4
"""Steps that a setting was run at; what a sweep tried at one or two says little of the others."""
_WHOLE = ("passed", "failed")
_NOT_RUN = ("unsupported", "unavailable", "interrupted")
_READ = ["engine", "track", "dt", "resolved", "status", "trial"]
"""Columns of a trial that are read here."""


@dataclass(frozen=True, slots=True, kw_only=True)
class StepRange(Cell):
    """How far the time step of one setting may go in one case.

    Terms:
        stable [s]: the largest step with a whole trajectory, accurate [s]: with an error within 1 % of the scale; None where
        not even the finest does; each with the sub-steps that it was taken in. coarsest, finest [s]: what was run, at `runs`
        steps. realtime: simulated over CPU seconds at the accurate step, clocked or by its rough cost, where it is steps that
        cost. error: the error there. trial: that run.
    """

    stable: float | None
    stable_substeps: int | None
    accurate: float | None
    accurate_substeps: int | None
    coarsest: float
    finest: float
    finest_substeps: int
    runs: int
    error: float | None
    realtime: float | None
    trial: str


@once
def largest_steps(store: Store) -> list[StepRange]:
    """One row for each setting of an engine that was run at `FEWEST` steps or more in a case that has an error."""
    prices = priced(store)
    known = {point.trial: point for point in prices.points}
    steps = []
    for case, where, trials in prices.groups():
        if not any(trial in known for trial in trials["trial"]):
            continue
        timed = unit_of(trials) == PER_SECOND
        run = trials.loc[~trials["status"].isin(_NOT_RUN), _READ]
        for (engine, track), runs in grouped(records(run), itemgetter("engine", "track")).items():
            if len({row["dt"] for row in runs}) >= FEWEST:
                ladder = sorted(runs, key=lambda row: float(row["dt"]))
                cell = Cell(case=case, where=where, engine=engine, track=track)
                steps.append(_step(cell, ladder, known, timed))
    return steps


def _step(cell: Cell, ladder: Sequence[Mapping[str, Any]], known: Mapping[str, CostPoint], timed: bool) -> StepRange:
    whole = [row["status"] in _WHOLE for row in ladder]
    points = [known.get(row["trial"]) for row in ladder]
    close = [point is not None and point.error <= WITHIN for point in points]
    steps = [float(row["dt"]) for row in ladder]
    parts = [substeps_of(str(row["resolved"])) for row in ladder]
    accurate, stable = _first(close), _first(whole)
    there = points[accurate - 1] if accurate else None
    return StepRange(
        **cell.cell,
        stable=steps[stable - 1] if stable else None,
        stable_substeps=parts[stable - 1] if stable else None,
        accurate=steps[accurate - 1] if accurate else None,
        accurate_substeps=parts[accurate - 1] if accurate else None,
        coarsest=steps[-1],
        finest=steps[0],
        finest_substeps=parts[0],
        runs=len(steps),
        error=there.error if there else None,
        realtime=1 / there.cost.value if there and timed else None,
        trial=there.trial if there else "",
    )


def _first(good: Sequence[bool]) -> int:
    """How many from the start on are good without a gap."""
    return next((k for k, holds in enumerate(good) if not holds), len(good))


def _worded(kind: str, row: StepRange) -> str:
    step = getattr(row, kind)
    if step is None:
        return f"not at {step_in_words(row.finest, row.finest_substeps)}"
    return step_in_words(step, getattr(row, f"{kind}_substeps")) + (", the coarsest" if step == row.coarsest else "")


def _sentences(rows: Sequence[StepRange]) -> list[str]:
    """The fastest way to stay within one per cent, case by case, and the reference engine's beside it, not ranked."""
    lines = []
    for name, paced in grouped((row for row in rows if row.realtime is not None), scene).items():
        ranked = [row for row in paced if not is_reference(row.engine)]
        first = leaders({_setting(row): cheapness(Interval(1 / (row.realtime or 0.0)), bound=False) for row in ranked})
        ways = [_way(row) for row in ranked if _setting(row) in first] or ["nobody to deploy"]
        ours = max((row for row in paced if row not in ranked), key=lambda row: row.realtime or 0.0, default=None)
        beside = "" if ours is None else f"; not ranked, {_way(ours)}"
        lines.append(f"{name}: to stay within 1 %, of the steps that were run, fastest {' and '.join(ways)}{beside}.")
    return lines


def _setting(row: StepRange) -> str:
    return f"{row.engine} ({row.track})"


def _way(row: StepRange) -> str:
    step = step_in_words(row.accurate or 0.0, row.accurate_substeps)
    return f"{_setting(row)} at dt = {step}, {row.realtime:.3g} times real time"


TABLE = Table(
    holds=names(StepRange),
    objects=largest_steps,
    shown=(
        Column("case", scene),
        *plain("engine", "setting=track"),
        Column("stable up to", lambda row: _worded("stable", row)),
        Column("within 1 % up to", lambda row: _worded("accurate", row)),
        *plain("error there=error:.2g", "times real time=realtime:.3g", "steps run=runs:d"),
    ),
    sentences=_sentences,
    paper=(
        Titled("Case", Titles.scene),
        Titled("Engine", Titles.engine),
        Column("Track", "track"),
        Column("Stable to [ms]", lambda step: milli(step.stable)),
        Column("Sub-steps", "stable_substeps"),
        Column("Within 1 % to [ms]", lambda step: milli(step.accurate)),
        *plain("Sub-steps=accurate_substeps", "Error there=error", "Times real time=realtime"),
    ),
)
