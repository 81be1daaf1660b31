"""Ideal inertial measurements, from the states of the body that the sensor is mounted on.

The gyroscope gives w_WB in S at the instant of its time stamp. The accelerometer gives the specific force a - g of the point S,
where a is the change of the velocity of S over the sensor's own interval that ends at the time stamp, divided by that interval
(a backward difference: what a sensor that integrates and dumps puts out, and all that can be known at that instant), turned
into S by the attitude in the middle of the interval. It is therefore the mean over the interval and lags half an interval.

Source: Titterton and Weston, Strapdown Inertial Navigation Technology, 2nd ed., sections 3.5 and 11.3.
"""

import numpy as np

from harness.kinematics import conjugate, product, rotate, rotate_back
from harness.scene import Effect, Imu
from harness.sensors.imu_noise import three_axes
from harness.sensors.reader import Setting, row_of
from harness.trajectory import Floats, State

__all__ = ["ImuReader", "ideal"]


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


class ImuReader:
    """Readings '<name>/accelerometer' and '<name>/gyroscope' (k, 3); none at time 0, before which no interval has passed."""

    def __init__(self, imu: Imu, setting: Setting, start: State) -> None:
        self._imu, self._setting = imu, setting
        self._times, self._rows = [0.0], [row_of(setting.scene, imu.body, start)]

    def read(self, time: float, state: State) -> None:
        """Note the state of the carrying body."""
        if time > 0:
            self._times.append(time)
            self._rows.append(row_of(self._setting.scene, self._imu.body, state))

    def streams(self) -> dict[str, Floats]:
        """Both channels, ideal and with noise."""
        imu, scene = self._imu, self._setting.scene
        name, time, rows = imu.name, np.array(self._times), np.stack(self._rows)
        felt = (0.0, 0.0, 0.0) if Effect.GRAVITY in scene.narrow else scene.gravity
        force, rate = ideal(imu, time, rows[:, 3:7], rows[:, 7:10], rows[:, 10:], felt)
        found = {f"{name}/time": time[1:], f"{name}/accelerometer_ideal": force, f"{name}/gyroscope_ideal": rate}
        for channel, signal in (("accelerometer", force), ("gyroscope", rate)):
            law = None if imu.noise is None else getattr(imu.noise, channel)
            noise = 0.0 if law is None else three_axes(law, len(signal), 1.0 / imu.rate, self._setting.seed, name, channel)
            found[f"{name}/{channel}"] = signal + noise
        return found
