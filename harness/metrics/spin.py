"""Turns of free and of heavy tops.

Flips about the intermediate axis: how many there are, and how far apart, beside the truth.

A flip is a passage of the angular velocity's component along the body's middle principal axis through zero. The final
angle is no measure here: near the separatrix it is at the mercy of rounding.

Precession and nutation of a heavy top about the vertical, read off the axis of symmetry of the first movable body.

The axis is that of the largest or smallest principal moment, whichever stands apart from the other two.
"""

import numpy as np

from plumbline.harness.metric import NotMeasurable, Run, metric
from plumbline.harness.scene import Scene
from plumbline.harness.trajectory import Floats, Trajectory
from plumbline.harness.trajectory.kinematics import movable, rotate, rotate_back

SOURCE = "definition: instants at which the component of w along the middle principal axis passes zero"
VERDICT = "the spin's component along the middle axis changes its sign"


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


@metric("1", SOURCE, verdict=VERDICT)
def flip_count_error(run: Run) -> float:
    return float(abs(len(_flips(run.scene, run.actual)) - len(_flips(run.scene, run.truth))))


@metric("1", SOURCE, verdict=VERDICT)
def flip_period_error(run: Run) -> float:
    """mean distance over the truth's"""
    truth = _flips(run.scene, run.truth)
    if len(truth) < 2:
        raise NotMeasurable(f"the truth flips {len(truth)} times, a period needs 2")
    answer = _flips(run.scene, run.actual)
    if len(answer) < 2:
        return float("inf")
    return float(abs((answer[-1] - answer[0]) / (len(answer) - 1) * (len(truth) - 1) / (truth[-1] - truth[0]) - 1))


PRECESSION_SOURCE = "definition: azimuth and polar angle of the axis of symmetry against the vertical"


def _axis(scene: Scene, trajectory: Trajectory) -> Floats:
    """The axis of symmetry in W, (t, 3)."""
    bodies = movable(scene)
    if len(bodies) == 0 or len(trajectory) < 2:
        raise NotMeasurable("precession needs a body that moves and at least 2 samples")
    moments, axes = np.linalg.eigh(np.array(scene.bodies[bodies[0]].inertia))
    column = 2 if moments[1] - moments[0] <= moments[2] - moments[1] else 0
    if not np.isclose(moments[1], moments[2 - column], rtol=1e-9):
        raise NotMeasurable("no two principal moments are equal: the body has no axis of symmetry")
    return rotate(trajectory.q_WB[:, bodies[0]], np.broadcast_to(axes[:, column], (len(trajectory), 3)))


def _rate(scene: Scene, trajectory: Trajectory) -> float:
    """Mean rate [rad/s] of the azimuth, from the slope of a straight line through it."""
    axis = _axis(scene, trajectory)
    azimuth = np.unwrap(np.arctan2(axis[:, 1], axis[:, 0]))
    return float(np.polynomial.Polynomial.fit(trajectory.time, azimuth, 1).deriv()(0.0))


@metric("1", PRECESSION_SOURCE)
def precession_rate_error(run: Run) -> float:
    """slope over time"""
    truth = _rate(run.scene, run.truth)
    if truth == 0.0:
        raise NotMeasurable("the truth does not precess")
    return abs(_rate(run.scene, run.actual) / truth - 1)


@metric("rad", PRECESSION_SOURCE)
def nutation_amplitude(run: Run) -> float:
    """beside the truth's"""
    # Largest departure [rad] of the polar angle from the truth's.
    truth = _axis(run.scene, run.truth)
    polar = [np.arctan2(np.hypot(axis[:, 0], axis[:, 1]), axis[:, 2]) for axis in (_axis(run.scene, run.actual), truth)]
    return float(np.max(np.abs(polar[0] - polar[1])))
