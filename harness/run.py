"""The accuracy run: one trial in this process, from scene to record; nothing is clocked here."""

import math
from dataclasses import replace
from pathlib import Path
from typing import cast

import numpy as np

from harness.adapter import Adapter, Diverged, Feature, SettingsError, Simulation, Unavailable, Unsupported
from harness.batch import WorldOf, spread
from harness.case import Case, Converged, Rays
from harness.control import Controlled
from harness.metric import Metric, NotMeasurable
from harness.record import Measurement, Record, Status
from harness.scene import Scene
from harness.sensors.recorder import SensorRecorder
from harness.study import Trial
from harness.trajectory import Contacts, Floats, State, Trajectory
from harness.trajectory_file import save_trajectory
from harness.truth_keeper import truth_of

__all__ = ["judge", "outcome", "run_trial", "simulate", "steps_between_samples", "truth_of"]


def outcome(trial: Trial, status: Status, reason: str, detail: str = "") -> Record:
    """The record of a trial that gave no trajectory."""
    return Record(
        trial=trial.trial,
        study=trial.study,
        experiment=trial.experiment.name,
        case=trial.case,
        parameters=trial.parameters,
        engine=trial.engine,
        engine_version=trial.engine_version,
        track=trial.track,
        dt=trial.settings.dt,
        settings=trial.settings.plain(),
        seed=trial.seed,
        status=status,
        reason=reason,
        detail=detail,
    )


def steps_between_samples(interval: float, dt: float) -> int:
    """Whole steps of dt [s] between two samples `interval` [s] apart, at least one."""
    return max(1, round(interval / dt))


class _Log:
    """Room for a trajectory, filled sample by sample."""

    def __init__(self, steps: int, every: int, dt: float, bodies: int, with_contacts: bool) -> None:
        places = [*range(0, steps, every), steps]
        self.trajectory = Trajectory.of(np.array(places, dtype=np.float64) * dt, bodies)
        self.contacts: list[Contacts] | None = [] if with_contacts else None
        self.filled = 0

    def take(self, simulation: Simulation) -> State:
        """Read the next sample; raises Diverged where it is not finite."""
        state = self.trajectory.state(self.filled)
        simulation.state(state)
        if not state.finite:
            raise Diverged("the state is not finite")
        if self.contacts is not None:
            self.contacts.append(simulation.contacts())
        self.filled += 1
        return state

    def result(self, dt: float, streams: dict[str, Floats]) -> Trajectory:
        """The trajectory as far as it was filled."""
        n, t = self.filled, self.trajectory
        contacts = None if self.contacts is None else tuple(self.contacts)
        return Trajectory(t.time[:n], t.p_WB[:n], t.q_WB[:n], t.v_WB[:n], t.w_WB[:n], dt=dt, contacts=contacts, streams=streams)


