"""Engines side by side: what each passed, what it cost and how large its errors were, on cases that all answered.

There is one scale for all tracks: what tuning does to an engine is the step from one number to the other. What people can
deploy is ranked among itself. The reference engine stands beside them on their scale; where it errs least, the declared reason
is told.
"""

from collections import Counter
from collections.abc import Collection, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import pandas as pd

from plumbline.harness.findings.once import once
from plumbline.harness.findings.standing import exactness, leaders
from plumbline.harness.store.store import Store
from plumbline.reports.tables.own_scenes import by_case
from plumbline.reports.tables.trial_results import answers, at_own_step
from plumbline.reports.tables.verdicts import totals
from plumbline.reports.words.catalogue import cases, compared_tracks, engines, more_is_better, ours

Side = tuple[str, str]
"""An engine, and a track of it."""

EXACT = 1e-6
"""Share of a case's scale below which an error counts as this share: a ratio of two rounding errors says nothing."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Glance:
    """One engine on one track.

    Terms:
        counts: outcome to cases at their own step. held: cases that passed there; asked: those that were run there.
        relative_cost [1]: geometric mean over the shared cases of its CPU time over that of the cheapest engine that is not
        ours, whatever its track; relative_error [1]: likewise for the headline error, not below `EXACT`. shared: the number of
        those cases, in which each engine on each track has a number. best: cases in which its headline error is the smallest of
        the engines that are not ours, whatever their track, or within `ALIKE` of it; None for ours. None where it cannot be
        computed.
    """

    engine: str
    track: str
    counts: Mapping[str, int]
    held: int
    asked: int
    relative_cost: float | None
    relative_error: float | None
    shared: int
    best: int | None

    @property
    def cases(self) -> int:
        """All of them."""
        return sum(self.counts.values())


def table(rows: pd.DataFrame, column: str) -> pd.DataFrame:
    """Medians of a column: cases down, engines on their tracks across, as (engine, track)."""
    return rows.pivot_table(index="case", columns=["engine", "track"], values=column, aggfunc="median", dropna=True, sort=False)


def regular(frame: pd.DataFrame) -> list[Side]:
    """The columns with a number in at least half of the cases: one that answers little would shrink the shared cases to few."""
    answered = frame.notna().sum()
    return [side for side in frame.columns if answered[side] * 2 >= len(frame)]


def shared_cases(frame: pd.DataFrame, present: list[Side]) -> pd.DataFrame:
    """The cases in which each column of `present` has a finite positive number."""
    whole = frame[present]
    return whole[np.isfinite(whole.to_numpy(dtype=np.float64)).all(axis=1) & (whole > 0).all(axis=1)]


def others(frame: pd.DataFrame, yardsticks: Collection[str]) -> pd.DataFrame:
    """Without the columns of yardsticks."""
    return frame[[side for side in frame.columns if side[0] not in yardsticks]]


def ratios(frame: pd.DataFrame, yardsticks: Collection[str] = ()) -> dict[Side, float]:
    """Geometric mean, over the rows, of each column over the smallest of its row, in which yardsticks do not count."""
    if frame.empty:
        return {}
    ranked = others(frame, yardsticks)
    logs = np.log(frame.div((frame if ranked.columns.empty else ranked).min(axis=1), axis=0))
    return {(str(engine), str(track)): float(np.exp(value)) for (engine, track), value in logs.mean().items()}


def most_accurate(errors: "pd.Series[float]", *, more_is_better: bool = False) -> frozenset[Any]:
    """Which of these err least? All that are within `ALIKE` of the least. Args: errors: positive, where less is better."""
    return leaders({who: exactness(float(error), more_is_better) for who, error in errors.items()})


@once
def glances(store: Store) -> list[Glance]:
    """All engines on all tracks that were run, on one scale. One with fewer than half of the cases has no ratios."""
    yardsticks, counts, named = ours(store), totals(store), compared_tracks(store)
    fewer = [name for name, case in cases(store).items() if not more_is_better(case)]
    own = at_own_step(store, answers(store))
    own = own[own["track"].isin(named)]
    errors, costs = table(own[own["case"].isin(fewer)], "error"), table(own, "cpu_per_sim_s")
    scales = pd.Series({name: case["scale"] or 1.0 for name, case in cases(store).items()}, dtype=np.float64)
    notable = errors.div(scales.reindex(errors.index), axis=0).clip(lower=EXACT)
    even, priced = (shared_cases(frame, regular(frame)) for frame in (notable, costs))
    by_error, by_cost = ratios(even, yardsticks), ratios(priced, yardsticks)
    leading = Counter(side for _, row in others(notable, yardsticks).iterrows() for side in most_accurate(row.dropna()))
    sides = [(engine, track) for engine in engines(store) for track in named if (engine, track) in counts]
    return [
        Glance(
            engine=engine,
            track=track,
            counts=counts[engine, track],
            held=counts[engine, track]["passed"],
            asked=sum(counts[engine, track].values()),
            relative_cost=by_cost.get((engine, track)),
            relative_error=by_error.get((engine, track)),
            shared=len(priced) if (engine, track) in by_cost else 0,
            best=None if engine in yardsticks else leading[engine, track],
        )
        for engine, track in sides
    ]


NO_REASON = "no reason given"
"""What stands where our engine errs least and nobody has said why."""


@dataclass(frozen=True, slots=True, kw_only=True)
class ReferenceLead:
    """A case in which our engine errs least on a track.

    Terms:
        engine: ours. rival: the best of the others, '' where none of those that were asked answers. error, rival_error: medians
        of the headline at the case's own step, in its unit. by, why: as in `harness.adapter.Advantage`; `NO_REASON` and ''
        where there is none.
    """

    case: str
    track: str
    engine: str
    rival: str
    error: float
    rival_error: float | None
    by: str
    why: str


@once
def leads(store: Store) -> dict[tuple[str, str], ReferenceLead]:
    """By (case, track). What lies below a millionth of the case's scale is equal: rounding leads nobody."""
    rows = at_own_step(store, answers(store))[["case", "track", "engine", "error"]]
    leading = {}
    for (case, track), group in rows.groupby(["case", "track"], sort=False):
        if case not in by_case(store) and track in compared_tracks(store) and group["engine"].nunique() > 1:
            medians = group.groupby("engine", sort=False)["error"].median().dropna()
            for name in ours(store):
                lead = _lead(cases(store)[case], str(track), name, medians, engines(store)[name]["advantages"])
                if lead is not None:
                    leading[str(case), str(track)] = lead
    return leading


def _lead(
    case: Mapping[str, Any], track: str, mine: str, errors: "pd.Series[float]", advantages: Mapping[str, Any]
) -> ReferenceLead | None:
    if mine not in errors:
        return None
    others, more = errors.drop(mine), more_is_better(case)
    rival = "" if others.empty else str(others.idxmax() if more else others.idxmin())
    notable = errors if more else errors.clip(lower=EXACT * (case["scale"] or 1.0))
    if rival and most_accurate(notable, more_is_better=more) != {mine}:
        return None
    reason = advantages.get(f"{track}/{case['name']}", {"by": NO_REASON, "why": ""})
    return ReferenceLead(
        case=case["name"],
        track=track,
        engine=mine,
        rival=rival,
        error=float(errors[mine]),
        rival_error=float(others[rival]) if rival else None,
        by=reason["by"],
        why=reason["why"],
    )
