"""Long runs: does what should stay stay, or does it run away little by little?

Of motions whose energy is conserved, that energy as a share of what is in play; of things at rest, how far the body that went
farthest is from its place. A line through it says whether it only swings or has a trend, with the interval of its slope.
"""

import math
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from plumbline.harness.findings.columns import Column, Table, plain
from plumbline.harness.findings.parameter_words import substeps_taken
from plumbline.harness.metric import NotMeasurable
from plumbline.harness.metrics.conservation import energy_change
from plumbline.harness.scene.file import parse
from plumbline.harness.statistics.order import Slope, fit_slope
from plumbline.harness.store.journal import NotKept
from plumbline.harness.store.rows import grouped, records
from plumbline.harness.store.store import Store
from plumbline.harness.trajectory import Floats, Trajectory
from plumbline.harness.trajectory.kinematics import movable

LONG = 100_000
"""Steps from which a run is a long one."""
UNITS = {"energy": "1", "place": "m"}
EXACT = 1e-9
"""Changes over a whole run, in the quantity's unit, below which nothing has happened: rounding, added up."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Drift:
    """One long run.

    Terms:
        run: its row of the table of trials. substeps: of its step. quantity: 'energy', as a share of that in play, or 'place'
        [m]; '' where it was not read. fit: of the quantity [per second]. change: over the whole run. verdict: 'bounded',
        'gains', 'loses' (a secular trend), 'still' (no change at all), or the status of a run without an answer.
    """

    run: Mapping[str, Any]
    substeps: int
    verdict: str
    quantity: str = ""
    fit: Slope | None = None
    change: float | None = None

    @property
    def unit(self) -> str:
        """Of the quantity."""
        return UNITS.get(self.quantity, "")


def _drifts(store: Store) -> list[Drift]:
    plain = store.asked
    duration = {name: float(store.described("cases", name)["duration"]) for name in plain["case"].unique()}
    return [_drift(store, row) for row in records(plain) if duration[row["case"]] / row["dt"] >= LONG]


def _drift(store: Store, row: Mapping[str, Any]) -> Drift:
    """What became of a run's quantity."""
    drift = Drift(run=row, substeps=substeps_taken(store).get(row["trial"], 1), verdict=row["status"])
    if row["status"] not in ("passed", "failed"):
        return drift
    rests = store.described("cases", row["case"])["truth"] == "rest"
    try:
        quantity, time, series = _series(store.trajectory(row["trajectory_hash"]), rests)
    except NotKept:
        return replace(drift, verdict="not kept")
    fit = fit_slope(time.tolist(), series.tolist()) if np.isfinite(series).all() else None
    if fit is None:
        return replace(drift, quantity=quantity, verdict="too short")
    trend = ("gains" if fit.slope > 0 else "loses") if fit.secular else "bounded"
    verdict = "still" if float(np.ptp(series)) < EXACT else trend
    return replace(drift, quantity=quantity, fit=fit, change=fit.slope * float(time[-1] - time[0]), verdict=verdict)


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


def _verdict(drift: Drift) -> str:
    status = drift.run["status"]
    return drift.verdict + (f", {status}" if drift.fit is not None and status != "passed" else "")


def _sentences(drifts: Sequence[Drift]) -> list[str]:
    """Who stays, and who runs away, case by case."""
    lines = []
    for case, mine in grouped(drifts, lambda drift: str(drift.run["case"])).items():
        for verdict, goes in (("gains", "grows"), ("loses", "falls")):
            bad = [d for d in mine if d.verdict == verdict and d.change is not None and math.isfinite(d.change)]
            if bad:
                listed = ", ".join(f"{d.run['engine']} ({d.run['track']}) by {abs(d.change or 0.0):.2g}" for d in bad)
                lines.append(f"{case}: {bad[0].quantity} {goes} over the run: {listed}.")
    return lines


TABLE = Table(
    holds="case=run.case engine=run.engine track=run.track dt=run.dt substeps steps=run.steps quantity unit slope=fit.slope "
    "low=fit.low high=fit.high swing=fit.swing change verdict status=run.status reason=run.reason trial=run.trial",
    objects=_drifts,
    shown=(
        Column("case", "run.case"),
        Column("engine", lambda drift: f"{drift.run['engine']}/{drift.run['track']}"),
        Column("steps", "run.steps"),
        Column("quantity", lambda drift: drift.quantity + ("" if drift.unit in ("", "1") else f" [{drift.unit}]")),
        Column(
            "per second",
            lambda drift: f"{fit.slope:.2g} ({fit.low:.2g}..{fit.high:.2g})" if (fit := drift.fit) is not None else "",
        ),
        *plain("over the run=change:.2g", "swings by=fit.swing:.2g"),
        Column("verdict", _verdict),
    ),
    sentences=_sentences,
)
