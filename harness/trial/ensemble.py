"""How many of an ensemble of starts an engine carries to the end without breaking, and by what the others break.

An axis breaks by its case's own question:

* where the axis says how far the headline may go, a headline beyond that, and beyond what the case itself grants at that step;
* where the scene should stand, a sign of a collapse (`harness.metrics.collapse`): 'energy', 'penetration', 'height', 'drive';
* where neither is so, a check of the case that does not hold: of its own start, which bounds are derived for;

and by a run that diverges or is not finite ('finite'). So where a start passes the case's checks, it holds; the converse is not
asked, since checks hold an engine to what a step allows, and a limit is where its answer is lost.

The signs of a collapse that show in scenes which are not meant to stand break nothing. They are recorded beside, as 'sign_...'.
"""

from collections import Counter
from contextlib import suppress
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from plumbline.harness.adapter import Adapter, Diverged, SettingsError, Unavailable, Unsupported
from plumbline.harness.case import Case
from plumbline.harness.case.starts import Member, member
from plumbline.harness.metric import NotMeasurable
from plumbline.harness.metric.series import START
from plumbline.harness.metrics.collapse import SIGNS, collapse_time, first_break
from plumbline.harness.metrics.stack import standing_height
from plumbline.harness.scene import Scene
from plumbline.harness.store.arrays import save_trajectory
from plumbline.harness.store.record import Measurement, Record, short_of
from plumbline.harness.study.trial import Trial
from plumbline.harness.trajectory import Trajectory
from plumbline.harness.trial.accuracy import judge, outcome, refusal
from plumbline.harness.trial.answer import RunAnswer, answer_of
from plumbline.harness.trial.bench import Bench, rough_cost
from plumbline.harness.trial.truth_cache import bounded, truth_of

HELD, STARTS = "held_share", "starts"
"""The share of the starts that held, and how many there were: one, of a scene that cannot start otherwise."""
BROKE_BY, SIGN = "broke_", "sign_"
"""Before a name: the share of the starts that broke by it, and that of those which showed it beside their question."""
HEADLINE = "headline_worst"
"""The largest headline error of the starts, with the bar beyond which it is lost; of an axis that says how far it may go."""
OWN_CHECKS = "own_checks_hold"
"""Do the checks of the case hold at its own start? 1 or 0."""


@dataclass(frozen=True, slots=True)
class Fate:
    """What became of a member.

    Terms: by: the metric, sign or 'finite' by which it broke, '' where it held. time [s]: when. beside: a sign that shows in a
    scene which is not meant to stand, '' for none. scene, answer: what ran. checked: do the checks of the case hold? error: of
    the headline, and the bar beyond which it is lost; None where no axis is about it.
    """

    by: str
    time: float
    beside: str
    scene: Scene
    answer: RunAnswer
    checked: bool
    error: "_Error | None" = None


@dataclass(frozen=True, slots=True)
class _Error:
    """The headline against its bar. Terms: value: absolute where lower is better. lost: is it beyond the bar, or not finite?"""

    value: float
    bar: float
    unit: str
    lost: bool
    lower_is_better: bool


def _stands(case: Case) -> bool:
    """Is the scene one that should stand?"""
    return any(check.metric in (standing_height, collapse_time) for check in case.checks)


def _fate(trial: Trial, case: Case, adapter: Adapter, number: int, folder: Path | None) -> Fate:
    """Raises: NotMeasurable, Unsupported, Unavailable, SettingsError."""
    seeded = {"seed": number} if "seed" in trial.parameters else {}
    plain = replace(trial, parameters={**trial.parameters, **seeded}, seed=number)
    case = case.put(plain.parameters)
    scene = plain.scene(case)
    start = member(scene, number, trial.settings.dt, turn=not scene.sensors) if _varies(case) else Member(scene, None)
    answer = answer_of(plain, case.problem(start.scene), adapter)
    actual = answer.actual
    end = float(actual.time[-1]) if len(actual) else 0.0
    if answer.broke is not None or not actual.finite:
        return Fate("finite", end, "", start.scene, answer, False)
    # Height means nothing in a scene that may fall.
    shown, sign = first_break(start.scene, actual, SIGNS if _stands(case) else [sign for sign in SIGNS if sign != "height"])
    taken_back = start.back(actual)
    truth = truth_of(case, scene, actual.time, plain.parameters, folder, trial.sources)
    asked = bounded(case, answer.pace.longest, answer.substep(trial.settings), plain.parameters, folder, trial.sources)
    measured = judge(asked, scene, taken_back, truth) if number == 0 or not (_stands(case) or _limited(case)) else ()
    failed = [measurement.metric for measurement in measured if measurement.passed is False]
    by, time = "", end
    error = _error(asked, scene, taken_back, None if truth is None else truth.trajectory) if _limited(case) else None
    if error is not None and error.lost:
        by = case.headline
    elif _stands(case):
        by, time = sign, shown
    elif not _limited(case) and failed:
        by = failed[0]
    return Fate(by, time, "" if _stands(case) else sign, start.scene, answer, bool(measured) and not failed, error)


