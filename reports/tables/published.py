"""The published dataset as a table: each engine with what it passes, errs by and costs there, beside what a run measured."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from plumbline.harness.findings.beside_published import BesidePublished, beside_published
from plumbline.harness.store.published import NotPublished, published
from plumbline.harness.store.store import Store
from plumbline.reports.tables.engine_summary import Glance, glances
from plumbline.reports.words.catalogue import engines, titles


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
