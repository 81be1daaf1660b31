"""The error of every run in a scene without a truth: its distance from the agreed limit, or from its engine's own where none
is.

So that what an engine errs at a step stands beside what that step costs, as in a case whose truth is known. Distances are the
largest up to the time to which the limit is known, as shares of the size of what moves.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from harness.findings.agreement.found import agreements
from harness.findings.agreement.values import Agreement, Side
from harness.store.store import Store
from harness.trajectory import Floats
from harness.trajectory.parting import apart, common

__all__ = ["Errors", "errors_of", "ways"]


@dataclass(frozen=True, slots=True, kw_only=True)
class Errors:
    """Of one run. Terms: error, and how far off the limit itself may be (off), as shares of the size; agreed: is the limit that
    of several engines, or the engine's own? until [s]: up to there it is compared."""

    error: float
    off: float
    agreed: bool
    until: float


@lru_cache(maxsize=2)
def errors_of(store: Store) -> Mapping[str, Errors]:
    """By trial; runs without an answer, and engines without a limit, have none."""
    found: dict[str, Errors] = {}
    for one in agreements(store):
        for side in one.sides:
            found |= _of_side(one, side)
    return found | _of_equal_runs(store, found)


def _of_equal_runs(store: Store, found: Mapping[str, Errors]) -> dict[str, Errors]:
    """Of runs that other experiments made of the same scene, with the same bits."""
    asked = store.asked[store.asked["case"].isin({one.case for one in agreements(store)})]
    known = {row.trajectory_hash: found[row.trial] for row in asked.itertuples() if row.trial in found}
    return {
        row.trial: known[row.trajectory_hash]
        for row in asked.itertuples()
        if row.trial not in found and row.trajectory_hash in known
    }


def _of_side(one: Agreement, side: Side) -> dict[str, Errors]:
    if one.limit is not None and one.bar is not None:
        limit, off, until = one.limit, one.bar, one.until
    elif side.limit.value is not None and side.limit.until > 0:
        limit, off, until = side.limit.value, side.limit.bar_at(side.limit.until), side.limit.until
    else:
        return {}
    found = {}
    for rung in side.limit.rungs:
        if rung.run is not None:
            here, there = common([rung.run.between(0.0, until), limit.between(0.0, until)])
            error = float(apart(here, there, one.scale).max(initial=0.0))
            found[rung.trial] = Errors(error=error, off=off, agreed=one.limit is not None, until=until)
    return found


def ways(one: Agreement) -> tuple[str, Mapping[tuple[str, str], tuple[Floats, Floats]]]:
    """How far each limit has been, up to each sample, from the one that is agreed; where none is, from that known longest.

    Returns: 'engine, track' of the limit that is measured from, '' for the agreed one; and by engine and track the times (t,)
    s and the distances (t,), as shares of the size.
    """
    known = [side for side in one.sides if side.limit.value is not None and side.limit.until > 0]
    if not known:
        return "", {}
    first = max(known, key=lambda side: side.limit.until)
    base, until = (one.limit, one.until) if one.limit is not None else (first.limit.value, first.limit.until)
    assert base is not None
    found = {}
    for side in known:
        assert side.limit.value is not None
        end = min(until, side.limit.until)
        here, there = common([side.limit.value.between(0.0, end), base.between(0.0, end)])
        found[side.engine, side.track] = (here.time, np.maximum.accumulate(apart(here, there, one.scale)))
    return "" if one.limit is not None else f"{first.engine}, {first.track}", found
