"""Engines side by side: what each passed, what it cost and how large its errors were, on cases that all answered.

What people can deploy is ranked among itself. Our own engine is the yardstick: it stands beside them on their scale.
"""

from collections.abc import Collection, Iterable, Mapping
from dataclasses import dataclass
from functools import lru_cache
from typing import TYPE_CHECKING

import numpy as np
import pandas as pd

from reports.answers import answers, at_own_step
from reports.contents import cases, engines, more_is_better, named_tracks, ours
from reports.verdict import totals

if TYPE_CHECKING:
    from harness.store.store import Store

__all__ = ["EXACT", "Glance", "glances", "shared_cases"]

EXACT = 1e-6
"""Share of a case's scale below which an error counts as this share: a ratio of two rounding errors says nothing."""
LEVEL = 1.01
"""Errors within one part in a hundred of each other are level: the first digits of a figure, which is all that is shown."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Glance:
    """One engine on one track.

    Terms:
        counts: status to trials. held: cases that passed at their own step; asked: those that were run there.
        relative_cost [1]: geometric mean over the shared cases of its CPU time over that of the cheapest engine that is not
        ours; relative_error [1]: likewise for the headline error, not below `EXACT`. shared: the number of those cases.
        best: cases in which its headline error is the smallest of the engines that are not ours, or within `LEVEL` of it;
        None for ours. None where it cannot be computed.
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
    def trials(self) -> int:
        """All trials."""
        return sum(self.counts.values())


def table(rows: pd.DataFrame, column: str) -> pd.DataFrame:
    """Medians of a column: cases down, engines across."""
    return rows.pivot_table(index="case", columns="engine", values=column, aggfunc="median", dropna=True, sort=False)


def regular(frame: pd.DataFrame, names: Iterable[str]) -> list[str]:
    """The engines with a number in at least half of the cases: one that answers little would shrink the shared cases to few."""
    answered = frame.notna().sum()
    return [name for name in names if name in frame.columns and answered[name] * 2 >= len(frame)]


def shared_cases(frame: pd.DataFrame, present: list[str]) -> pd.DataFrame:
    """The cases in which each engine of `present` has a finite positive number."""
    whole = frame.reindex(columns=present)
    return whole[np.isfinite(whole.to_numpy(dtype=np.float64)).all(axis=1) & (whole > 0).all(axis=1)]


def ratios(frame: pd.DataFrame, yardsticks: Collection[str] = ()) -> dict[str, float]:
    """Geometric mean, over the rows, of each column over the smallest of its row, in which yardsticks do not count."""
    ranked = frame.drop(columns=[name for name in yardsticks if name in frame.columns])
    if frame.empty:
        return {}
    logs = np.log(frame.div((frame if ranked.columns.empty else ranked).min(axis=1), axis=0))
    return {str(name): float(np.exp(value)) for name, value in logs.mean().items()}


@lru_cache(maxsize=1)
def glances(store: "Store") -> list[Glance]:
    """All engines on all tracks that were run. One with fewer than half of the cases has no ratios."""
    rows, entries, yardsticks = answers(store), [], ours(store)
    fewer = [name for name, case in cases(store).items() if not more_is_better(case)]
    own, counts = at_own_step(store, rows), totals(store)
    for track in named_tracks(store):
        on_track = own[own["track"] == track]
        errors, costs = table(on_track[on_track["case"].isin(fewer)], "error"), table(on_track, "cpu_per_sim_s")
        scales = pd.Series({name: case["scale"] or 1.0 for name, case in cases(store).items()}, dtype=np.float64)
        notable = errors.div(scales.reindex(errors.index), axis=0).clip(lower=EXACT)
        even, priced = (shared_cases(frame, regular(frame, engines(store))) for frame in (notable, costs))
        by_error, by_cost = ratios(even, yardsticks), ratios(priced, yardsticks)
        deployed = notable.drop(columns=[name for name in yardsticks if name in notable.columns]).dropna(how="all")
        level = deployed.le(LEVEL * deployed.min(axis=1), axis=0) if not deployed.empty else deployed
        passed = on_track["status"].eq("passed").groupby([on_track["engine"], on_track["case"]], sort=False).all()
        for engine in engines(store):
            if (engine, track) in counts:
                mine = passed[passed.index.get_level_values("engine") == engine]
                entries.append(
                    Glance(
                        engine=engine,
                        track=track,
                        counts=counts[engine, track],
                        held=int(mine.sum()),
                        asked=len(mine),
                        relative_cost=by_cost.get(engine),
                        relative_error=by_error.get(engine),
                        shared=len(priced) if engine in by_cost else 0,
                        best=None if engine in yardsticks else int(level[engine].sum()) if engine in level.columns else 0,
                    )
                )
    return sorted(entries, key=lambda glance: list(engines(store)).index(glance.engine))
