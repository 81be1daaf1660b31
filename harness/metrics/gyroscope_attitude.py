"""Attitude by integrating the gyroscope, against the body's own attitude: the largest angle between the two.

Over an interval T with the rates a and b at its ends, all in B, the body turns by the rotation vector
T (a + b)/2 + T^2/12 a x b, an error of order T^3 in an interval. The integral starts from the body's first attitude and rate.

Source: Iserles, Munthe-Kaas, Norsett, Zanna, Lie-group methods, Acta Numerica 9 (2000), section 5 (Magnus expansion); Titterton
and Weston, Strapdown Inertial Navigation Technology, 2nd ed., section 11.2 (the cross product is the coning correction).
"""

import numpy as np

from plumbline.harness.metric import NotMeasurable, Run, metric
from plumbline.harness.metric.series import maximum
from plumbline.harness.scene import Imu
from plumbline.harness.trajectory import Floats
from plumbline.harness.trajectory.kinematics import angle_between


def _integrated(rates_B: Floats, interval: float, q_WB: Floats) -> Floats:
    """Attitudes (k + 1, 4) from rates (k + 1, 3) [rad/s] at instants `interval` [s] apart, the first one given."""
    from scipy.spatial.transform import Rotation  # late: a listing must not pay for it

    early, late = rates_B[:-1], rates_B[1:]
    turns = Rotation.from_rotvec(interval / 2 * (early + late) + interval**2 / 12 * np.cross(early, late))
    here = Rotation.from_quat(q_WB, scalar_first=True)
    attitudes = [q_WB]
    for turn in turns:
        here = here * turn
        attitudes.append(here.as_quat(scalar_first=True))
    return np.array(attitudes)


@metric("rad")
def gyroscope_attitude_error(run: Run) -> float:
    """Magnus expansion: Iserles et al. (2000)"""
    from scipy.spatial.transform import Rotation

    worst = []
    for sensor in run.scene.sensors:
        if not isinstance(sensor, Imu):
            continue
        name = f"{sensor.name}/gyroscope_ideal"
        if name not in run.actual.streams or len(run.actual.streams[name]) == 0:
            raise NotMeasurable(f"stream '{name}' was not recorded")
        if sensor.latency > 0:
            raise NotMeasurable(f"sensor '{sensor.name}' has a latency; its rates are of other instants than the attitudes")
        stamps, place = run.actual.streams[f"{sensor.name}/time"], run.scene.index(sensor.body)
        rows = np.searchsorted(run.actual.time, stamps - 1e-9)
        if rows[-1] >= len(run.actual) or not np.all(np.abs(run.actual.time[rows] - stamps) < 1e-9):
            raise NotMeasurable(f"the states were not recorded at the stamps of '{sensor.name}'")
        if not np.isfinite(run.actual.streams[name]).all():
            return float("nan")
        rates_B = Rotation.from_quat(sensor.q_BS, scalar_first=True).apply(run.actual.streams[name])
        q_WB = run.actual.q_WB[:, place]
        first = Rotation.from_quat(q_WB[0], scalar_first=True).inv().apply(run.actual.w_WB[0, place])
        integral = _integrated(np.concatenate([first[None], rates_B]), 1.0 / sensor.rate, q_WB[0])
        worst.append(angle_between(integral[1:], q_WB[rows]))
    if not worst:
        raise NotMeasurable("the scene has no inertial sensor")
    return maximum(np.concatenate(worst))
