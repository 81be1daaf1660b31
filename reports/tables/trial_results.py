"""One row a trial: what was asked, how it ended, the headline error and what it cost; the rows that charts draw, and those of
the table of all trials of a case, on its page and as CSV.
"""

import csv
import io
import json
import shlex
from collections import Counter
from collections.abc import Collection, Mapping, Sequence
from functools import lru_cache
from typing import Any

import numpy as np
import pandas as pd

from plumbline.harness.findings.agreement.found import errors_of
from plumbline.harness.findings.once import once
from plumbline.harness.intake.safe_text import csv_cell
from plumbline.harness.store.record import digest
from plumbline.harness.store.store import Store
from plumbline.reports.words.catalogue import TRACK_ORDER, cases
from plumbline.reports.words.status import notices, outcome, reasons
from plumbline.reports.words.text import settings_text


def answers(store: Store, trials: pd.DataFrame | None = None) -> pd.DataFrame:
    """Trials with their headline measurement; those that put a case as it is, unless others are given.

    Returns:
        The columns of `trials`, and error (headline metric, NaN where there is none), unit, at_most, metric, answered,
        settings_line, said (the reason in words), and series: a name that trials share when only their step or seed differs.
    """
    rows = _answers(store)
    return rows[rows["trial"].isin((store.asked if trials is None else trials)["trial"])].reset_index(drop=True)


@once
def _answers(store: Store) -> pd.DataFrame:
    """Of all trials, once for all that draw those of a store."""
    trials = store.trials.reset_index(drop=True)
    known = cases(store)
    columns = ("trial", "metric", "value", "unit", "at_most")
    measured = {
        (trial, metric): rest for trial, metric, *rest in store.measurements[list(columns)][::-1].itertuples(index=False)
    }
    headlines = [known[name]["headline"] for name in trials["case"]]
    nothing = [np.nan, None, np.nan]
    limits = {trial: [distance.error, "of its size", distance.off] for trial, distance in errors_of(store).items()}
    measurements = [
        limits.get(trial, measured.get((trial, headline), nothing))
        for trial, headline in zip(trials["trial"], headlines, strict=True)
    ]
    rows = trials.assign(
        metric=headlines,
        error=np.abs(np.array([value for value, _, _ in measurements], dtype=np.float64)),
        unit=pd.Series([unit for _, unit, _ in measurements], dtype=object),
        at_most=np.array([bound for _, _, bound in measurements], dtype=np.float64),
    )
    rows["answered"] = [outcome(name).answered for name in rows["status"]]
    rows.loc[~rows["answered"] | ~np.isfinite(rows["error"]), "error"] = np.nan
    said = reasons(store)
    rows["said"] = [said[trial] for trial in rows["trial"]]
    rows["settings_line"] = [settings_text(text) for text in rows["settings"]]
    rows["series"] = [
        digest([engine, track, experiment, stepless(settings)])
        for engine, track, experiment, settings in zip(
            rows["engine"], rows["track"], rows["experiment"], rows["settings"], strict=True
        )
    ]
    return rows


@lru_cache(maxsize=4096)
def stepless(settings: str) -> str:
    """Settings without the time step and their source, in one spelling."""
    try:
        fields = json.loads(settings)
    except ValueError:
        return settings
    if isinstance(fields, dict):
        fields = {name: value for name, value in fields.items() if name not in ("dt", "source")}
    return json.dumps(fields, sort_keys=True)


def at_own_step(store: Store, rows: pd.DataFrame) -> pd.DataFrame:
    """The trials at their case's own time step; of a case without one there, those at the step nearest to it.

    Comparing engines over all trials would weigh a case by the length of its ladder.
    """
    known = cases(store)
    kept = []
    for name, group in rows.groupby("case", sort=False):
        own = known[name]["dt"]
        steps = group["dt"].to_numpy(dtype=np.float64)
        target = steps.min() if own is None else steps[np.argmin(np.abs(np.log(steps / own)))]
        kept.append(group[np.isclose(steps, target, rtol=1e-9)])
    return pd.concat(kept) if kept else rows