def simulate(
    simulation: Simulation,
    scene: Scene,
    *,
    dt: float,
    duration: float,
    sample_interval: float,
    with_contacts: bool,
    seed: int,
) -> tuple[Trajectory, str | None]:
    """Step a simulation to its end; the trajectory and, where it diverged, when and how."""
    steps = max(1, round(duration / dt))
    every = steps_between_samples(sample_interval, dt)
    log = _Log(steps, every, dt, len(scene.bodies), with_contacts)
    sensors = SensorRecorder(scene, simulation, seed, dt) if scene.sensors else None
    here, reading = 0, State.empty(len(scene.bodies))
    try:
        log.take(simulation)
        if sensors is not None:
            simulation.state(reading)
            sensors.read(0.0, reading)
        while here < steps:
            next_sample = min((here // every + 1) * every, steps)
            until = next_sample
            if sensors is not None:
                until = min(until, (here // sensors.interval_steps + 1) * sensors.interval_steps)
            simulation.step(until - here)
            here = until
            if here == next_sample:
                log.take(simulation)
            if sensors is not None and here % sensors.interval_steps == 0:
                simulation.state(reading)
                sensors.read(here * dt, reading)
    except Diverged as error:
        return log.result(dt, {}), f"by step {here + 1} of {steps} (t = {here * dt:.6g} s): {error}"
    return log.result(dt, {} if sensors is None else sensors.streams()), None


def cast_once(simulation: Simulation, rays: Rays) -> dict[str, Floats]:
    """Streams 'rays/range_ideal' and 'rays/body' of the rays of a case, cast at the start."""
    hits = simulation.cast(rays.origins, rays.directions, rays.max_range)
    bodies = hits.body[None].astype(np.float64)
    return {"rays/time": np.zeros(1), "rays/range_ideal": hits.distance[None], "rays/body": bodies}


def judge(case: Case, scene: Scene, actual: Trajectory, made: Converged | None) -> tuple[Measurement, ...]:
    """All checks and observations of a case on one trajectory.

    The bound of a distance [m] or speed [m/s] to the truth grows by the truth's own error.
    """
    expected = None if made is None else made.trajectory
    own = {} if made is None else {"m": made.position_error, "m/s": made.velocity_error}
    found = []
    for check in case.checks:
        end = math.inf if check.end is None else check.end
        part = actual.between(check.start, end) if check.start > 0 or check.end is not None else actual
        truth = None if expected is None else (expected.between(check.start, end) if part is not actual else expected)
        bound = check.bound(actual.dt)
        because = check.because if check.metric.better == "lower" else f"at least this: {check.because}"
        try:
            value = check.metric(scene, part, truth)
            passed: bool | None = check.passes(value, actual.dt)
            error = own.get(check.metric.unit, 0.0)
            if error > 0.0 and check.metric.better == "lower" and _compares(check.metric, scene, part):
                bound += error
                passed = bool(np.isfinite(value)) and value <= bound
                because = f"{because}; and {error:.2g} {check.metric.unit} that the truth itself may be off"
        except NotMeasurable as error:
            value, passed, because = math.nan, None, f"not measurable: {error}"
        found.append(
            Measurement(
                metric=check.metric.name, value=value, unit=check.metric.unit, at_most=bound, passed=passed, because=because
            )
        )
    checked = {check.metric.name for check in case.checks}
    for metric in case.observe:
        if metric.name not in checked:
            try:
                value, because = metric(scene, actual, expected), ""
            except NotMeasurable as error:
                value, because = math.nan, f"not measurable: {error}"
            found.append(Measurement(metric=metric.name, value=value, unit=metric.unit, because=because))
    return tuple(found)


def _compares(metric: Metric, scene: Scene, actual: Trajectory) -> bool:
    """Whether a metric measures against the truth: without one it cannot be measured."""
    try:
        metric(scene, actual, None)
    except NotMeasurable:
        return True
    return False


def _verdict(measurements: tuple[Measurement, ...]) -> tuple[Status, str]:
    broken = [m for m in measurements if m.passed is False]
    if broken:
        units = {m.metric: "" if m.unit == "1" else f" {m.unit}" for m in broken}
        return "failed", "; ".join(f"{m.metric} = {m.value:.4g}{units[m.metric]}, bound {m.at_most:.4g}" for m in broken)
    if not any(m.passed for m in measurements):
        return "unsupported", "; ".join(m.because for m in measurements) or "no check could be measured"
    blind = [m.metric for m in measurements if m.at_most is not None and m.passed is None]
    return "passed", f"every check holds{'; not measurable: ' + ', '.join(blind) if blind else ''}"


def run_trial(trial: Trial, case: Case, adapter: Adapter, folder: Path | None) -> Record:
    """Build, step, measure: the record of one accuracy run; its trajectory is kept under `folder` if one is given."""
    scene = case.scene(**trial.parameters)
    worlds, batch = case.count_of_worlds(trial.parameters), None
    simulation: Simulation
    try:
        if worlds > 1:
            batch = adapter.build_batch(scene, trial.settings, worlds)
            simulation = cast(Simulation, WorldOf(batch, worlds - 1))
        else:
            simulation = adapter.build(scene, trial.settings)
            if case.control is not None:
                acting = case.control(**trial.parameters)
                simulation = cast(Simulation, Controlled(simulation, acting, trial.settings.dt, len(scene.bodies)))
    except Unsupported as error:
        return outcome(trial, "unsupported", str(error))
    except Unavailable as error:
        return outcome(trial, "unavailable", str(error))
    except SettingsError as error:
        return outcome(trial, "failed", f"settings refused: {error}")
    dt = trial.settings.dt
    try:
        with_contacts = case.with_contacts and Feature.CONTACTS in adapter.features and batch is None
        try:
            seen = {} if case.rays is None else cast_once(simulation, case.rays(**trial.parameters))
            actual, broke = simulate(
                simulation,
                scene,
                dt=dt,
                duration=case.duration,
                sample_interval=case.sample_interval,
                with_contacts=with_contacts,
                seed=trial.seed,
            )
        except Unsupported as error:
            return outcome(trial, "unsupported", str(error))
        if case.worlds and broke is None:
            apart = 0.0 if batch is None else spread(batch, len(scene.bodies))
            seen |= {"worlds/time": actual.time[-1:], "worlds/spread": np.array([apart])}
        actual = replace(actual, streams={**actual.streams, **seen})
        resolved, warnings = simulation.resolved.plain(), simulation.warnings()
    finally:
        simulation.close()
    try:
        truth = truth_of(case, scene, actual.time, trial.parameters, folder)
    except (NotMeasurable, Unsupported) as error:
        truth, warnings = None, (*warnings, f"no truth: {error}")
    expected = None if truth is None else truth.trajectory
    measurements = () if broke is not None else judge(case, scene, actual, truth)
    status, reason = _verdict(measurements) if broke is None else ("diverged", broke)
    steps = round(float(actual.time[-1]) / dt) if len(actual) else 0
    return replace(
        outcome(trial, status, reason),
        resolved=resolved,
        warnings=warnings,
        measurements=measurements,
        sim_seconds=steps * dt,
        steps=steps,
        trajectory_hash=None if folder is None else save_trajectory(folder, scene, actual, expected),
    )
