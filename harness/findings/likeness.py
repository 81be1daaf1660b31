"""What a trial that was run again says beside what it said: the same bits, an answer as good, or another one."""

import math
from collections.abc import Mapping
from typing import Any, Literal

from plumbline.harness.adapter.promised_bits import only_here
from plumbline.harness.findings.changes.answers import SHARE
from plumbline.harness.store.record import Record
from plumbline.harness.store.store import Store

Likeness = Literal["bit-identical", "as good", "different"]
AS_GOOD: Likeness = "as good"


def likeness(store: Store, then: Mapping[str, Any], now: Record, processor: str) -> Likeness:
    """How two runs of a trial compare.

    Other bits are as good where the settings promise their bits on one machine alone, this is another one, and the status and
    each bounded metric are the same, a metric to a hundredth of its bound or of itself.

    Args: then: the row of `Store.trials`. processor: of this machine.
    """
    if now.status != then["status"]:
        return "different"
    if now.trajectory_hash == then["trajectory_hash"]:
        return "bit-identical"
    elsewhere = store.machine.get("processor") != processor
    measured = store.measurements[store.measurements["trial"] == then["trial"]]
    before = {row.metric: float(row.value) for row in measured.itertuples()}
    alike = all(
        _alike(before.get(one.metric, math.nan), one.value, one.at_most) for one in now.measurements if one.at_most is not None
    )
    return AS_GOOD if elsewhere and only_here(now.resolved) and alike else "different"


def _alike(before: float, after: float, bound: float | None) -> bool:
    most = max(abs(before), abs(after), 0.0 if bound is None or math.isnan(bound) else abs(bound))
    return before == after or abs(after - before) <= SHARE * most
