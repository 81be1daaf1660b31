"""What is found of each channel of each sensor on each engine, from its readings, its checks and the clock.

A finding tells of the trial that stands nearest to its case's own time step; prices come from the trials beside it that clocked
the sensors or their bare rays. A trial without readings is a finding without a channel, with its outcome.
"""

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import pandas as pd

from plumbline.harness.findings.columns import known
from plumbline.harness.findings.once import once
from plumbline.harness.findings.parameter_words import substeps_taken, where_of
from plumbline.harness.findings.sensor_readings.channel import RAYS, SILENT, Channel, Noise, NoiseCurve, channels, rays_of
from plumbline.harness.findings.sensor_readings.depth import depth_levels, depth_noise, range_histogram, ranging_noise
from plumbline.harness.findings.sensor_readings.ideal import (
    CameraPicture,
    IdealErrors,
    converged_readings,
    first_picture,
    ideal_errors,
    lag_by_law,
    lag_of,
)
from plumbline.harness.findings.sensor_readings.inertial import allan_curve, inertial_noise
from plumbline.harness.scene import Lidar, Scene
from plumbline.harness.scene.file import parse
from plumbline.harness.store.journal import StoreError
from plumbline.harness.store.store import Store

MEASURES: Mapping[str, tuple[Callable[[Channel], Noise | None], Callable[[Channel], NoiseCurve | None]]] = {
    "imu": (inertial_noise, allan_curve),
    "lidar": (ranging_noise, range_histogram),
    "depth_camera": (depth_noise, depth_levels),
}
"""What is found of noise beside its law, as numbers and as a curve, by the type of a sensor."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class SensorFinding:
    """One channel of one sensor on one engine and track.

    Terms:
        where: the parameters that are not the case's own. readings: how many, of `values` numbers each. error_max, error_rms,
        error_median [unit]: of the ideal signal against the truth; disagree: share that meets another surface, or none.
        metric, at_most, passed: the case's own check of that signal, and error its value; the largest error without a check.
        noise: what is found of it beside its law.
        lag, lag_law [s]: behind the motion. rays_per_s: beams or pixels a CPU second, sensors read and noise laid over;
        bare_rays_per_s: of the beams, or of the case's own rays, alone; times_bare: what a ray that is read costs over a bare
        one, where all rays of the scene are beams. cpu_sensing [s]: of one interval of the scene's sensors.
        trial: the readings'; trial_sensing, trial_bare: the prices'. reason: why there is no answer, or what a number lacks.
        curve, picture: what charts draw.
    """

    case: str
    where: str
    engine: str
    track: str
    dt: float
    substeps: int
    sensor: str = ""
    type: str = ""
    channel: str = ""
    unit: str = ""
    readings: int = 0
    values: int = 0
    error_max: float | None = None
    error_rms: float | None = None
    error_median: float | None = None
    disagree: float | None = None
    error: float | None = None
    metric: str = ""
    at_most: float | None = None
    passed: bool | None = None
    noise: Noise = SILENT
    lag: float | None = None
    lag_law: float | None = None
    rays_per_s: float | None = None
    bare_rays_per_s: float | None = None
    times_bare: float | None = None
    cpu_sensing: float | None = None
    status: str
    reason: str
    trial: str
    trial_sensing: str = ""
    trial_bare: str = ""
    curve: NoiseCurve | None = None
    picture: CameraPicture | None = None


_READ = ["case", "parameters", "engine", "track", "dt", "seed", "status", "reason", "trial", "trajectory_hash"]
_READ += ["unit", "cpu_per_unit"]
"""Columns of a trial that are read here; to take the others along costs more than all else that is done with a row."""
SKETCHES = ("curve", "picture")
"""Fields for charts, too large for a row."""


_Prices = Mapping[str, tuple[float, str]]
"""CPU seconds of a unit, of one interval of all sensors ('sensing') or of one bare 'ray', with the trial that says so."""


def concerned(store: Store) -> pd.DataFrame:
    """The trials with sensors and, beside such, those that cast rays of their own; known without a look at trajectories."""
    cases = store.catalogue.get("cases", {})
    sensing = {name for name, case in cases.items() if "sensing" in case.get("effects", ()) or case.get("family") == "sensor"}
    trials = store.asked
    mine = trials["case"].isin(sensing)
    return trials[mine | (trials["unit"] == "ray")] if mine.any() else trials[mine]


@once
def findings(store: Store) -> tuple[SensorFinding, ...]:
    """All findings of a run, engine beside engine; worked out once for a store, since it reads every trajectory."""
    every = list(_findings(store))
    catalogue = store.catalogue
    cases, engines = ({name: index for index, name in enumerate(catalogue.get(kind, {}))} for kind in ("cases", "engines"))
    wheres = {where: index for index, where in enumerate(dict.fromkeys(finding.where for finding in every))}
    signals = {
        signal: index for index, signal in enumerate(dict.fromkeys((finding.sensor, finding.channel) for finding in every))
    }

    def rank(finding: SensorFinding) -> tuple[object, ...]:
        signal = signals[finding.sensor, finding.channel]
        engine = engines.get(finding.engine, len(engines))
        scene = cases.get(finding.case, len(cases)), finding.case, wheres[finding.where]
        return *scene, signal, engine, finding.engine, finding.track != "tuned", finding.track

    return tuple(sorted(every, key=rank))


def _findings(store: Store) -> Iterator[SensorFinding]:
    cases = store.catalogue.get("cases", {})
    trials = concerned(store)[_READ]
    for (case, parameters, engine, track), runs in trials.groupby(["case", "parameters", "engine", "track"], sort=False):
        about = cases.get(case, {})
        row = _nearest(runs, about.get("dt"))
        plain = SensorFinding(
            case=case,
            where=where_of(store.catalogue, case, parameters),
            engine=engine,
            track=track,
            dt=float(row["dt"]),
            substeps=substeps_taken(store).get(row["trial"], 1),
            status=str(row["status"]),
            reason="" if row["status"] in ("passed", "failed") else str(row["reason"]),
            trial=str(row["trial"]),
        )
        yield from _of_trial(store, plain, row, store.measured.get(row["trial"], ()), _prices(runs))


def _nearest(runs: pd.DataFrame, own: float | None) -> Mapping[str, Any]:
    """The row at the step nearest to the case's own, with readings before one without."""
    target = own or float(runs["dt"].min())
    known = runs.to_dict("records")
    return min(
        known,
        key=lambda row: (round(abs(math.log(row["dt"] / target)), 9), not isinstance(row["trajectory_hash"], str), row["seed"]),
    )


