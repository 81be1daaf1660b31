"""The error of every run in a scene without a truth: its distance from the agreed limit, or from its engine's own where none
is.

So that what an engine errs at a step stands beside what that step costs, as in a case whose truth is known. Distances are the
largest up to the time to which the limit is known, as shares of the size of what moves.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from plumbline.harness.findings.agreement.found import agreements
from plumbline.harness.findings.agreement.values import Agreement, Side
from plumbline.harness.store.store import Store
from plumbline.harness.trajectory import Floats
from plumbline.harness.trajectory.parting import apart, common


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
    errors: dict[str, Errors] = {}
    for agreement in agreements(store):
        for side in agreement.sides:
            errors |= _of_side(agreement, side)
    return errors | _of_equal_runs(store, errors)


def _of_equal_runs(store: Store, errors: Mapping[str, Errors]) -> dict[str, Errors]:
    """Of runs that other experiments made of the same scene, with the same bits."""
    asked = store.asked[store.asked["case"].isin({agreement.case for agreement in agreements(store)})]
    known = {row.trajectory_hash: errors[row.trial] for row in asked.itertuples() if row.trial in errors}
    return {
        row.trial: known[row.trajectory_hash]
        for row in asked.itertuples()
        if row.trial not in errors and row.trajectory_hash in known
    }


def _of_side(agreement: Agreement, side: Side) -> dict[str, Errors]:
    if agreement.limit is not None and agreement.bar is not None:
        limit, off, until = agreement.limit, agreement.bar, agreement.until
    elif side.limit.value is not None and side.limit.until > 0:
        limit, off, until = side.limit.value, side.limit.bar_at(side.limit.until), side.limit.until
    else:
        return {}
    errors = {}
    for rung in side.limit.rungs:
        if rung.run is not None:
            here, there = common([rung.run.between(0.0, until), limit.between(0.0, until)])
            # A run that is the limit itself, where no order shows, errs by what that is known to and not by nothing.
            error = float(apart(here, there, agreement.scale).max(initial=0.0)) or off
            errors[rung.trial] = Errors(error=error, off=off, agreed=agreement.limit is not None, until=until)
    return errors


def ways(agreement: Agreement) -> tuple[str, Mapping[tuple[str, str], tuple[Floats, Floats]]]:
    """How far each limit has been, up to each sample, from the one that is agreed; where none is, from that known longest.

    Returns: 'engine, track' of the limit that is measured from, '' for the agreed one; and by engine and track the times (t,)
    s and the distances (t,), as shares of the size.
    """
    known = [side for side in agreement.sides if side.limit.value is not None and side.limit.until > 0]
    if not known:
        return "", {}
    first = max(known, key=lambda side: side.limit.until)
    base, until = (agreement.limit, agreement.until) if agreement.limit is not None else (first.limit.value, first.limit.until)
    assert base is not None
    distances = {}
    for side in known:
        assert side.limit.value is not None
        end = min(until, side.limit.until)
        here, there = common([side.limit.value.between(0.0, end), base.between(0.0, end)])
        distances[side.engine, side.track] = (here.time, np.maximum.accumulate(apart(here, there, agreement.scale)))
    return "" if agreement.limit is not None else f"{first.engine}, {first.track}", distances
