"""The published dataset as a table: each engine with what it passes, errs by and costs there, beside what a run measured."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from statistics import median
from typing import Any

import pandas as pd

from plumbline.harness.findings.changes.matching import LOST, scene_of
from plumbline.harness.store.published import NotPublished, published
from plumbline.harness.store.rows import records
from plumbline.harness.store.store import Store
from plumbline.reports.tables.engine_summary import Glance, glances
from plumbline.reports.words.catalogue import engines, titles

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


@dataclass(frozen=True, slots=True, kw_only=True)
class PublishedRow:
    """An engine. Terms: sides: by track, as published. beside: the run beside it; None where there is none."""

    engine: str
    title: str
    version: str
    ours: bool
    sides: Mapping[str, Glance]
    beside: BesidePublished | None = None

    @property
    def other(self) -> bool:
        """Was another version run here than was published, or none?"""
        return self.beside is not None and self.beside.version_here != self.beside.version


@dataclass(frozen=True, slots=True, kw_only=True)
class PublishedTable:
    """Terms: study, date, processor: of the dataset. cases: names to titles. same: trials of the run that it holds too."""

    study: str
    date: str
    processor: str
    trials: int
    rows: Sequence[PublishedRow]
    cases: Mapping[str, str]
    same: int = 0


def published_table(store: Store | None = None) -> PublishedTable | None:
    """What is published, beside a run if there is one.

    None where nothing ships with the package, or the run has no trial that is published. Raises: StoreError, if it is damaged.
    """
    try:
        dataset = published()
    except NotPublished:
        return None
    besides = {} if store is None else beside_published(dataset, store)
    same = sum(beside.same for beside in besides.values())
    if store is not None and not same:
        return None
    sides: dict[str, dict[str, Glance]] = {}
    for glance in glances(dataset):
        sides.setdefault(glance.engine, {})[glance.track] = glance
    machine = dataset.machine
    return PublishedTable(
        study=str(dataset.study.get("title") or dataset.study.get("name", "")),
        date=str(machine.get("started", ""))[:10],
        processor=str(machine.get("processor", "")),
        trials=len(dataset.trials),
        rows=[
            PublishedRow(
                engine=name,
                title=about["title"],
                version=str(about["version"] or ""),
                ours=about["ours"],
                sides=sides[name],
                beside=besides.get(name),
            )
            for name, about in engines(dataset).items()
            if name in sides
        ],
        cases=titles(dataset),
        same=same,
    )


BEGIN, END = "<!-- published: begin (written by plumbline publish) -->", "<!-- published: end -->"
"""Between which lines of the README the table stands."""


def in_markdown(table: PublishedTable) -> str:
    """The table of the README, with where it comes from."""
    lines = [
        "| engine | version | cases passed, defaults → tuned | CPU time, tuned [x least] | error, tuned [x least] |",
        "|---|---|---|---|---|",
    ]
    for row in table.rows:
        passed = " → ".join(f"{glance.held}/{glance.asked}" for glance in row.sides.values())
        tuned = row.sides.get("tuned") or next(iter(row.sides.values()))
        figures = ("none" if value is None else f"{value:.2g}" for value in (tuned.relative_cost, tuned.relative_error))
        name = f"{row.title} (not ranked)" if row.ours else row.title
        lines.append(f"| {name} | {row.version.partition('+')[0]} | {passed} | {' | '.join(figures)} |")
    where = f"{table.study}, {table.trials} trials, {table.date}, {table.processor or 'processor not known'}"
    lines += [
        "",
        f"Geometric means over the cases that every engine answers; {where}. `plumbline select --published` ranks by it.",
    ]
    return "\n".join(lines)
