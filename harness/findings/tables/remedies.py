"""What helped where an engine broke, how far beyond, and at what cost."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import pandas as pd

from plumbline.harness.findings.columns import Cell, Column, Table, known, names, plain, scene
from plumbline.harness.findings.limits_found import Search, amount, searches
from plumbline.harness.store.store import Store
from plumbline.harness.trial.ensemble import HELD


@dataclass(frozen=True, slots=True, kw_only=True)
class Remedied(Cell):
    """One remedy at the value at which an engine broke.

    Terms:
        value: of the axis, where it broke. share_before, share_after: of the members that hold there. held: the hardest value
        that holds with the remedy, None where none does; broke: the first that does not. farther: from easy (0) to extreme (1),
        how much farther the limit lies. cost_ratio: CPU seconds per simulated second with the remedy over that without, at
        `value`, roughly. verdict: 'helps' (all members hold where not all did), 'helps some' (more do), 'no help', 'harms'
        (fewer do), or the status of a run that gave no answer. trial: the remedied run; trial_broke: the one without.
    """

    axis: str
    unit: str
    value: float
    signs: str
    remedy: str
    share_before: float
    share_after: float | None
    held: float | None
    broke: float | None
    farther: float
    cost_ratio: float | None
    verdict: str
    reason: str
    trial: str
    trial_broke: str


def remedied(store: Store) -> list[Remedied]:
    """Every remedy that was tried."""
    every = searches(store)
    sick = {search.trial_broke: search for search in every if not search.remedied and search.trial_broke}
    mine = [search for search in every if search.remedied in sick]
    broken = store.trials[store.trials["trial"].isin({search.remedied for search in mine})]
    tried = store.trials[store.trials["remedied"].isin(set(broken["trial"]))].sort_values("round", kind="stable")
    before = {str(row.trial): row for _, row in broken.iterrows()}
    first = {(str(row.remedied), str(row.remedy)): row for _, row in tried.drop_duplicates(["remedied", "remedy"]).iterrows()}
    held = store.measurements[store.measurements["metric"] == HELD].drop_duplicates("trial")
    shares = dict(zip(held["trial"], held["value"], strict=True))
    return [
        _row(search, sick[search.remedied], before[search.remedied], first[search.remedied, search.remedy], shares)
        for search in mine
    ]


def _row(
    search: Search, sick: Search, before: "pd.Series[Any]", first: "pd.Series[Any]", shares: Mapping[str, Any]
) -> Remedied:
    """Args: before, first: rows of the trial that broke and of the first with the remedy. shares: that held, by trial."""
    after = float(shares[first["trial"]]) if first["trial"] in shares else None
    share = sick.share or 0.0
    if after is None:
        verdict = str(first["status"])
    elif after > share:
        verdict = "helps" if after == 1.0 else "helps some"
    else:
        verdict = "no help" if after == share else "harms"
    ratio = first["rough_cost"] / before["rough_cost"]
    return Remedied(
        **known(search, "case", "engine", "track", "axis", "unit", "remedy", "held", "broke"),
        where=sick.where,
        value=float("nan") if sick.broke is None else sick.broke,
        signs=sick.signs.text,
        share_before=share,
        share_after=after,
        farther=max(0.0, search.reach - sick.reach),
        cost_ratio=None if ratio != ratio else float(ratio),
        verdict=verdict,
        reason="" if after is not None else str(first["reason"]),
        trial=str(first["trial"]),
        trial_broke=sick.trial_broke,
    )


TABLE = Table(
    holds=names(Remedied),
    objects=remedied,
    shown=(
        Column("case", scene),
        *plain("engine", "setting=track"),
        Column("broke at", lambda row: f"{row.axis} {row.value:.4g}{'' if row.unit == '1' else ' ' + row.unit}"),
        *plain("remedy", "held before=share_before:.2f", "held after=share_after:.2f"),
        Column("now holds to", lambda row: amount(row.held, "")),
        Column("cost", lambda row: "" if row.cost_ratio is None else f"x {row.cost_ratio:.2g}"),
        Column("verdict", "verdict"),
    ),
)
