"""Long runs: does what should stay stay, or does it run away little by little?

Of motions whose energy is conserved, that energy as a share of what is in play; of things at rest, how far the body that went
farthest is from its place. A line through it says whether it only swings or has a trend, with the interval of its slope.
"""

import math
from collections.abc import Mapping, Sequence
from contextlib import suppress
from typing import Any

import numpy as np

from plumbline.harness.findings.columns import Column, Row, Table, side
from plumbline.harness.findings.parameter_words import columns_with_substeps, with_substeps
from plumbline.harness.metric import NotMeasurable
from plumbline.harness.metrics.conservation import energy_change
from plumbline.harness.scene.file import parse
from plumbline.harness.statistics.order import fit_slope
from plumbline.harness.store.journal import NotKept
from plumbline.harness.store.rows import records
from plumbline.harness.store.store import Store
from plumbline.harness.trajectory import Floats, Trajectory
from plumbline.harness.trajectory.kinematics import movable

LONG = 100_000
"""Steps from which a run is a long one."""
UNITS = {"energy": "1", "place": "m"}
EXACT = 1e-9
"""Changes over a whole run, in the quantity's unit, below which nothing has happened: rounding, added up."""


_OF_RUN = ("case", "engine", "track", "dt", "steps")
_OF_FIT = ("quantity", "unit", "slope", "low", "high", "swing", "change", "verdict")
_OUTCOME = ("status", "reason", "trial")


def _rows(store: Store) -> list[dict[str, Any]]:
    """One for each long run.

    Terms:
        quantity: 'energy', as a share of that in play, or 'place' [m]. slope, low, high: per second, with the 95 % interval.
        swing: of the series about that line. change: over the whole run. verdict: 'bounded', 'gains', 'loses' (a secular
        trend), 'still' (no change at all), or the status of a run without an answer.
    """
    plain = store.asked
    duration = {name: float(store.described("cases", name)["duration"]) for name in plain["case"].unique()}
    long = [row for row in records(plain) if duration[row["case"]] / row["dt"] >= LONG]
    return with_substeps(
        store,
        (
            {name: row[name] for name in _OF_RUN}
            | dict.fromkeys(_OF_FIT)
            | {"quantity": "", "unit": ""}
            | _trend(store, row)
            | {name: row[name] for name in _OUTCOME}
            for row in long
        ),
    )


def _trend(store: Store, row: Mapping[str, Any]) -> dict[str, Any]:
    """What became of a run's quantity: the columns of `_OF_FIT` that are known."""
    if row["status"] not in ("passed", "failed"):
        return {"verdict": row["status"]}
    rests = store.described("cases", row["case"])["truth"] == "rest"
    try:
        quantity, time, series = _series(store.trajectory(row["trajectory_hash"]), rests)
    except NotKept:
        return {"verdict": "not kept"}
    measured = {"quantity": quantity, "unit": UNITS[quantity]}
    fit = fit_slope(time.tolist(), series.tolist()) if np.isfinite(series).all() else None
    if fit is None:
        return measured | {"verdict": "too short"}
    trend = ("gains" if fit.slope > 0 else "loses") if fit.secular else "bounded"
    return measured | {
        "slope": fit.slope,
        "low": fit.low,
        "high": fit.high,
        "swing": fit.swing,
        "change": fit.slope * float(time[-1] - time[0]),
        "verdict": "still" if float(np.ptp(series)) < EXACT else trend,
    }


def _series(kept: Mapping[str, Any], rests: bool) -> tuple[str, Floats, Floats]:
    """Quantity, time (t,) s and series (t,) of a trajectory as a run folder keeps it, after its first tenth.

    Of what `rests` it is the place, since there is no energy in play.
    """
    scene = parse(str(kept["scene"]))
    time, p_WB, q_WB, v_WB, w_WB = (kept[name] for name in ("time", "p_WB", "q_WB", "v_WB", "w_WB"))
    run = Trajectory(time, p_WB, q_WB, v_WB, w_WB, dt=float(kept["dt"]))
    first = len(run) // 10
    with suppress(NotMeasurable):
        if not rests:
            return "energy", run.time[first:], energy_change(scene, run, None)[first:]
    moved = movable(scene)
    start = np.array([scene.bodies[index].p_WB for index in moved])
    away: Floats = np.linalg.norm(run.p_WB[:, moved] - start, axis=2).max(axis=1)
    return "place", run.time[first:], away[first:]


def _fitted(row: Row, text: str) -> str:
    """A cell about the fit; empty without one."""
    return "" if row["slope"] is None else text.format(**row)


def _verdict(row: Row) -> str:
    return str(row["verdict"]) + (f", {row['status']}" if row["slope"] is not None and row["status"] != "passed" else "")


def _sentences(rows: Sequence[Row]) -> list[str]:
    """Who stays, and who runs away, case by case."""
    lines = []
    for case in dict.fromkeys(row["case"] for row in rows):
        mine = [row for row in rows if row["case"] == case and row["slope"] is not None]
        for verdict in ("gains", "loses"):
            bad = [row for row in mine if row["verdict"] == verdict and math.isfinite(row["change"])]
            if bad:
                listed = ", ".join(f"{row['engine']} ({row['track']}) by {abs(row['change']):.2g}" for row in bad)
                lines.append(
                    f"{case}: {bad[0]['quantity']} {'grows' if verdict == 'gains' else 'falls'} over the run: {listed}."
                )
    return lines


TABLE = Table(
    columns=columns_with_substeps([*_OF_RUN, *_OF_FIT, *_OUTCOME]),
    objects=_rows,
    row=dict,
    shown=(
        Column("case", "case"),
        Column("engine", side),
        Column("steps", "steps"),
        Column("quantity", lambda row: f"{row['quantity']}{'' if row['unit'] in ('', '1') else ' [' + row['unit'] + ']'}"),
        Column("per second", lambda row: _fitted(row, "{slope:.2g} ({low:.2g}..{high:.2g})")),
        Column("over the run", lambda row: _fitted(row, "{change:.2g}")),
        Column("swings by", lambda row: _fitted(row, "{swing:.2g}")),
        Column("verdict", _verdict),
    ),
    sentences=_sentences,
)
