"""The accuracy run: one trial in this process, from scene to record; nothing is clocked here."""

import math
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass, fields, replace
from pathlib import Path
from typing import Any, cast

import numpy as np

from plumbline.harness.adapter import (
    Adapter,
    Diverged,
    Feature,
    Notice,
    Settings,
    SettingsError,
    Simulation,
    Unavailable,
    Unsupported,
)
from plumbline.harness.adapter.many_worlds import WorldOf, spread
from plumbline.harness.adapter.notice import as_notices
from plumbline.harness.adapter.what_comes_out import Answering
from plumbline.harness.case import Case, Converged, Rays
from plumbline.harness.case.commands import acting
from plumbline.harness.case.forces import Controlled
from plumbline.harness.case.own_truth import breaks
from plumbline.harness.case.symmetries import Retelling
from plumbline.harness.metric import Metric, NotMeasurable
from plumbline.harness.scene import Scene
from plumbline.harness.store.notices import StoredNotice, short_of
from plumbline.harness.store.record import Measurement, Record, Status
from plumbline.harness.store.trajectory_file import save_trajectory
from plumbline.harness.study.trial import Trial
from plumbline.harness.trajectory import Floats, Trajectory
from plumbline.harness.trajectory.pace import Pace
from plumbline.harness.trial.equivalent_runs import equivalent_run, equivalent_streams
from plumbline.harness.trial.paced import check_paced, paced
from plumbline.harness.trial.readings_due import readings_due
from plumbline.harness.trial.simulate import simulate
from plumbline.harness.trial.truth_cache import bounded, truth_of

_TOLD_OTHERWISE = {"experiment", "base", "settings", "alteration"}
_SHARED = {field.name for field in fields(Trial)} & {field.name for field in fields(Record)} - _TOLD_OTHERWISE


def outcome(trial: Trial, status: Status, reason: str, detail: str = "") -> Record:
    """The record of a trial that gave no trajectory."""
    return Record(
        **{name: getattr(trial, name) for name in _SHARED},
        experiment=trial.experiment.name,
        base=trial.base or trial.track,
        dt=trial.settings.dt,
        settings=trial.settings.plain(),
        alteration=trial.alteration.plain(),
        status=status,
        reason=reason,
        detail=detail,
    )


def cast_once(simulation: Simulation, rays: Rays) -> dict[str, Floats]:
    """Streams 'rays/range_ideal' and 'rays/body' of the rays of a case, cast at the start."""
    hits = simulation.cast(rays.origins, rays.directions, rays.max_range)
    bodies = hits.body[None].astype(np.float64)
    return {"rays/time": np.zeros(1), "rays/range_ideal": hits.distance[None], "rays/body": bodies}


class TruthBroken(NotMeasurable):
    """The truth of a case misses one of its own bounds, so that no engine can be judged by it; the text says which."""


def judge(case: Case, scene: Scene, actual: Trajectory, made: Converged | None) -> tuple[Measurement, ...]:
    """All checks and observations of a case on one trajectory.

    The bound of a distance [m] or speed [m/s] to the truth grows by the truth's own error.

    Raises: TruthBroken: an answer misses a bound that the truth misses as well.
    """
    expected = None if made is None else made.trajectory
    own = {} if made is None else {"m": made.position_error, "m/s": made.velocity_error}
    measurements = []
    for check in case.checks:
        judged, truth = check.judged(actual), None if expected is None else check.judged(expected)
        bound = check.bound(actual.dt, case.parameters)
        because = check.because if check.metric.better == "lower" else f"at least this: {check.because}"
        try:
            value = check.metric(scene, judged, truth)
            passed: bool | None = check.passes(value, actual.dt, case.parameters)
            off = _off(check.metric, own, scene, judged)
            if off > 0.0 and check.metric.better == "lower":
                bound += off
                passed = bool(np.isfinite(value)) and value <= bound
                because = f"{because}; and {off:.2g} {check.metric.unit} that the truth itself may be off"
            if (
                not passed
                and truth is not None
                and case.expected is not None
                and (reason := breaks(check, scene, replace(truth, dt=actual.dt), bound))
            ):
                raise TruthBroken(reason)
        except TruthBroken:
            raise
        except (NotMeasurable, MemoryError) as error:
            value, passed, because, off = math.nan, None, _blind(error), 0.0
        measurements.append(
            Measurement(
                metric=check.metric.name,
                value=value,
                unit=check.metric.unit,
                at_most=bound,
                passed=passed,
                because=because,
                truth_error=off,
            )
        )
    checked = {check.metric.name for check in case.checks}
    for metric in case.observe:
        if metric.name not in checked:
            try:
                value, because, off = metric(scene, actual, expected), "", _off(metric, own, scene, actual)
            except (NotMeasurable, MemoryError) as error:
                value, because, off = math.nan, _blind(error), 0.0
            measurements.append(
                Measurement(metric=metric.name, value=value, unit=metric.unit, because=because, truth_error=off)
            )
    return tuple(measurements)


