"""A run beside the published dataset: which of its trials are there too, whose verdict differs, and how its prices compare."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from statistics import median
from typing import Any

import pandas as pd

from plumbline.harness.findings.changes.matching import LOST, scene_of
from plumbline.harness.store.rows import records
from plumbline.harness.store.store import Store

_Pair = tuple[Mapping[str, Any], Mapping[str, Any]]
_SAME = ("parameters", "engine", "track", "dt", "seed", "clocks", "workers")
"""Columns that two trials of one case share if they ask the same, whatever study asks."""


@dataclass(frozen=True, slots=True, kw_only=True)
class BesidePublished:
    """An engine in both.

    Terms: version, version_here: '' where it was not run. same: trials that both answered. differences: rows of those whose
    verdicts differ, then and now.
    slower: the median over these trials of CPU time here over that published, over the median of all engines: 1 if the engine
    costs here what it cost there beside the others; None without a price on both sides.
    """

    engine: str
    version: str
    version_here: str
    same: int
    differences: tuple[_Pair, ...]
    slower: float | None


def beside_published(published: Store, store: Store) -> Mapping[str, BesidePublished]:
    """By engine, in the order of the dataset."""
    pairs = list(_pairs(published, store))
    ratios: dict[str, list[float]] = {}
    for then, now in pairs:
        if all(pd.notna(row["cpu_per_unit"]) and row["cpu_per_unit"] > 0 and not row["unstable_timing"] for row in (then, now)):
            ratios.setdefault(now["engine"], []).append(now["cpu_per_unit"] / then["cpu_per_unit"])
    machine = median(ratio for of_engine in ratios.values() for ratio in of_engine) if ratios else None
    versions, current = (_versions(each) for each in (published, store))
    besides = {}
    for engine in dict.fromkeys([*versions, *current]):
        mine = [(then, now) for then, now in pairs if now["engine"] == engine]
        besides[engine] = BesidePublished(
            engine=engine,
            version=versions.get(engine, ""),
            version_here=current.get(engine, ""),
            same=len(mine),
            differences=tuple((then, now) for then, now in mine if then["status"] != now["status"]),
            slower=median(ratios[engine]) / machine if machine and engine in ratios else None,
        )
    return besides


def _versions(store: Store) -> Mapping[str, str]:
    frame = store.trials
    return dict(zip(frame["engine"], frame["engine_version"], strict=True))


def _pairs(published: Store, store: Store) -> Iterator[_Pair]:
    """Trials that ask the same of an engine, and were answered on both sides."""
    rows = {_question(row): row for row in records(published.asked) if row["status"] not in LOST}
    for row in records(store.asked):
        if row["status"] not in LOST and (then := rows.get(_question(row))) is not None:
            yield then, row


def _question(row: Mapping[str, Any]) -> tuple[Any, ...]:
    return scene_of(str(row["case"])), *(row[name] for name in _SAME)
