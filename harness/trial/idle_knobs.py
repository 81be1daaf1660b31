"""Which turns of a knob change nothing in a scene: the engine would use the very settings that it uses anyway.

A track that chooses by the scene, and a bound that cuts what a knob says, leave some values of some knobs without effect here
and now. `Simulation.resolved` says what really acts, so building the scene under both settings is enough to know.
"""

from contextlib import suppress
from typing import Any

from plumbline.harness.adapter import Adapter, Settings
from plumbline.harness.case import Case
from plumbline.harness.scene import Scene
from plumbline.harness.store.record import Record
from plumbline.harness.study.one_knob import turned, turns
from plumbline.harness.study.trial import Trial


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
