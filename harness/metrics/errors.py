"""Errors against the truth, over the bodies that a force moves.

Of positions and velocities the distance between those of answer and truth, of the centres of mass, in W; of attitudes the angle
of the rotation between them, the geodesic distance on SO(3); the radius error is how far bodies leave their distance from the
vertical through the origin, as a share of the truth's.
"""

import numpy as np

from plumbline.harness.metric import NotMeasurable, Run, metric
from plumbline.harness.metric.series import Series, three
from plumbline.harness.trajectory import Floats
from plumbline.harness.trajectory.kinematics import angle_between


def _distance(array: str) -> Series:
    """Between what answer and truth have in one of their arrays, (t, n)."""

    def distance(run: Run) -> Floats:
        truth, bodies = getattr(run.truth, array), run.movable
        apart: Floats = np.linalg.norm(getattr(run.actual, array)[:, bodies] - truth[:, bodies], axis=-1)
        return apart

    return distance


def _angle(run: Run) -> Floats:
    truth, bodies = run.truth, run.movable
    return angle_between(truth.q_WB[:, bodies], run.actual.q_WB[:, bodies])


def _radius(run: Run) -> Floats:
    truth, bodies = run.truth, run.movable
    here, there = (np.hypot(t.p_WB[:, bodies, 0], t.p_WB[:, bodies, 1]) for t in (run.actual, truth))
    if np.size(there) and not there.min() > 0:
        raise NotMeasurable("the truth passes through the vertical through the origin: there is no radius to compare with")
    error: Floats = np.abs(here / there - 1)
    return error


position_error_max, position_error_rms, position_error_final = three(
    "position_error", "m", "definition: |p_WB - p_WB of the truth|", _distance("p_WB")
)
velocity_error_max, velocity_error_rms, velocity_error_final = three(
    "velocity_error", "m/s", "definition: |v_WB - v_WB of the truth|", _distance("v_WB")
)
angular_velocity_error_max, angular_velocity_error_rms, angular_velocity_error_final = three(
    "angular_velocity_error", "rad/s", "definition: |w_WB - w_WB of the truth|", _distance("w_WB")
)
attitude_error_max, attitude_error_rms, attitude_error_final = three(
    "attitude_error", "rad", "Huynh, Metrics for 3D Rotations (2009), equation 23", _angle
)
radius_error_max, radius_error_rms, radius_error_final = three(
    "radius_error", "1", "definition: distance from the z axis of W over the truth's, less 1", _radius
)


@metric("1", verdict="a number is not finite", finite=False)
def divergence(run: Run) -> float:
    """definition: 0 if all states are finite, else infinite"""
    return 0.0 if run.actual.finite else float(np.inf)
