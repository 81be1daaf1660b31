"""The rows of the table of all trials of a case, on its page and as CSV."""

import csv
import io
import shlex
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import pandas as pd

from harness.intake.safe_text import csv_cell
from reports.reasons import notices

if TYPE_CHECKING:
    from harness.store.store import Store

__all__ = ["as_csv", "in_order", "is_file", "numbered", "trial"]


def numbered(measured: pd.DataFrame) -> pd.DataFrame:
    """A metric that a case checks twice, over two windows, gets a number from the second on: no measurement hides another."""
    again = measured.groupby(["trial", "metric"]).cumcount()
    names = [f"{metric} #{k + 1}" if k else metric for metric, k in zip(measured["metric"], again, strict=True)]
    return measured.assign(metric=pd.Series(names, index=measured.index, dtype=object))


def in_order(rows: pd.DataFrame, sides: list[tuple[str, str]]) -> pd.DataFrame:
    """Engine by engine, track by track, from coarse to fine."""
    ranks = [sides.index(side) for side in zip(rows["engine"], rows["track"], strict=True)]
    return (
        rows.assign(side=ranks)
        .sort_values(["side", "dt", "seed"], ascending=[True, False, True], kind="stable")
        .drop(columns="side")
    )


def is_file(path: Any) -> bool:
    """Is there such a file? A name that the system refuses is none."""
    try:
        return bool(path.is_file())
    except (OSError, ValueError):
        return False


def _missing(value: Any) -> bool:
    """Is a cell of a table empty? `pandas.isna` asks more, and a report asks it of every cell of every trial."""
    return value is None or value is pd.NA or (isinstance(value, float) and value != value)


def trial(store: "Store", row: Mapping[str, Any], values: Mapping[str, Any]) -> dict[str, Any]:
    """A row of the table of trials."""
    nothing = {name: None for name, value in row.items() if _missing(value)}
    values = {
        name: {**measured, "passed": None if pd.isna(measured["passed"]) else bool(measured["passed"])}
        for name, measured in values.items()
    }
    return {
        **row,
        **nothing,
        "values": values,
        "resolved": row["resolved"],
        "warnings": notices(store, str(row["trial"])),
        "reproduce": f"plumbline reproduce {shlex.quote(str(store.folder))} {shlex.quote(str(row['trial']))}",
    }


def as_csv(rows: pd.DataFrame, measured: pd.DataFrame) -> str:
    """Trials with one column a metric; cells that a spreadsheet would run are made text."""
    columns = [
        name for name in rows.columns if name not in ("error", "metric", "at_most", "unit", "answered", "series", "said")
    ]
    cells = [_cells(rows[name]) for name in columns]
    # A pivot and a join take longer than all else of a page.
    values: dict[str, dict[str, Any]] = {}
    for trial_name, metric, value in zip(measured["trial"], measured["metric"], measured["value"], strict=True):
        of_metric = values.setdefault(str(metric), {})
        if not _missing(value):
            of_metric.setdefault(trial_name, value)
    for metric, of_trial in values.items():
        columns.append(f"{metric} (metric)" if metric in rows.columns else metric)
        cells.append([csv_cell(of_trial.get(name, "")) for name in rows["trial"]])
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow([csv_cell(str(name)) for name in columns])
    writer.writerows(zip(*cells, strict=True))
    return text.getvalue()


def _cells(column: "pd.Series[Any]") -> list[Any]:
    """A column for a CSV file; a word is looked at once, however often it stands there."""
    words: dict[str, Any] = {}
    cells: list[Any] = []
    for value in column.to_numpy(object):
        if isinstance(value, str):
            if value not in words:
                words[value] = csv_cell(value)
            cells.append(words[value])
        else:
            cells.append(csv_cell("" if _missing(value) else value))
    return cells
