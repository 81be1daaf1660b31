"""Retellings: how far the same scene, told another way and told back, parts from the case's own run.

Its motion stands in the streams '<name>/...'. Equal bits are a difference of zero; a run that ended early is never close.

World spread: do equal worlds that are stepped together have the same future?
"""

from collections.abc import Callable
from functools import partial
from typing import Literal

import numpy as np

from plumbline.harness.metric import Metric, NotMeasurable, Run, metric
from plumbline.harness.trajectory import Floats, State, Trajectory
from plumbline.harness.trajectory.kinematics import angle_between

NAMES = ("repeated", "restored", "reordered", "moved", "turned", "in_motion", "shrunk", "grown")


def _both(actual: Trajectory, name: str) -> tuple[State, State]:
    """The states (k, n, ...) of the case's run and of its retelling at the times that the latter has."""
    if f"{name}/time" not in actual.streams:
        raise NotMeasurable(f"there is no motion '{name}' to compare with")
    time = actual.streams[f"{name}/time"]
    if len(time) == 0 or len(actual) == 0:
        raise NotMeasurable("no sample lies in the time that is judged")
    first = int(np.searchsorted(actual.time, time[0] - 1e-9))
    count = min(len(time), len(actual) - first)
    if not np.allclose(actual.time[first : first + count], time[:count], rtol=0.0, atol=1e-9):
        raise NotMeasurable(f"the motion '{name}' stands at other times")
    here = (getattr(actual, field)[first : first + count] for field in ("p_WB", "q_WB", "v_WB", "w_WB"))
    there = (actual.streams[f"{name}/{field}"][:count] for field in ("p_WB", "q_WB", "v_WB", "w_WB"))
    return State(*here), State(*there)


def _numbers(state: State) -> Floats:
    """All numbers of a state side by side, (k, m)."""
    return np.concatenate([array.reshape(len(array), -1) for array in (state.p_WB, state.q_WB, state.v_WB, state.w_WB)], axis=1)


def _difference(name: str, run: Run) -> Floats:
    here, there = _both(run.actual, name)
    return np.abs(_numbers(here) - _numbers(there))


def _position(name: str, run: Run) -> Floats:
    here, there = _both(run.actual, name)
    distance: Floats = np.linalg.norm(here.p_WB[:, run.movable] - there.p_WB[:, run.movable], axis=-1)
    return distance


def _attitude(name: str, run: Run) -> Floats:
    here, there = _both(run.actual, name)
    return angle_between(here.q_WB[:, run.movable], there.q_WB[:, run.movable])


def _agreeing(name: str, run: Run) -> float:
    here, there = _both(run.actual, name)
    if not (here.finite and there.finite):
        return float("nan")
    differs = (_numbers(here).view(np.int64) != _numbers(there).view(np.int64)).any(axis=1)
    return float(np.argmax(differs)) if differs.any() else float(len(differs))


def _of_each(
    kind: str,
    unit: str,
    source: str,
    measure: Callable[[str, Run], float | Floats],
    better: Literal["lower", "higher"] = "lower",
) -> dict[str, Metric]:
    """The metric '<name>_<kind>' for each retelling."""
    return {
        name: Metric(name=f"{name}_{kind}", unit=unit, source=source, measure=partial(measure, name), better=better)
        for name in NAMES
    }


DIFFERENCE = _of_each("difference", "1", "definition: largest difference of any number of any state, in SI units", _difference)
POSITION_DIFFERENCE = _of_each(
    "position_difference", "m", "definition: largest distance of a body from itself, retold", _position
)
ATTITUDE_DIFFERENCE = _of_each("attitude_difference", "rad", "definition: largest angle of a body to itself, retold", _attitude)
AGREEING_SAMPLES = _of_each(
    "agreeing_samples", "1", "definition: samples before the first that differs in a bit", _agreeing, "higher"
)


@metric("1")
def world_spread(run: Run) -> float:
    """definition: largest difference of any number of a world's state at the end from the first world's, in SI units"""
    if "worlds/spread" not in run.actual.streams:
        raise NotMeasurable("the worlds were not compared")
    return float(np.max(run.actual.streams["worlds/spread"], initial=0.0))
