"""How much a change weighs beside others: first what kind it is and which way it goes, then how much it is."""

import math
from collections.abc import Iterable
from dataclasses import replace

from plumbline.harness.findings.changes.values import Change, Kind, Sense

_GRAVITY: tuple[tuple[Kind, Sense], ...] = (
    ("verdict", "worse"), ("digest", "worse"), ("determinism", "worse"), ("limit", "worse"), ("error", "worse"),
    ("price", "worse"),
    ("verdict", "better"), ("limit", "better"), ("error", "better"), ("price", "better"), ("determinism", "better"),
    ("price", "unconfirmed"),
    ("version", "neither"), ("warning", "worse"), ("warning", "better"), ("warning", "neither"), ("verdict", "neither"),
    ("settings", "neither"), ("error", "neither"), ("sources", "neither"), ("machine", "neither"), ("trials", "neither"),
    ("limit", "within tolerance"), ("error", "within tolerance"), ("limit", "neither"), ("determinism", "neither"),
)  # fmt: skip
"""The gravest first: what is wrong before what is dear, what got worse before what got better, facts about engines before facts
about the run, and what makes no difference last."""


def heaviest_first(rows: Iterable[Change]) -> tuple[Change, ...]:
    """The same rows with their weights, sorted."""
    weighed = (replace(row, weight=len(_GRAVITY) - _GRAVITY.index((row.kind, row.sense)) + _size(row)) for row in rows)
    return tuple(sorted(weighed, key=lambda row: (-row.weight, row.case, row.engine, row.track, row.dt, row.metric)))


def _size(row: Change) -> float:
    """Below 1 and growing with the ratio; 1/2 for a factor of two, and more for what is said of an engine as a whole."""
    by_ratio = abs(math.log2(row.ratio)) if row.ratio is not None and 0 < row.ratio < math.inf else 0.0
    by_count = (math.log2(row.count) / 100 if row.case else 1.0) if row.count > 1 else 0.0
    size = by_ratio + by_count
    return size / (1 + size) * (1 - 1e-9)