def _blind(error: NotMeasurable | MemoryError) -> str:
    """Why a metric has no value. What it asks of the machine is no fault of the engine."""
    return f"not measurable: {error}" if isinstance(error, NotMeasurable) else f"not measured: out of memory: {error}"


def unjudged(record: Record, case: Case, reason: str) -> Record:
    """The record of an engine that answered, where the answer could not be judged: all its measurements say why."""
    checked = {check.metric.name: check.metric.unit for check in case.checks}
    units = checked | {metric.name: metric.unit for metric in case.observe}
    measurements = tuple(
        Measurement(metric=name, value=math.nan, unit=unit, because=f"not measured: {reason}") for name, unit in units.items()
    )
    return replace(record, status="unsupported", reason=f"not measured: {reason}", measurements=measurements)


def _off(metric: Metric, own: Mapping[str, float], scene: Scene, actual: Trajectory) -> float:
    """How far off the truth may be in what a metric measures; 0 where it needs no truth: without one it can be measured too."""
    if metric.unit not in own:
        return 0.0
    try:
        metric(scene, actual, None)
    except NotMeasurable:
        return own[metric.unit]
    return 0.0


def _missed(missed: Measurement, unit: str) -> str:
    """A value and the bound that it misses, in as many digits, four or more, as tell them apart."""
    digits = next((n for n in range(4, 17) if f"{missed.value:.{n}g}" != f"{missed.at_most:.{n}g}"), 17)
    return f"{missed.metric} = {missed.value:.{digits}g}{unit}, bound {missed.at_most:.{digits}g}"


def _verdict(measurements: tuple[Measurement, ...]) -> tuple[Status, str]:
    broken = [m for m in measurements if m.passed is False]
    if broken:
        units = {m.metric: "" if m.unit == "1" else f" {m.unit}" for m in broken}
        return "failed", "; ".join(_missed(m, units[m.metric]) for m in broken)
    if not any(m.passed for m in measurements):
        return "unsupported", "; ".join(m.because for m in measurements) or "no check could be measured"
    blind = [m.metric for m in measurements if m.at_most is not None and m.passed is None]
    return "passed", f"every check holds{'; not measurable: ' + ', '.join(blind) if blind else ''}"


@dataclass(frozen=True, slots=True)
class Answer:
    """What an engine made of a scene.

    Terms: broke: when and how it diverged, None where it did not. pace: of its steps. cpu [s]: that they took, once and from
    cold; 0 where nobody asks.
    """

    actual: Trajectory
    broke: str | None
    resolved: Mapping[str, Any]
    warnings: tuple[StoredNotice, ...]
    pace: Pace
    cpu: float = 0.0

    @property
    def steps(self) -> int:
        """Whole steps taken."""
        return self.pace.steps(float(self.actual.time[-1])) if len(self.actual) else 0

    @property
    def sim_seconds(self) -> float:
        """The time that these steps take [s]."""
        return self.pace.time(self.steps)

    def substep(self, asked: Settings) -> float:
        """The longest step taken [s]: as reported, else as requested."""
        return self.pace.longest / (self.resolved.get("substeps") or asked.substeps or 1)


