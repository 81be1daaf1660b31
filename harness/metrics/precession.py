"""Precession and nutation of a heavy top about the vertical, read off the axis of symmetry of the first movable body.

The axis is that of the largest or smallest principal moment, whichever stands apart from the other two.
"""

import numpy as np

from plumbline.harness.metric import NotMeasurable, Run, metric
from plumbline.harness.scene import Scene
from plumbline.harness.trajectory import Floats, Trajectory
from plumbline.harness.trajectory.kinematics import movable, rotate

SOURCE = "definition: azimuth and polar angle of the axis of symmetry against the vertical"


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


@metric("1", SOURCE)
def precession_rate_error(run: Run) -> float:
    """slope over time"""
    truth = _rate(run.scene, run.truth)
    if truth == 0.0:
        raise NotMeasurable("the truth does not precess")
    return abs(_rate(run.scene, run.actual) / truth - 1)


@metric("rad", SOURCE)
def nutation_amplitude(run: Run) -> float:
    """beside the truth's"""
    # Largest departure [rad] of the polar angle from the truth's.
    truth = _axis(run.scene, run.truth)
    polar = [np.arctan2(np.hypot(axis[:, 0], axis[:, 1]), axis[:, 2]) for axis in (_axis(run.scene, run.actual), truth)]
    return float(np.max(np.abs(polar[0] - polar[1])))
