"""Ideal inertial measurements, from the states of the body that the sensor is mounted on.

The gyroscope gives w_WB in S at the instant of its time stamp. The accelerometer gives the specific force a - g of the point S,
where a is the change of the velocity of S over the sensor's own interval that ends at the time stamp, divided by that interval
(a backward difference: what a sensor that integrates and dumps puts out, and all that can be known at that instant), turned
into S by the attitude in the middle of the interval. It is therefore the mean over the interval and lags half an interval.

Source: Titterton and Weston, Strapdown Inertial Navigation Technology, 2nd ed., sections 3.5 and 11.3.
"""

import numpy as np

from harness.kinematics import conjugate, product, rotate, rotate_back
from harness.scene import Imu
from harness.trajectory import Floats

__all__ = ["ideal"]


def ideal(
    imu: Imu, time: Floats, q_WB: Floats, v_WB: Floats, w_WB: Floats, gravity: tuple[float, float, float]
) -> tuple[Floats, Floats]:
    """Specific force [m/s2] and angular velocity [rad/s] in S, each (k, 3), from the states at k + 1 instants.

    Args:
        time: the instants [s], shape (k + 1,); readings belong to all but the first.
        q_WB, v_WB, w_WB: attitude (k + 1, 4), velocity of the centre of mass [m/s] and angular velocity [rad/s], (k + 1, 3).
        gravity: [m/s2] in W.
    """
    q_WS = product(q_WB, np.broadcast_to(np.array(imu.q_BS), q_WB.shape))
    arm_W = rotate(q_WB, np.broadcast_to(np.array(imu.p_BS), v_WB.shape))
    v_WS = v_WB + np.cross(w_WB, arm_W)
    force_W = np.diff(v_WS, axis=0) / np.diff(time)[:, None] - np.array(gravity)
    return rotate_back(_middle(q_WS), force_W), rotate_back(q_WS[1:], w_WB[1:])


def _middle(q: Floats) -> Floats:
    """Attitudes half way between consecutive ones on the shorter arc, (k, 4) from (k + 1, 4)."""
    step = product(conjugate(q[:-1]), q[1:])
    # The sum of two unit quaternions halves the angle between them; q and -q are one attitude.
    total = q[:-1] + np.where(step[:, :1] < 0, -1.0, 1.0) * q[1:]
    middle: Floats = total / np.linalg.norm(total, axis=1, keepdims=True)
    return middle