class StepTime:
    """A simulation with the CPU time of all its steps so far; all else is the simulation's own.

    A whole run is clocked so, once and from cold: roughly, and for nothing.
    """

    def __init__(self, simulation: Any) -> None:
        self._simulation = simulation
        self.cpu = 0.0

    def step(self, count: int = 1) -> None:
        """Advance the simulation. Raises: Diverged."""
        begun = time.process_time()
        try:
            self._simulation.step(count)
        finally:
            self.cpu += time.process_time() - begun

    def __getattr__(self, name: str) -> Any:
        return getattr(self._simulation, name)


def answer_of(trial: Trial, case: Case, adapter: Adapter, scene: Scene) -> Answer:
    """Build and step: what the engine of a trial makes of a scene that belongs to the trial's case.

    Raises: Unsupported, Unavailable, SettingsError.
    """
    check_paced(adapter, trial.settings)
    pace = Pace.of(trial.settings.pace, trial.settings.dt)
    sample_interval = 0.0 if trial.alteration.every_step else case.sample_interval
    retelling = trial.alteration.retelling(scene, case.duration)
    if retelling is not None:
        return _equivalent(trial, retelling, adapter, case.duration, sample_interval)
    try:
        return _stepped(trial, case, adapter, scene, sample_interval, pace)
    except Diverged as error:
        return Answer(Trajectory.of(np.zeros(0), len(scene.bodies)), str(error), {}, (), pace)


def _stepped(trial: Trial, case: Case, adapter: Adapter, scene: Scene, sample_interval: float, pace: Pace) -> Answer:
    """Raises: Diverged, outside its steps; otherwise as `answer_of`."""
    worlds, batch = case.count_of_worlds(trial.parameters), None
    step_time: StepTime | None = None

    def clocked(stepped: Simulation) -> Simulation:
        nonlocal step_time
        if not trial.experiment.dominance:
            return stepped
        step_time = StepTime(stepped)
        return cast(Simulation, step_time)

    simulation: Simulation
    if worlds > 1:
        if not pace.even:
            raise Unsupported("many worlds under uneven steps", "a batch of worlds takes even steps")
        batch = adapter.build_batch(scene, trial.settings, worlds)
        simulation = cast(Simulation, Answering(clocked(cast(Simulation, WorldOf(batch, worlds - 1))), scene))
    else:
        simulation = paced(cast(Simulation, Answering(clocked(adapter.build(scene, trial.settings)), scene)), pace)
        control = acting(scene, None if case.control is None else case.control(case.parameters))
        if control is not None:
            simulation = cast(Simulation, Controlled(simulation, control, pace, len(scene.bodies)))
    try:
        readable = Feature.CONTACTS | Feature.CONTACT_FORCES in adapter.features
        with_contacts = case.with_contacts and readable and batch is None
        seen = {} if case.rays is None else cast_once(simulation, case.rays(case.parameters))
        actual, broke = simulate(
            simulation,
            scene,
            pace=pace,
            duration=case.duration,
            sample_interval=sample_interval,
            with_contacts=with_contacts,
            seed=trial.seed,
            with_impulses=with_contacts and any(metric.impulses for metric in case.metrics),
            pushed=case.control is not None,
        )
        if scene.sensors and case.truth == "agreed limit":
            seen |= readings_due(scene, actual)
        if case.worlds and broke is None:
            apart = 0.0 if batch is None else spread(batch, len(scene.bodies))
            seen |= {"worlds/time": actual.time[-1:], "worlds/spread": np.array([apart])}
        resolved, warnings = simulation.resolved.plain(), _stored(simulation.warnings())
        if not pace.even:
            resolved |= {"pace": trial.settings.pace, "longest_step": pace.longest}
    finally:
        simulation.close()
    if case.retellings is not None and broke is None and not trial.alteration.every_step:
        for retelling in case.retellings(case.parameters):
            other = replace(retelling, scene=trial.alteration.of(retelling.scene))
            streams, remarks = equivalent_streams(other, adapter, trial.settings, case.duration, case.sample_interval)
            seen, warnings = seen | streams, (*warnings, *map(StoredNotice, remarks))
    cpu = 0.0 if step_time is None else step_time.cpu
    return Answer(replace(actual, streams={**actual.streams, **seen}), broke, resolved, warnings, pace, cpu)


