"""Lag of inertial readings: the delay at which they are most like the signal of the instants of their time stamps.

The truth carries that signal under '<sensor>/<channel>_instant'. The delay t that makes the normalised cross-correlation of
reading and signal(. - t) largest is found between the samples, on a cubic spline through the signal, whose error falls with the
fourth power of the interval. Expected are the sensor's latency and, for an accelerometer that differences velocities, half an
interval more; the metric is the distance from that.

Source: Knapp, Carter, The generalized correlation method for estimation of time delay (1976); de Boor, A Practical Guide to
Splines, chapter IV.
"""

import numpy as np

from plumbline.harness.metric import Metric, NotMeasurable, Run
from plumbline.harness.scene import Imu
from plumbline.harness.trajectory import Floats

REACH = 3.0
"""How far beyond the expected delay it is looked for, in intervals."""


def delay(time: Floats, reading: Floats, signal: Floats, reach: float) -> float:
    """The delay [s], at most `reach` to either side, at which reading (k, c) is most like signal (k, c), both at time (k,)."""
    from scipy.interpolate import CubicSpline  # late: a listing must not pay for it
    from scipy.optimize import minimize_scalar

    curve = CubicSpline(time, signal)
    inside = (time >= time[0] + reach) & (time <= time[-1] - reach)
    if inside.sum() < 8:
        raise NotMeasurable(f"{int(inside.sum())} readings lie within the search for their lag, at least 8 are needed")
    judged = reading[inside]
    if not (np.isfinite(judged).all() and np.isfinite(signal).all()):
        return float("nan")
    if not np.any(np.ptp(signal, axis=0) > 0):
        raise NotMeasurable("the signal does not change, so that no lag shows")

    def unlike(shift: float) -> float:
        there = curve(time[inside] - shift)
        a, b = judged - judged.mean(axis=0), there - there.mean(axis=0)
        return -float(np.sum(a * b) / np.sqrt(np.sum(a * a) * np.sum(b * b)))

    # The coarse search keeps a periodic signal's other maxima out of the fine one.
    shifts = np.linspace(-reach, reach, 49)
    best = shifts[int(np.argmin([unlike(shift) for shift in shifts]))]
    step = shifts[1] - shifts[0]
    minimum = minimize_scalar(unlike, bounds=(best - step, best + step), method="bounded", options={"xatol": 1e-9 * reach})
    return float(minimum.x)


def _lag(channel: str) -> Metric:
    def measure(run: Run) -> list[float]:
        worst = []
        for sensor in run.scene.sensors:
            if not isinstance(sensor, Imu):
                continue
            name, interval = f"{sensor.name}/{channel}", 1.0 / sensor.rate
            if run.expected is None or f"{name}_instant" not in run.expected.streams:
                raise NotMeasurable(f"the truth has no stream '{name}_instant'")
            if name not in run.actual.streams:
                raise NotMeasurable(f"stream '{name}' was not recorded")
            time, stamps = run.actual.streams[f"{sensor.name}/time"], run.expected.streams[f"{sensor.name}/time"]
            if time.shape != stamps.shape or not np.all(np.abs(time - stamps) < 1e-9):
                raise NotMeasurable(f"the truth of '{name}' stands at other times than the readings")
            own = bool(np.all(run.actual.streams[f"{sensor.name}/native"] == 1.0))
            due = sensor.latency + (0.5 * interval if channel == "accelerometer" and not own else 0.0)
            signal = run.expected.streams[f"{name}_instant"]
            worst.append(abs(delay(time, run.actual.streams[name], signal, due + REACH * interval) - due))
        return worst

    name, source = f"{channel}_lag_error", "cross-correlation: Knapp, Carter (1976)"
    return Metric(name=name, unit="s", source=source, measure=measure, empty="the scene has no inertial sensor")


accelerometer_lag_error, gyroscope_lag_error = _lag("accelerometer"), _lag("gyroscope")
