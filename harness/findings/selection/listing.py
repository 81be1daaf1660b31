"""The evidence that an answer leans on: each engine in each case by each criterion, with its run."""

from collections.abc import Mapping, Sequence
from typing import Any

from plumbline.harness.findings.selection.choose import Answer
from plumbline.harness.findings.steps_taken import step_in_words

COLUMNS = ("criterion", "case", "engine", "value", "low", "high", "says", "track", "dt", "substeps", "trial")
"""value: 1 is as good as is asked, 0 is of no use, with its interval low..high; says: the figure behind it. dt [s], taken in
substeps."""
BRIEF = ("criterion", "case", "engine", "of 1", "because", "settings", "step", "trial")


def rows(answer: Answer) -> list[dict[str, Any]]:
    """Flat rows with COLUMNS."""
    return [
        {
            "criterion": criterion,
            "case": case,
            "engine": engine,
            "value": datum.value,
            "low": datum.low,
            "high": datum.high,
            "says": datum.says,
            "track": datum.track,
            "dt": datum.dt,
            "substeps": None if datum.dt is None else datum.substeps,
            "trial": datum.trial,
        }
        for (criterion, case, engine), datum in sorted(answer.evidence.table.items())
    ]


def brief(row: Mapping[str, Any]) -> Sequence[object]:
    """A flat row in short words under BRIEF."""
    step = "" if row["dt"] is None else step_in_words(row["dt"], row["substeps"])
    return [row["criterion"], row["case"], row["engine"], f"{row['value']:.2f}", row["says"], row["track"], step, row["trial"]]