def _prices(runs: pd.DataFrame) -> _Prices:
    clocked = runs[runs["cpu_per_unit"] > 0]
    return {
        unit: (float(cost), str(trial))
        for unit, cost, trial in zip(clocked["unit"], clocked["cpu_per_unit"], clocked["trial"], strict=True)
    }


def _of_trial(
    store: Store, plain: SensorFinding, row: Mapping[str, Any], measured: Sequence[Mapping[str, Any]], prices: _Prices
) -> Iterator[SensorFinding]:
    if not isinstance(row["trajectory_hash"], str):
        yield plain
        return
    try:
        arrays = {**converged_readings(store, plain.case), **store.trajectory(row["trajectory_hash"])}
        scene = parse(str(arrays["scene"]))
    except (StoreError, KeyError, ValueError) as error:
        yield replace(plain, reason=f"{plain.reason}; {error}".lstrip("; "))
        return
    silent = True
    for channel in channels(scene, arrays):
        silent = False
        yield _of_channel(plain, channel, scene, arrays, measured, prices)
    if silent:
        yield replace(plain, reason=plain.reason or "no readings were kept")


def _of_channel(
    plain: SensorFinding,
    channel: Channel,
    scene: Scene,
    arrays: Mapping[str, Any],
    measured: Sequence[Mapping[str, Any]],
    prices: _Prices,
) -> SensorFinding:
    errors = ideal_errors(channel)
    measure, sketch = MEASURES.get(channel.type, (None, lambda _: None))
    noise = (None if measure is None else measure(channel)) or SILENT
    lacking = [word for word in (plain.reason, errors.why, noise.why) if word]
    seeing = channel.sensor is not None and rays_of(channel.sensor) > 0
    sensing, trial_sensing = prices.get("sensing", (None, ""))
    bare, trial_bare = prices.get("ray", (None, "")) if channel.type in ("lidar", RAYS) else (None, "")
    beams = all(isinstance(sensor, Lidar) or not rays_of(sensor) for sensor in scene.sensors)
    cast = [rays_of(sensor) * sensor.rate for sensor in scene.sensors]
    # The sensors of a scene share a price; each interval is the longest of them, in which faster ones read more often.
    rays = sum(cast) / min(sensor.rate for sensor in scene.sensors) if scene.sensors else 0.0
    read = sensing / rays if sensing and rays and seeing else None
    return replace(
        plain,
        sensor=channel.name,
        type=channel.type,
        channel=channel.channel,
        unit=channel.unit,
        readings=len(channel.time),
        values=channel.read[0].size if len(channel.read) else 0,
        **_error_fields(errors, _check(channel.channel, measured)),
        noise=noise,
        lag=lag_of(channel, scene, arrays),
        lag_law=lag_by_law(channel),
        rays_per_s=1.0 / read if read else None,
        bare_rays_per_s=1.0 / bare if bare else None,
        times_bare=read / bare if read and bare and beams else None,
        cpu_sensing=sensing,
        reason="; ".join(lacking),
        trial_sensing=trial_sensing,
        trial_bare=trial_bare,
        curve=None if measure is None else sketch(channel),
        picture=first_picture(channel),
    )


def _error_fields(errors: IdealErrors, check: Mapping[str, Any]) -> dict[str, Any]:
    measured = known(errors, "error_max", "error_rms", "error_median", "disagree")
    if not check:
        return measured | {"error": errors.error_max}
    bound = None if pd.isna(check["at_most"]) else float(check["at_most"])
    judged = {"metric": check["metric"], "at_most": bound, "passed": bool(check["passed"])}
    return measured | judged | {"error": float(check["value"])}


def _check(channel: str, measured: Sequence[Mapping[str, Any]]) -> Mapping[str, Any]:
    """The case's first check of a channel's ideal signal: '<channel>_error...' or '<channel>_ideal_error...'."""
    starts = (f"{channel}_error", f"{channel}_ideal_error")
    return next((m for m in measured if str(m["metric"]).startswith(starts) and not pd.isna(m["passed"])), {})
