"""Readings of inertial sensors, and the stamps of all.

Ideal inertial signal against its truth: the largest difference of accelerometer and gyroscope without noise.

The truth carries streams of the same names; readings are matched by their time stamps, and one that the truth does not have
within a nanosecond makes the error infinite.

The digits of an inertial channel without noise: are readings the nearest levels of the askew, scaled and bounded signal?

The expected reading is made anew from the ideal signal that was recorded: SciPy's rotations turn it into the triad, levels are
counted by floor(x + 1/2), and a signal half way between two levels within a billionth may go to either.

Source: IEEE Std 1293-2018 (misalignment, scale factor, full scale, resolution); Widrow, Kollar, Quantization Noise (2008), 1.1.

Lag of inertial readings: the delay at which they are most like the signal of the instants of their time stamps.

The truth carries that signal under '<sensor>/<channel>_instant'. The delay t that makes the normalised cross-correlation of
reading and signal(. - t) largest is found between the samples, on a cubic spline through the signal, whose error falls with the
fourth power of the interval. Expected are the sensor's latency and, for an accelerometer that differences velocities, half an
interval more; the metric is the distance from that.

Source: Knapp, Carter, The generalized correlation method for estimation of time delay (1976); de Boor, A Practical Guide to
Splines, chapter IV.

Time stamps of sensors: whole multiples of the sensor's interval, none left out, up to the end of the run.

The metric is the largest distance of a stamp from its multiple, infinite where one is missing or stands twice. The first stamp
is time 0 for a sensor that reads an instant, and for inertial ones and spinning range finders, which tell of an interval, the
first one by which a whole interval and the latency have passed.
"""

import numpy as np

from plumbline.harness.metric import Metric, NotMeasurable, Run, metric
from plumbline.harness.metric.inertial_residual import noisy_channels
from plumbline.harness.metric.series import maximum
from plumbline.harness.scene import AxisNoise, Imu, Lidar
from plumbline.harness.trajectory import Floats


def _error(channel: str, unit: str) -> Metric:
    def measure(run: Run) -> float:
        worst = []
        for sensor in run.scene.sensors:
            if not isinstance(sensor, Imu):
                continue
            name, stamps = f"{sensor.name}/{channel}_ideal", f"{sensor.name}/time"
            if run.expected is None or name not in run.expected.streams:
                raise NotMeasurable(f"the truth has no stream '{name}'")
            if name not in run.actual.streams or len(run.actual.streams[name]) == 0:
                raise NotMeasurable(f"stream '{name}' was not recorded")
            here, there = run.actual.streams[stamps], run.expected.streams[stamps]
            if here.shape != there.shape or not np.all(np.abs(here - there) < 1e-9):
                return float("inf")
            worst.append(maximum(np.linalg.norm(run.actual.streams[name] - run.expected.streams[name], axis=1)))
        if not worst:
            raise NotMeasurable("the scene has no inertial sensor")
        return maximum(np.array(worst))

    return Metric(
        name=f"{channel}_ideal_error", unit=unit, source="definition: |signal - signal of the truth|", measure=measure
    )


accelerometer_ideal_error, gyroscope_ideal_error = _error("accelerometer", "m/s2"), _error("gyroscope", "rad/s")


TIE = 1e-9
"""Distance from half way between two levels, in steps, within which roundings decide."""


def _wrong_by(law: AxisNoise, reading: Floats, ideal: Floats) -> Floats:
    """Distance (k, 3) of each reading from the level that is due, in steps of the quantisation."""
    from scipy.spatial.transform import Rotation  # late: a listing must not pay for it

    steps = (1.0 + law.scale_error) * Rotation.from_rotvec(law.misalignment).inv().apply(ideal) / law.quantisation
    level = np.floor(steps + 0.5)
    highest = np.inf if law.saturation is None else np.floor(law.saturation / law.quantisation + TIE)
    due, other = (np.clip(unclipped, -highest, highest) for unclipped in (level, 2.0 * steps - level))
    wrong = np.abs(reading / law.quantisation - due)
    tied = np.abs(np.abs(steps - np.floor(steps)) - 0.5) < TIE
    error: Floats = np.where(tied, np.minimum(wrong, np.abs(reading / law.quantisation - np.rint(other))), wrong)
    return error


@metric("1", empty="no inertial channel of the scene has digits and no noise")
def inertial_readout_error(run: Run) -> list[float]:
    """IEEE Std 1293-2018: |reading - nearest level|, in steps"""
    worst = []
    for sensor, channel, law in noisy_channels(run.scene):
        name = f"{sensor.name}/{channel}"
        random = law.density > 0 or law.instability > 0 or law.random_walk > 0 or law.bias != 0
        if law.quantisation == 0 or random:
            continue
        if len(run.actual.streams.get(name, ())) == 0:
            raise NotMeasurable(f"stream '{name}' was not recorded")
        worst.append(maximum(_wrong_by(law, run.actual.streams[name], run.actual.streams[f"{name}_ideal"])))
    return worst


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


@metric("s")
def time_stamp_error(run: Run) -> float:
    """definition: |stamp - k/rate|"""
    worst = []
    for sensor in run.scene.sensors:
        name = f"{sensor.name}/time"
        if name not in run.actual.streams:
            raise NotMeasurable(f"stream '{name}' was not recorded")
        stamps, interval = run.actual.streams[name], 1.0 / sensor.rate
        first = 0
        if isinstance(sensor, Imu):
            first = 1 + int(np.ceil(sensor.latency / interval - 1e-9))
        elif isinstance(sensor, Lidar) and sensor.spinning:
            first = 1
        last = int(np.floor(float(run.actual.time[-1]) / interval + 1e-6))
        due = np.arange(first, last + 1) * interval
        if len(stamps) != len(due):
            return float("inf")
        if not np.isfinite(stamps).all():
            return float("nan")
        worst.append(np.abs(stamps - due))
    if not worst or sum(map(len, worst)) == 0:
        raise NotMeasurable("the scene has no sensor, or none was read")
    return maximum(np.concatenate(worst))