def _stored(warnings: tuple[str | Notice, ...]) -> tuple[StoredNotice, ...]:
    """What an engine or its adapter said, as records keep it."""
    return tuple(
        StoredNotice(notice.text, notice.kind, "" if notice.effect is None else ", ".join(notice.effect.names))
        for notice in as_notices(warnings)
    )


def _equivalent(trial: Trial, retelling: Retelling, adapter: Adapter, duration: float, sample_interval: float) -> Answer:
    try:
        actual, broke = equivalent_run(retelling, adapter, trial.settings, duration, sample_interval)
    except Diverged as error:
        actual, broke = Trajectory.of(np.zeros(0), len(retelling.scene.bodies)), str(error)
    return Answer(actual, broke, {}, (), Pace.of(trial.settings.pace, trial.settings.dt))


def refusal(trial: Trial, error: Unsupported | Unavailable | SettingsError) -> Record:
    """The record of a trial whose scene or settings the engine does not take."""
    if isinstance(error, Unsupported):
        return outcome(trial, "unsupported", str(error))
    if isinstance(error, Unavailable):
        return outcome(trial, "unavailable", str(error))
    return outcome(trial, "failed", f"settings refused: {error}")


def run_trial(
    trial: Trial,
    case: Case,
    adapter: Adapter,
    folder: Path | None,
    answered: Callable[[Record], object] | None = None,
) -> Record:
    """Build, step, measure: the record of one accuracy run; its trajectory is kept under `folder` if one is given.

    Args: answered: is told what is known once the engine has answered, before its answer is judged.
    """
    case = case.put(trial.parameters)
    scene = trial.scene(case)
    try:
        answer = answer_of(trial, case, adapter, scene)
    except (Unsupported, Unavailable, SettingsError) as error:
        return refusal(trial, error)
    actual, broke, warnings = answer.actual, answer.broke, answer.warnings
    plain = replace(
        outcome(trial, "interrupted" if broke is None else "diverged", broke or "the answer is not judged yet"),
        resolved=answer.resolved,
        substep=answer.substep(trial.settings),
        warnings=warnings,
        sim_seconds=answer.sim_seconds,
        steps=answer.steps,
    )
    if answered is not None:
        answered(plain)
    try:
        truth = truth_of(case, scene, actual.time, trial.parameters, folder, trial.sources)
    except (NotMeasurable, Unsupported, MemoryError) as error:
        truth, warnings = None, (*warnings, StoredNotice(f"no truth: {str(error) or 'out of memory'}"))
    expected = None if truth is None else truth.trajectory
    measurements: tuple[Measurement, ...] = ()
    if broke is None:
        bounded_case = bounded(
            case, answer.pace.longest, answer.substep(trial.settings), trial.parameters, folder, trial.sources
        )
        try:
            measurements = judge(bounded_case, scene, actual, truth)
        except TruthBroken as error:
            return unjudged(plain, case, str(error))
    status, reason = _verdict(measurements) if broke is None else ("diverged", broke)
    reason = reason if status == "passed" else short_of(warnings) + reason
    return replace(
        plain,
        status=status,
        reason=reason,
        warnings=warnings,
        measurements=measurements,
        trajectory_hash=None if folder is None else save_trajectory(folder, scene, actual, expected),
        rough_cost=answer.cpu / answer.sim_seconds if answer.cpu and answer.sim_seconds else None,
    )
