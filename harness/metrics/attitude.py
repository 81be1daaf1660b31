"""Attitude error: angle of the rotation between answer and truth, the geodesic distance on SO(3)."""

from harness.metric.series import matched, three
from harness.scene import Scene
from harness.trajectory import Floats, Trajectory
from harness.trajectory.kinematics import angle_between, movable


def _angle(scene: Scene, actual: Trajectory, expected: Trajectory | None) -> Floats:
    truth, bodies = matched(actual, expected), movable(scene)
    return angle_between(truth.q_WB[:, bodies], actual.q_WB[:, bodies])


METRIC = ATTITUDE_MAX, ATTITUDE_RMS, ATTITUDE_FINAL = three(
    "attitude_error", "rad", "Huynh, Metrics for 3D Rotations (2009), equation 23", _angle
)
