"""Engines side by side: what each passed, what it cost and how large its errors were, on cases that all answered."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import lru_cache
from typing import TYPE_CHECKING

import numpy as np
import pandas as pd

from reports.answers import answers, at_own_step
from reports.contents import cases, engines, named_tracks
from reports.verdict import totals

if TYPE_CHECKING:
    from harness.store import Store

__all__ = ["EXACT", "Glance", "glances", "shared_cases"]

EXACT = 1e-6
"""Share of a case's scale below which an error counts as this share: a ratio of two rounding errors says nothing."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Glance:
    """One engine on one track.

    Terms:
        counts: status to trials. relative_cost [1]: geometric mean over the shared cases of its CPU time over the cheapest
        engine's; relative_error [1]: likewise for the headline error, not below `EXACT`. shared: the number of those cases.
        best: cases in which its headline error is the smallest. None where it cannot be computed.
    """

    engine: str
    track: str
    counts: Mapping[str, int]
    relative_cost: float | None
    relative_error: float | None
    shared: int
    best: int

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


def ratios(frame: pd.DataFrame) -> dict[str, float]:
    """Geometric mean, over the rows, of each column over the smallest of its row."""
    if frame.empty:
        return {}
    logs = np.log(frame.div(frame.min(axis=1), axis=0))
    return {str(name): float(np.exp(value)) for name, value in logs.mean().items()}


@lru_cache(maxsize=1)
def glances(store: "Store") -> list[Glance]:
    """All engines on all tracks that were run. One with fewer than half of the cases has no ratios."""
    rows, found = answers(store), []
    own, counts = at_own_step(store, rows), totals(store)
    for track in named_tracks(store):
        part = own[own["track"] == track]
        errors, costs = table(part, "error"), table(part, "cpu_per_sim_s")
        scales = pd.Series({name: case["scale"] or 1.0 for name, case in cases(store).items()}, dtype=np.float64)
        notable = errors.div(scales.reindex(errors.index), axis=0).clip(lower=EXACT)
        even, priced = (shared_cases(frame, regular(frame, engines(store))) for frame in (notable, costs))
        by_error, by_cost = ratios(even), ratios(priced)
        winners = errors.dropna(how="all").idxmin(axis=1) if not errors.empty else pd.Series(dtype=object)
        for engine in engines(store):
            if (engine, track) in counts:
                found.append(
                    Glance(
                        engine=engine,
                        track=track,
                        counts=counts[engine, track],
                        relative_cost=by_cost.get(engine),
                        relative_error=by_error.get(engine),
                        shared=len(priced) if engine in by_cost else 0,
                        best=int((winners == engine).sum()),
                    )
                )
    return sorted(found, key=lambda one: list(engines(store)).index(one.engine))
