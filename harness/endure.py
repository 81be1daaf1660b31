"""How many of an ensemble of starts an engine carries to the end without breaking, and by what sign the others break.

Broken are, each by its name: a run that diverges or is not finite ('finite'), kinetic energy beyond a thousand times what is
available ('energy'), a contact deeper than half of the thinnest body ('penetration'), in cases that check it a top below half
its height ('height'), a drive half a radian off its target ('drive'), and, where the case says how far its headline
may go, one that is beyond ('error').
"""

from collections import Counter
from contextlib import suppress
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from harness.adapter import Adapter, Diverged, SettingsError, Unavailable, Unsupported
from harness.bench import Bench, rough_cost
from harness.case import Case
from harness.members import Member, member
from harness.metric import NotMeasurable
from harness.metrics.collapse import COLLAPSE_TIME, SIGNS, first_break
from harness.metrics.stack import STANDING_HEIGHT
from harness.record import Measurement, Record
from harness.run import Answer, answer_of, outcome, refusal
from harness.scene import Scene
from harness.study import Trial
from harness.trajectory import Trajectory
from harness.trajectory_file import save_trajectory
from harness.truth_keeper import truth_of

__all__ = ["HELD", "STARTS", "endure"]

HELD, STARTS = "held_share", "starts"
"""The share of the starts that held, and how many there were: one, of a scene that cannot start otherwise."""


@dataclass(frozen=True, slots=True)
class Fate:
    """What became of a member. Terms: sign: by which it broke, '' where it held. time [s]: when. scene, answer: what ran."""

    sign: str
    time: float
    scene: Scene
    answer: Answer


def _fate(trial: Trial, case: Case, adapter: Adapter, number: int, folder: Path | None) -> Fate:
    plain = replace(trial, parameters=_seeded(trial, number), seed=number)
    scene = plain.scene(case)
    start = member(scene, number, trial.settings.dt, turn=not scene.sensors) if _varies(case) else Member(scene, None)
    answer = answer_of(plain, case, adapter, start.scene)
    actual = answer.actual
    if answer.broke is not None or not actual.finite:
        return Fate("finite", float(actual.time[-1]) if len(actual) else 0.0, start.scene, answer)
    stands = any(check.metric in (STANDING_HEIGHT, COLLAPSE_TIME) for check in case.checks)
    signs = [sign for sign in SIGNS if sign != "height" or stands]
    time, sign = first_break(start.scene, actual, signs)
    if not sign and _lost(plain, case, scene, start.back(actual), folder):
        sign = "error"
    return Fate(sign, time, start.scene, answer)


def _varies(case: Case) -> bool:
    """May the scene start otherwise? What acts on it from outside, and what it is told again as, would not follow."""
    return case.retellings is None and case.control is None and case.rays is None


def _seeded(trial: Trial, number: int) -> dict[str, object]:
    return {name: number if name == "seed" else value for name, value in trial.parameters.items()}


def _lost(trial: Trial, case: Case, scene: Scene, actual: Trajectory, folder: Path | None) -> bool:
    """Is the headline beyond what the case's axis allows? What cannot be measured is not."""
    if case.hard is None or case.hard.lost is None:
        return False
    metric, bound = next(metric for metric in case.metrics if metric.name == case.headline), case.hard.lost * case.scale
    try:
        truth = truth_of(case, scene, actual.time, trial.parameters, folder)
        value = metric(scene, actual, None if truth is None else truth.trajectory)
    except (NotMeasurable, Unsupported):
        return False
    within = value >= bound if metric.better == "higher" else abs(value) <= bound
    return not (np.isfinite(value) and within)


def endure(trial: Trial, case: Case, adapter: Adapter, folder: Path | None) -> Record:
    """The record of an ensemble: passed where all members hold. The trajectory kept is that of the first that broke."""
    fates: list[Fate] = []
    try:
        for number in range(trial.members if _varies(case) or "seed" in trial.parameters else 1):
            fates.append(_fate(trial, case, adapter, number, folder))
    except (Unsupported, Unavailable, SettingsError) as error:
        return refusal(trial, error)
    broken = [fate for fate in fates if fate.sign]
    counts = Counter(fate.sign for fate in broken)
    shown = min(broken, key=lambda fate: fate.time, default=fates[0])
    said = ", ".join(f"{sign} {count}" for sign, count in counts.most_common())
    reason = f"{len(broken)} of {len(fates)} broke: {said}" if broken else f"all {len(fates)} held"
    made = [Measurement(metric=HELD, value=1 - len(broken) / len(fates), unit="1", at_most=1.0, passed=not broken)]
    made += [Measurement(metric=f"broke_{sign}", value=count / len(fates), unit="1") for sign, count in counts.items()]
    made.append(Measurement(metric=STARTS, value=float(len(fates)), unit="1"))
    if broken:
        made.append(Measurement(metric="first_break_time", value=shown.time, unit="s"))
    return replace(
        outcome(trial, "failed" if broken else "passed", reason),
        resolved=shown.answer.resolved,
        warnings=shown.answer.warnings,
        measurements=tuple(made),
        sim_seconds=shown.answer.steps * trial.settings.dt,
        steps=shown.answer.steps,
        trajectory_hash=None if folder is None else save_trajectory(folder, shown.scene, shown.answer.actual, None),
        rough_cost=None if broken and not _compared(trial) else _cost(trial, case, adapter),
    )


def _compared(trial: Trial) -> bool:
    """Is the cost of what broke to be compared with that of a remedy?"""
    limit = trial.experiment.limit
    return limit is not None and trial.track in limit.remedies


def _cost(trial: Trial, case: Case, adapter: Adapter) -> float | None:
    """CPU seconds per simulated second, roughly; None where nothing but a diverging run could be clocked."""
    with suppress(Diverged):
        return rough_cost(Bench(case, adapter, trial))
    return None
