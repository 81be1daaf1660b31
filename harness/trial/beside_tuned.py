"""What settings cost over what the track 'tuned' costs, roughly: whole runs of both in turns, beside an accuracy run.

A single run is clocked from cold, beside whatever else the machine does; of short ones that says little, and a few more are
cheap. Where a run is long it says enough, and more would be dear.

Which turns of a knob change nothing in a scene: the engine would use the very settings that it uses anyway.

A track that chooses by the scene, and a bound that cuts what a knob says, leave some values of some knobs without effect here
and now. `Simulation.resolved` says what really acts, so building the scene under both settings is enough to know.
"""

import time
from contextlib import suppress
from statistics import median
from typing import Any

from plumbline.harness.adapter import Adapter, Settings
from plumbline.harness.case import Case
from plumbline.harness.scene import Scene
from plumbline.harness.store.record import Record
from plumbline.harness.study.one_knob import turned, turns
from plumbline.harness.study.trial import Trial
from plumbline.harness.trial.bench import Bench, rough_cost_beside

SHORT = 0.05
"""Of steps [s]: a run that takes no longer is repeated."""
TURNS = 3
AT_MOST = 0.5
"""After so much CPU time [s] no further turn begins."""


def ratio_to_tuned(trial: Trial, case: Case, adapter: Adapter) -> float:
    """The CPU time of whole runs over that of 'tuned' at the same time step and parameters: the median of a few turns.

    Where rays are what costs, of casts. Raises: whatever a build or a step does.
    """
    tuned = adapter.tracks["tuned"].with_dt(trial.settings.dt)
    own, beside = (
        Bench(case, adapter, side, settled=False)
        for side in (trial, trial.probing(case, track="tuned", base="", settings=tuned))
    )
    if own.unit == "ray":
        return rough_cost_beside(own, beside)[1]
    ratios, until = list[float](), time.process_time() + AT_MOST
    try:
        while len(ratios) < TURNS and (not ratios or time.process_time() < until):
            ratios.append(_whole(own) / _whole(beside))
    finally:
        own.stop()
        beside.stop()
    return median(ratios)


def _whole(bench: Bench) -> float:
    bench.start()
    return bench.clock(bench.whole)[0]


def is_surveyed(trial: Trial, record: Record) -> bool:
    """Will knobs be turned from the settings of this trial, so that those that are idle here have to be known?"""
    experiment = trial.experiment
    if experiment.limit is not None and trial.track in experiment.limit.remedies:
        return not trial.remedied and record.status in ("failed", "diverged")
    swept = experiment.sweep and trial.round == 0
    return bool(record.resolved) and bool(swept or (experiment.dominance and trial.round == 0))


def idle_turns(trial: Trial, case: Case, adapter: Adapter) -> tuple[tuple[str, Any], ...]:
    """The turns of one knob, each a knob and a value, after which the engine resolves the settings of a trial as before."""
    scene, found = trial.scene(case), []
    own = None
    with suppress(Exception):  # what a build raises is for the run of these settings to say
        own = _resolved(adapter, scene, trial.settings)
    for turn in turns(trial.settings, adapter.knobs_in(scene), adapter.knobs) if own is not None else ():
        with suppress(Exception):
            if _resolved(adapter, scene, turned(trial.settings, turn.knob, turn.value)) == own:
                found.append((turn.knob, turn.value))
    return tuple(found)


def _resolved(adapter: Adapter, scene: Scene, settings: Settings) -> dict[str, Any]:
    """What acts, without who recommends it. Raises: whatever a build does."""
    simulation = adapter.build(scene, settings)
    try:
        plain = simulation.resolved.plain()
    finally:
        simulation.close()
    plain.pop("source", None)
    return plain
