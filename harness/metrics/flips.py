"""Flips about the intermediate axis: how many there are, and how far apart, beside the truth.

A flip is a passage of the angular velocity's component along the body's middle principal axis through zero. The final
angle is no measure here: near the separatrix it is at the mercy of rounding.
"""

import numpy as np

from harness.metric import Metric, NotMeasurable
from harness.metric.series import matched
from harness.scene import Scene
from harness.trajectory import Floats, Trajectory
from harness.trajectory.kinematics import movable, rotate_back

SOURCE = "definition: instants at which the component of w along the middle principal axis passes zero"


def _flips(scene: Scene, trajectory: Trajectory) -> Floats:
    """The instants [s] of the flips of the first movable body, by inverse linear interpolation."""
    bodies = movable(scene)
    if len(bodies) == 0:
        raise NotMeasurable("no body can move")
    moments, axes = np.linalg.eigh(np.array(scene.bodies[bodies[0]].inertia))
    if not moments[0] < moments[1] < moments[2]:
        raise NotMeasurable("two principal moments are equal: there is no middle axis")
    along = rotate_back(trajectory.q_WB[:, bodies[0]], trajectory.w_WB[:, bodies[0]]) @ axes[:, 1]
    # A sample at zero belongs to neither side.
    aside = np.flatnonzero(along)
    turns = np.flatnonzero(np.sign(along[aside[:-1]]) * np.sign(along[aside[1:]]) < 0)
    before, after = aside[turns], aside[turns + 1]
    share = along[before] / (along[before] - along[after])
    instants: Floats = trajectory.time[before] + share * (trajectory.time[after] - trajectory.time[before])
    return instants


def _count(scene: Scene, actual: Trajectory, expected: Trajectory | None) -> float:
    truth = matched(actual, expected)
    if not actual.finite:
        return float("nan")
    return float(abs(len(_flips(scene, actual)) - len(_flips(scene, truth))))


def _period(scene: Scene, actual: Trajectory, expected: Trajectory | None) -> float:
    truth = _flips(scene, matched(actual, expected))
    if not actual.finite:
        return float("nan")
    if len(truth) < 2:
        raise NotMeasurable(f"the truth flips {len(truth)} times, a period needs 2")
    answer = _flips(scene, actual)
    if len(answer) < 2:
        return float("inf")
    return float(abs((answer[-1] - answer[0]) / (len(answer) - 1) * (len(truth) - 1) / (truth[-1] - truth[0]) - 1))


VERDICT = "the spin's component along the middle axis changes its sign"
FLIP_COUNT_ERROR = Metric(name="flip_count_error", unit="1", source=SOURCE, measure=_count, verdict=VERDICT)
FLIP_PERIOD_ERROR = Metric(
    name="flip_period_error", unit="1", source=f"{SOURCE}; mean distance over the truth's", measure=_period, verdict=VERDICT
)

METRIC = (FLIP_COUNT_ERROR, FLIP_PERIOD_ERROR)