def measured_of(store: Store, case: str) -> dict[str, dict[str, Mapping[str, Any]]]:
    """What was measured of the trials of a case: by trial, then by metric.

    A metric that a case checks twice, over two windows, gets a number from the second on: no measurement hides another.
    """
    measured: dict[str, dict[str, Mapping[str, Any]]] = {}
    for row in store.tried.get(case, ()):
        seen: Counter[str] = Counter()
        for measurement in store.measured.get(row["trial"], ()):
            metric = measurement["metric"]
            name = f"{metric} #{seen[metric] + 1}" if seen[metric] else metric
            seen[metric] += 1
            measured.setdefault(row["trial"], {})[name] = {**measurement, "metric": name}
    return measured


def metrics_of(measured: Mapping[str, Mapping[str, Any]]) -> list[str]:
    """The metrics of `measured_of`, in the order in which they were met."""
    return list(dict.fromkeys(metric for values in measured.values() for metric in values))


def in_order(rows: pd.DataFrame, sides: list[tuple[str, str]]) -> pd.DataFrame:
    """Engine by engine, track by track, from coarse to fine."""
    ranks = [sides.index(side) for side in zip(rows["engine"], rows["track"], strict=True)]
    return rows.iloc[np.lexsort((rows["seed"].to_numpy(float), -rows["dt"].to_numpy(float), ranks))]


MOST_ROWS = 200
"""That a page lists of a long table: a trial takes 3 to 8 kB."""


def rows_shown(ranks: Sequence[int]) -> list[int]:
    """The indices, in order, of the `MOST_ROWS` rows with the least ranks."""
    return sorted(sorted(range(len(ranks)), key=ranks.__getitem__)[:MOST_ROWS])


def listed(rows: pd.DataFrame, priced: Collection[str]) -> pd.DataFrame:
    """The trials that a page lists: of default and tuned first, then those that a price rests on (`priced`)."""
    sides = zip(rows["trial"], rows["track"], strict=True)
    return rows.iloc[rows_shown([0 if track in TRACK_ORDER else 1 + (trial not in priced) for trial, track in sides])]


def is_file(path: Any) -> bool:
    """Is there such a file? A name that the system refuses is none."""
    try:
        return bool(path.is_file())
    except (OSError, ValueError):
        return False


def _missing(value: Any) -> bool:
    """Is a cell of a table empty? `pandas.isna` asks more, and a report asks it of every cell of every trial."""
    return value is None or value is pd.NA or (isinstance(value, float) and value != value)


def trial(store: Store, row: Mapping[str, Any], values: Mapping[str, Any]) -> dict[str, Any]:
    """A row of the table of trials."""
    nothing = {name: None for name, value in row.items() if _missing(value)}
    values = {
        name: {**measured, "passed": None if _missing(measured["passed"]) else bool(measured["passed"])}
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


def as_csv(rows: pd.DataFrame, measured: Mapping[str, Mapping[str, Mapping[str, Any]]]) -> str:
    """Trials with one column a metric; cells that a spreadsheet would run are made text."""
    columns = [
        name for name in rows.columns if name not in ("error", "metric", "at_most", "unit", "answered", "series", "said")
    ]
    cells = [_cells(rows[name]) for name in columns]
    # A pivot and a join take longer than all else of a page.
    of_trials = [measured.get(name, {}) for name in rows["trial"]]
    for metric in metrics_of(measured):
        columns.append(f"{metric} (metric)" if metric in rows.columns else metric)
        cells.append([_cell(values[metric]["value"]) if metric in values else "" for values in of_trials])
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
            cells.append(_cell(value))
    return cells


def _cell(value: Any) -> Any:
    if type(value) is float:  # most cells are
        return "" if value != value else value
    return csv_cell("" if _missing(value) else value)