def _limited(case: Case) -> bool:
    """Does the axis say how far the headline may go?"""
    return case.hard is not None and case.hard.lost is not None


def _varies(case: Case) -> bool:
    """May the scene start otherwise? What acts on it from outside, what it is told again as, and bounds would not follow."""
    return case.retellings is None and case.control is None and case.rays is None and (_limited(case) or _stands(case))


def _told_once(case: Case) -> Case:
    """The case without the other starts that it tells of itself, where it has members, which are starts of their own."""
    alone = replace(case, retellings=None)
    if case.retellings is None or not _varies(alone):
        return case
    return alone if all(other.name.startswith(START) for other in case.retellings(case.parameters)) else case


def _error(case: Case, scene: Scene, actual: Trajectory, truth: Trajectory | None) -> _Error:
    """The headline against the larger of what the axis allows and the case grants at this step. Raises: NotMeasurable."""
    assert case.hard is not None
    assert case.hard.lost is not None
    metric = next(metric for metric in case.metrics if metric.name == case.headline)
    granted = (check for check in case.checks if check.metric is metric and check.start == 0 and check.end is None)
    value = metric(scene, actual, truth)
    bounds = [case.hard.lost * case.scale, *(check.bound(actual.dt, case.parameters) for check in granted)]
    higher = metric.better == "higher"
    value, bar = (value, min(bounds)) if higher else (abs(value), max(bounds))
    within = np.isfinite(value) and (value >= bar if higher else value <= bar)
    return _Error(float(value), float(bar), metric.unit, not within, not higher)


def endure(trial: Trial, case: Case, adapter: Adapter, folder: Path | None) -> Record:
    """The record of an ensemble: passed where all members hold. The trajectory kept is that of the first that broke."""
    fates: list[Fate] = []
    case = _told_once(case)
    try:
        for number in range(trial.members if _varies(case) or "seed" in trial.parameters else 1):
            fates.append(_fate(trial, case, adapter, number, folder))
    except (Unsupported, Unavailable, SettingsError) as error:
        return refusal(trial, error)
    except NotMeasurable as error:
        return outcome(trial, "unsupported", f"the case's own question cannot be measured: {error}")
    broken = [fate for fate in fates if fate.by]
    counts = Counter(fate.by for fate in broken)
    beside = Counter(fate.beside for fate in fates if fate.beside)
    shown = min(broken, key=lambda fate: fate.time, default=fates[0])
    reason = f"{len(broken)} of {len(fates)} broke: {_listed(counts)}" if broken else f"all {len(fates)} held"
    reason = short_of(shown.answer.warnings) + reason if broken else reason
    if beside:
        reason += f"; beside the question, in a scene not meant to stand: {_listed(beside)}"
    made = [Measurement(metric=HELD, value=1 - len(broken) / len(fates), unit="1", at_most=1.0, passed=not broken)]
    for before, counted in ((BROKE_BY, counts), (SIGN, beside)):
        made += [Measurement(metric=before + name, value=count / len(fates), unit="1") for name, count in counted.items()]
    errors = [fate.error for fate in fates if fate.error is not None and fate.error.lower_is_better]
    if len(errors) == len(fates):
        worst = max(errors, key=lambda error: error.value)
        made.append(Measurement(metric=HEADLINE, value=worst.value, unit=worst.unit, at_most=worst.bar, passed=not worst.lost))
    made.append(Measurement(metric=OWN_CHECKS, value=float(fates[0].checked), unit="1"))
    made.append(Measurement(metric=STARTS, value=float(len(fates)), unit="1"))
    if broken:
        made.append(Measurement(metric="first_break_time", value=shown.time, unit="s"))
    return replace(
        outcome(trial, "failed" if broken else "passed", reason),
        resolved=shown.answer.resolved,
        substep=shown.answer.substep(trial.settings),
        warnings=shown.answer.warnings,
        measurements=tuple(made),
        sim_seconds=shown.answer.sim_seconds,
        steps=shown.answer.steps,
        trajectory_hash=None if folder is None else save_trajectory(folder, shown.scene, shown.answer.actual, None),
        rough_cost=None if broken and not _compared(trial) else _cost(trial, case, adapter),
    )


def _listed(counts: Counter[str]) -> str:
    return ", ".join(f"{name} {count}" for name, count in counts.most_common())


def _compared(trial: Trial) -> bool:
    """Is the cost of what broke to be compared with that of a remedy?"""
    limit = trial.experiment.limit
    return limit is not None and trial.track in limit.remedies


def _cost(trial: Trial, case: Case, adapter: Adapter) -> float | None:
    """CPU seconds per simulated second, roughly; None where nothing but a diverging run could be clocked."""
    with suppress(Diverged):
        return rough_cost(Bench(case, adapter, trial))
    return None
