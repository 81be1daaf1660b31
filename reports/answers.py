"""One row a trial: what was asked, how it ended, the headline error and what it cost; the rows that charts and tables draw."""

import json
from typing import TYPE_CHECKING

import numpy as np
import pandas as pd

from harness.record import digest
from reports.contents import cases
from reports.status import outcome
from reports.text import settings_text

if TYPE_CHECKING:
    from harness.store import Store

__all__ = ["answers", "at_own_step"]


def answers(store: "Store") -> pd.DataFrame:
    """All trials with their headline measurement.

    Returns:
        The columns of `trials`, and error (headline metric, NaN where there is none), unit, at_most, metric, answered,
        settings_line, and series: a name that trials share when only their step or seed differs.
    """
    trials = store.trials.reset_index(drop=True)
    known = cases(store)
    headline = pd.DataFrame({"trial": trials["trial"], "metric": [known[name]["headline"] for name in trials["case"]]})
    found = store.measurements.drop_duplicates(["trial", "metric"])[["trial", "metric", "value", "unit", "at_most"]]
    joined = headline.merge(found, on=["trial", "metric"], how="left").drop_duplicates("trial").set_index("trial")
    rows = trials.join(joined, on="trial").rename(columns={"value": "error"})
    rows["error"] = pd.to_numeric(rows["error"], errors="coerce").astype("float64").abs()
    rows["answered"] = [outcome(name).answered for name in rows["status"]]
    rows.loc[~rows["answered"] | ~np.isfinite(rows["error"]), "error"] = np.nan
    rows["settings_line"] = [settings_text(text) for text in rows["settings"]]
    rows["series"] = [
        digest([engine, track, experiment, stepless(settings)])
        for engine, track, experiment, settings in zip(
            rows["engine"], rows["track"], rows["experiment"], rows["settings"], strict=True
        )
    ]
    return rows


def stepless(settings: str) -> str:
    """Settings without the time step, in one spelling."""
    try:
        fields = json.loads(settings)
    except ValueError:
        return settings
    if isinstance(fields, dict):
        fields = {name: value for name, value in fields.items() if name not in ("dt", "source")}
    return json.dumps(fields, sort_keys=True)


def at_own_step(store: "Store", rows: pd.DataFrame) -> pd.DataFrame:
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
