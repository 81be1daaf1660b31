"""The accuracy run: one trial in this process, from scene to record; nothing is clocked here.

An answer is judged as it is kept, array by array: judged anew from its file, it gives the same record, bit for bit.
"""

import math
from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path

import numpy as np

from plumbline.harness.adapter import Adapter, SettingsError, Unavailable, Unsupported
from plumbline.harness.case import Case, Converged
from plumbline.harness.case.own_truth import breaks
from plumbline.harness.metric import Metric, NotMeasurable
from plumbline.harness.scene import Scene
from plumbline.harness.store.arrays import as_kept, read_trajectory, save_trajectory
from plumbline.harness.store.record import Answer, Measurement, Record, Status, StoredNotice, short_of
from plumbline.harness.study.trial import Trial
from plumbline.harness.trajectory import Trajectory
from plumbline.harness.trajectory.pace import Pace
from plumbline.harness.trial.answer import RunAnswer, answer_of
from plumbline.harness.trial.truth_cache import bounded, truth_of


def outcome(trial: Trial, status: Status, reason: str, detail: str = "") -> Record:
    """The record of a trial that gave no trajectory."""
    return trial.record(Answer(status=status, reason=reason, detail=detail))


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
    problem = trial.problem(case)
    try:
        answer = answer_of(trial, problem, adapter)
    except (Unsupported, Unavailable, SettingsError) as error:
        return refusal(trial, error)
    record = _judged(trial, case, problem.scene, answer, folder, answered)
    return replace(record, rough_cost=answer.cpu / answer.sim_seconds if answer.cpu and answer.sim_seconds else None)


def judged_anew(
    trial: Trial, case: Case, earlier: Record, folder: Path, answered: Callable[[Record], object] | None = None
) -> Record | None:
    """The record of a trial whose answer an earlier run kept: judged, not simulated; what was clocked of it stays.

    Args: earlier: its record then, of the same `motion`. Returns: None where the file of its trajectory is gone, damaged,
    or not the answer to the trial's own scene.
    """
    case = case.put(trial.parameters)
    scene, pace = trial.scene(case), Pace.of(trial.settings.pace, trial.settings.dt)
    actual = None if earlier.trajectory_hash is None else read_trajectory(folder, earlier.trajectory_hash, scene)
    if actual is None:
        return None
    notices = tuple(notice for notice in earlier.warnings if notice.by == "engine")
    answer = RunAnswer(replace(actual, even=pace.even), earlier.broke, earlier.resolved, notices, pace, memory=earlier.memory)
    record = _judged(trial, case, scene, answer, folder, answered)
    clocked = (notice for notice in earlier.warnings if notice.by == "rough clock")
    return replace(
        record,
        warnings=(*record.warnings, *clocked),
        rough_cost=earlier.rough_cost,
        rough_ratio=earlier.rough_ratio,
        idle=earlier.idle,
    )


def _judged(
    trial: Trial,
    case: Case,
    scene: Scene,
    answer: RunAnswer,
    folder: Path | None,
    answered: Callable[[Record], object] | None = None,
) -> Record:
    """The record of an answer; its trajectory is kept under `folder`, unless no engine can be judged by the truth."""
    actual, broke, warnings = as_kept(answer.actual), answer.broke, answer.warnings
    plain = replace(
        outcome(trial, "interrupted" if broke is None else "diverged", broke or "the answer is not judged yet"),
        broke=broke,
        resolved=answer.resolved,
        substep=answer.substep(trial.settings),
        warnings=warnings,
        sim_seconds=answer.sim_seconds,
        steps=answer.steps,
        memory=answer.memory,
    )
    if answered is not None:
        answered(plain)
    try:
        truth = truth_of(case, scene, actual.time, trial.parameters, folder, trial.sources)
    except (NotMeasurable, Unsupported, MemoryError) as error:
        truth, warnings = None, (*warnings, StoredNotice(f"no truth: {str(error) or 'out of memory'}", by="judge"))
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
    )
