"""Where the reference engine errs least, and the declared reason for it."""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import pandas as pd

from plumbline.harness.store.store import Store
from plumbline.reports.tables.engine_summary import EXACT, most_accurate
from plumbline.reports.tables.own_scenes import by_case
from plumbline.reports.tables.trial_results import answers, at_own_step
from plumbline.reports.words.catalogue import cases, compared_tracks, engines, more_is_better, ours

NO_REASON = "no reason given"
"""What stands where our engine errs least and nobody has said why."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Lead:
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


@lru_cache(maxsize=1)
def leads(store: Store) -> dict[tuple[str, str], Lead]:
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
) -> Lead | None:
    if mine not in errors:
        return None
    others, more = errors.drop(mine), more_is_better(case)
    rival = "" if others.empty else str(others.idxmax() if more else others.idxmin())
    notable = errors if more else errors.clip(lower=EXACT * (case["scale"] or 1.0))
    if rival and most_accurate(notable, more_is_better=more) != {mine}:
        return None
    reason = advantages.get(f"{track}/{case['name']}", {"by": NO_REASON, "why": ""})
    return Lead(
        case=case["name"],
        track=track,
        engine=mine,
        rival=rival,
        error=float(errors[mine]),
        rival_error=float(others[rival]) if rival else None,
        by=reason["by"],
        why=reason["why"],
    )
