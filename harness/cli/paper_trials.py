"""The table of trials as a paper prints it: titles for names, units in headings, digits that count."""

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

from plumbline.harness.findings.columns import Column, Titles, headings, milli, span
from plumbline.harness.findings.parameter_words import substeps_of
from plumbline.harness.statistics.interval import Interval

if TYPE_CHECKING:
    from plumbline.harness.store.store import Store


def titles_of(store: "Store") -> Titles:
    """What cases and engines are called on pages."""
    from plumbline.reports.words.catalogue import cases, engines

    of_cases = {name: str(case["title"]) for name, case in cases(store).items()}
    return Titles(of_cases, {name: str(engine["title"]) for name, engine in engines(store).items()})


def paper_trials(store: "Store", rows: Sequence[Mapping[str, Any]]) -> tuple[list[str], list[list[object]]]:
    """Headings and cells."""
    titles, cases, table = titles_of(store), store.catalogue.get("cases", {}), store.measurements
    values = {
        (trial, metric): (float(value), str(unit))
        for trial, metric, value, unit in zip(table["trial"], table["metric"], table["value"], table["unit"], strict=True)
    }

    def error(row: Mapping[str, Any]) -> tuple[float | None, str]:
        return values.get((row["trial"], cases.get(row["case"], {}).get("headline", "")), (None, ""))

    columns = (
        Column("Case", lambda row: titles.cases[row["case"]]),
        Column("Engine", lambda row: titles.engines[row["engine"]]),
        Column("Track", "track"),
        Column("Time step [ms]", lambda row: milli(row["dt"])),
        Column("Sub-steps", lambda row: substeps_of(str(row["resolved"]))),
        Column("Error", lambda row: error(row)[0]),
        Column("Unit", lambda row: error(row)[1]),
        Column("CPU time [ms/s]", lambda row: milli(row["cpu_per_sim_s"])),
        Column("95 % interval", lambda row: span(Interval(row["cpu_per_sim_s"], row["cpu_low"], row["cpu_high"]), 1e3)),
        Column("Outcome", "status"),
    )
    return headings(columns), [[column.cell(row) for column in columns] for row in rows]
