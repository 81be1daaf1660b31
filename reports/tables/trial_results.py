"""One row a trial: what was asked, how it ended, the headline error and what it cost; the rows that charts and tables draw."""

import json
from functools import lru_cache

import numpy as np
import pandas as pd

from plumbline.harness.findings.agreement import errors_of
from plumbline.harness.store.record import digest
from plumbline.harness.store.store import Store
from plumbline.reports.words.catalogue import cases
from plumbline.reports.words.reasons import reasons
from plumbline.reports.words.status import outcome
from plumbline.reports.words.text import settings_text


def answers(store: Store, trials: pd.DataFrame | None = None) -> pd.DataFrame:
    """Trials with their headline measurement; those that put a case as it is, unless others are given.

    Returns:
        The columns of `trials`, and error (headline metric, NaN where there is none), unit, at_most, metric, answered,
        settings_line, said (the reason in words), and series: a name that trials share when only their step or seed differs.
    """
    rows = _answers(store)
    return rows[rows["trial"].isin((store.asked if trials is None else trials)["trial"])].reset_index(drop=True)


@lru_cache(maxsize=1)
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
