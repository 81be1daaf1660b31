"""The points of a chart: plain rows with units for axes, and an edge for every trial that has no place on them."""

import math
from typing import Any

import pandas as pd

from plumbline.harness.findings.steps_taken import substeps_of
from plumbline.harness.store.rows import records
from plumbline.harness.store.store import Store
from plumbline.reports.charts.grammar import Row
from plumbline.reports.words.catalogue import labels, setting_words
from plumbline.reports.words.status import outcome
from plumbline.reports.words.text import step, visible


def number(value: Any) -> float | None:
    """A finite float, or None: JSON has no NaN."""
    return float(value) if pd.notna(value) and math.isfinite(value) else None


def points(store: Store, rows: pd.DataFrame) -> list[Row]:
    """Rows of `answers` for a chart.

    Terms of a row:
        engine, track, series, trial, status, symbol, reason, settings: words. dt [ms]; step: the same in words, with
        the sub-steps that it was taken in. error [its unit], cpu, low,
        high [CPU s per simulated s]; pace [simulated s per CPU s]. edge: 'none' where the error can be drawn on a
        logarithmic axis, 'exact' where it is
        0, 'outcome' where there is no error.
    """
    names = labels(store)
    drawn = []
    for row in records(rows):
        error, cpu = number(row["error"]), number(row["cpu_per_sim_s"])
        cpu = cpu if cpu is not None and cpu > 0 else None
        low, high = number(row["cpu_low"]), number(row["cpu_high"])
        drawn.append(
            {
                "engine": names[row["engine"]],
                "track": visible(setting_words(store, row["engine"], str(row["track"])))[:60],
                "series": row["series"],
                "trial": row["trial"],
                "case": row["case"],
                "status": outcome(row["status"]).name,
                "symbol": outcome(row["status"]).symbol,
                "reason": visible(str(row["said"]))[:300],
                "settings": visible(row["settings_line"])[:300],
                "dt": 1e3 * float(row["dt"]),
                "step": step(float(row["dt"]), substeps_of(str(row["resolved"]))),
                "error": error,
                "bound": number(row["at_most"]),
                "cpu": cpu,
                "pace": 1 / cpu if cpu is not None else None,
                "low": low if low is not None and low > 0 and cpu is not None else cpu,
                "high": high if high is not None and cpu is not None else cpu,
                "edge": "outcome" if error is None else "exact" if error == 0 else "none",
            }
        )
    return drawn
