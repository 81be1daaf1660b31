"""A page for each case: the question, its truth and checks, error against time step and cost, and every trial."""

import csv
import io
import json
import shlex
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import pandas as pd

from harness.findings.emulations import whose
from harness.findings.tables.orders import Convergence, convergences
from harness.intake.safe_text import csv_cell
from reports.answers import answers
from reports.charts import error_by_step
from reports.contents import FAMILIES, cases, engines, tracks
from reports.disputes import disputed, told
from reports.laws import laws_of_case
from reports.leads import leads
from reports.page import Page
from reports.price_list import price_list
from reports.template import case_file, fill
from reports.text import slug
from reports.verdict import verdicts
from reports.work_precision import scenes, work_precision

if TYPE_CHECKING:
    from harness.store.store import Store

__all__ = ["PAGE"]


def render(store: "Store") -> Mapping[str, str]:
    """For each case its page, its charts and its trials as CSV."""
    files: dict[str, str] = {}
    rows, cells, known, ladders = answers(store, store.trials), verdicts(store), cases(store), convergences(store)
    plain_rows = set(store.asked["trial"])
    prices = price_list(store) if scenes(store) else []
    names = list(known)
    sides = [(engine, track) for engine in engines(store) for track in tracks(store)]
    for place, name in enumerate(names):
        case, mine = known[name], in_order(rows[rows["case"] == name], sides)
        measured = numbered(store.measurements[store.measurements["trial"].isin(mine["trial"])])
        values: dict[str, dict[str, Any]] = {}
        for row in measured.to_dict("records"):
            values.setdefault(row["trial"], {})[row["metric"]] = row
        plain = slug(name)
        unit = next((str(unit) for unit in mine["unit"].dropna()), "1")
        by_step = error_by_step(store, mine[mine["trial"].isin(plain_rows)], f"case-{plain}", case["headline"], unit)
        figures = [by_step] if by_step is not None else []
        figures += [work_precision(store, scene) for scene in scenes(store) if scene.case == name]
        listed = [line for line in prices if line.case == name]
        recording = store.folder / "recordings" / f"{name}.rrd"
        files[f"trials/{plain}.csv"] = as_csv(mine, measured)
        files |= {figure.path: figure.svg for figure in figures}
        files[case_file(name)] = fill(
            "case.html",
            store,
            title=case["title"],
            case=case,
            family=FAMILIES.get(case["family"], case["family"]),
            before=known[names[place - 1]] if place else None,
            after=known[names[place + 1]] if place + 1 < len(names) else None,
            figures=figures,
            prices=listed,
            several=len({line.title for line in listed}) > 1,
            laws=laws_of_case(store, case),
            leads=[lead for (of, _), lead in leads(store).items() if of == name],
            orders=(fitted := orders([row for row in ladders if row.case == name], sides)),
            broken=[
                (row.finding, whose(store.catalogue, row.engine, name, row.track), disputed(store, row.engine, name))
                for row in fitted
                if row.finding
            ],
            disputes=told(store, name),
            verdicts={(engine, track): cells[name, engine, track] for engine, track in sides if (name, engine, track) in cells},
            metrics=list(dict.fromkeys([case["headline"], *measured["metric"]])) if len(measured) else [],
            trials=[trial(store, row, values.get(row["trial"], {})) for row in mine.to_dict("records")],
            csv=f"trials/{plain}.csv",
            recording=f"../recordings/{name}.rrd" if is_file(recording) else None,
            view=f"plumbline view {shlex.quote(str(store.folder))} {shlex.quote(name)}",
        )
    return files


def numbered(measured: pd.DataFrame) -> pd.DataFrame:
    """A metric that a case checks twice, over two windows, gets a number from the second on: no measurement hides another."""
    again = measured.groupby(["trial", "metric"]).cumcount()
    names = [f"{metric} #{k + 1}" if k else metric for metric, k in zip(measured["metric"], again, strict=True)]
    return measured.assign(metric=pd.Series(names, index=measured.index, dtype=object))


def in_order(rows: pd.DataFrame, sides: list[tuple[str, str]]) -> pd.DataFrame:
    """Engine by engine, track by track, from coarse to fine."""
    place = [sides.index(side) for side in zip(rows["engine"], rows["track"], strict=True)]
    return (
        rows.assign(place=place)
        .sort_values(["place", "dt", "seed"], ascending=[True, False, True], kind="stable")
        .drop(columns="place")
    )


def is_file(path: Any) -> bool:
    """Is there such a file? A name that the system refuses is none."""
    try:
        return bool(path.is_file())
    except (OSError, ValueError):
        return False


def orders(ladders: list[Convergence], sides: list[tuple[str, str]]) -> list[Convergence]:
    """The ladders that have a fit or need none, engine by engine and track by track."""
    told = [row for row in ladders if row.order is not None or row.verdict == "exact"]
    return sorted(told, key=lambda row: sides.index((row.engine, row.track)))


def trial(store: "Store", row: Mapping[str, Any], values: Mapping[str, Any]) -> dict[str, Any]:
    """A row of the table of trials."""
    nothing = {name: None for name, value in row.items() if pd.api.types.is_scalar(value) and pd.isna(value)}
    values = {name: {**one, "passed": None if pd.isna(one["passed"]) else bool(one["passed"])} for name, one in values.items()}
    return {
        **row,
        **nothing,
        "values": values,
        "resolved": row["resolved"],
        "warnings": json.loads(row["warnings"]) if row["warnings"] else [],
        "reproduce": f"plumbline reproduce {shlex.quote(str(store.folder))} {shlex.quote(str(row['trial']))}",
    }


def as_csv(rows: pd.DataFrame, measured: pd.DataFrame) -> str:
    """Trials with one column a metric; cells that a spreadsheet would run are made text."""
    columns = [name for name in rows.columns if name not in ("error", "metric", "at_most", "unit", "answered", "series")]
    table = rows[columns]
    if len(measured):
        wide = measured.pivot_table(index="trial", columns="metric", values="value", aggfunc="first", dropna=False, sort=False)
        wide.columns = [f"{name} (metric)" if name in table.columns else name for name in map(str, wide.columns)]
        table = table.join(wide, on="trial")
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow([csv_cell(str(name)) for name in table.columns])
    writer.writerows(
        [csv_cell("" if pd.api.types.is_scalar(v) and pd.isna(v) else v) for v in row] for row in table.to_numpy(object)
    )
    return text.getvalue()


PAGE = Page(name="case", title="Cases", order=50, render=render, listed=False)
