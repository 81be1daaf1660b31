"""Errors against the truth, over the bodies that a force moves.

Position error: distance between the centres of mass of answer and truth, over the bodies that a force moves.

Velocity error: distance between the velocities of the centres of mass of answer and truth, in W.

Attitude error: angle of the rotation between answer and truth, the geodesic distance on SO(3).

Angular velocity error: distance between the angular velocities of answer and truth, in W.

Radius error: how far bodies leave their distance from the vertical through the origin, as a share of the truth's.
"""

import numpy as np

from plumbline.harness.metric import NotMeasurable, Run
from plumbline.harness.metric.series import three
from plumbline.harness.trajectory import Floats
from plumbline.harness.trajectory.kinematics import angle_between


def _distance(run: Run) -> Floats:
    truth, bodies = run.truth, run.movable
    distance: Floats = np.linalg.norm(run.actual.p_WB[:, bodies] - truth.p_WB[:, bodies], axis=-1)
    return distance


position_error_max, position_error_rms, position_error_final = three(
    "position_error", "m", "definition: |p_WB - p_WB of the truth|", _distance
)


def _difference(run: Run) -> Floats:
    truth, bodies = run.truth, run.movable
    difference: Floats = np.linalg.norm(run.actual.v_WB[:, bodies] - truth.v_WB[:, bodies], axis=-1)
    return difference


velocity_error_max, velocity_error_rms, velocity_error_final = three(
    "velocity_error", "m/s", "definition: |v_WB - v_WB of the truth|", _difference
)


def _angle(run: Run) -> Floats:
    truth, bodies = run.truth, run.movable
    return angle_between(truth.q_WB[:, bodies], run.actual.q_WB[:, bodies])


attitude_error_max, attitude_error_rms, attitude_error_final = three(
    "attitude_error", "rad", "Huynh, Metrics for 3D Rotations (2009), equation 23", _angle
)


def _angular_velocity_difference(run: Run) -> Floats:
    truth, bodies = run.truth, run.movable
    difference: Floats = np.linalg.norm(run.actual.w_WB[:, bodies] - truth.w_WB[:, bodies], axis=-1)
    return difference


angular_velocity_error_max, angular_velocity_error_rms, angular_velocity_error_final = three(
    "angular_velocity_error", "rad/s", "definition: |w_WB - w_WB of the truth|", _angular_velocity_difference
)


def _error(run: Run) -> Floats:
    truth, bodies = run.truth, run.movable
    here, there = (np.hypot(t.p_WB[:, bodies, 0], t.p_WB[:, bodies, 1]) for t in (run.actual, truth))
    if np.size(there) and not there.min() > 0:
        raise NotMeasurable("the truth passes through the vertical through the origin: there is no radius to compare with")
    error: Floats = np.abs(here / there - 1)
    return error


radius_error_max, radius_error_rms, radius_error_final = three(
    "radius_error", "1", "definition: distance from the z axis of W over the truth's, less 1", _error
)
