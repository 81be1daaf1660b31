"""Attitude error: angle of the rotation between answer and truth, the geodesic distance on SO(3)."""

from plumbline.harness.metric import Run
from plumbline.harness.metric.series import three
from plumbline.harness.trajectory import Floats
from plumbline.harness.trajectory.kinematics import angle_between


def _angle(run: Run) -> Floats:
    truth, bodies = run.truth, run.movable
    return angle_between(truth.q_WB[:, bodies], run.actual.q_WB[:, bodies])


attitude_error_max, attitude_error_rms, attitude_error_final = three(
    "attitude_error", "rad", "Huynh, Metrics for 3D Rotations (2009), equation 23", _angle
)
