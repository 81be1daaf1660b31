"""Readings of inertial sensors, and the stamps of all.

Ideal signals are held against the truth's: the largest difference of accelerometer and gyroscope without noise. The truth
carries streams of the same names; readings are matched by their time stamps, and one that the truth does not have within a
nanosecond makes the error infinite. Or they are held against an engine's own motion: the trajectory carries beside the readings
what the recorded states say that a sensor has to tell (`harness.trial.answer`), '<sensor>/gyroscope_due' and
'<sensor>/range_due', NaN where no state was recorded at a reading's instant.

Digits of a channel without noise: are readings the nearest levels of the askew, scaled and bounded signal? The expected reading
is made anew from the ideal signal that was recorded: SciPy's rotations turn it into the triad, levels are counted by
floor(x + 1/2), and a signal half way between two levels within a billionth may go to either.
Source: IEEE Std 1293-2018 (misalignment, scale factor, full scale, resolution); Widrow, Kollar, Quantization Noise (2008), 1.1.

Lag: the delay at which readings are most like the signal of the instants of their time stamps, which the truth carries under
'<sensor>/<channel>_instant'. The delay t that makes the normalised cross-correlation of reading and signal(. - t) largest is
found between the samples, on a cubic spline through the signal, whose error falls with the fourth power of the interval.
Expected are the sensor's latency and, for an accelerometer that differences velocities, half an interval more; the metric is
the distance from that.
Source: Knapp, Carter, The generalized correlation method for estimation of time delay (1976); de Boor, A Practical Guide to
Splines, chapter IV.

Time stamps are whole multiples of the sensor's interval, none left out, up to the end of the run. The metric is the largest
distance of a stamp from its multiple, infinite where one is missing or stands twice. The first stamp is time 0 for a sensor
that reads an instant, and for inertial ones and spinning range finders, which tell of an interval, the first one by which a
whole interval and the latency have passed.

Attitude by integrating the gyroscope, against the body's own: over an interval T with the rates a and b at its ends, all in B,
the body turns by the rotation vector T (a + b)/2 + T^2/12 a x b, an error of order T^3 in an interval. The integral starts from
the body's first attitude and rate.
Source: Iserles, Munthe-Kaas, Norsett, Zanna, Lie-group methods, Acta Numerica 9 (2000), section 5 (Magnus expansion); Titterton
and Weston, Strapdown Inertial Navigation Technology, 2nd ed., section 11.2 (the cross product is the coning correction).
"""

import numpy as np

from plumbline.harness.metric import Metric, NotMeasurable, Run, metric
from plumbline.harness.metric.noise_scores import noisy_channels
from plumbline.harness.scene import AxisNoise, Imu, Lidar
from plumbline.harness.trajectory import Floats
from plumbline.harness.trajectory.kinematics import angle_between

NO_SENSOR = "no inertial sensor"


def _error(channel: str, unit: str) -> Metric:
    def measure(run: Run) -> float:
        worst = 0.0
        for sensor in run.sensors(Imu, NO_SENSOR):
            name, stamps = f"{sensor.name}/{channel}_ideal", f"{sensor.name}/time"
            signal, truth = run.stream(name), run.true_stream(name)
            here, there = run.stream(stamps), run.true_stream(stamps)
            if here.shape != there.shape or not np.all(np.abs(here - there) < 1e-9):
                return float("inf")
            # max() of Python would drop a NaN.
            worst = float(np.max([worst, *np.linalg.norm(signal - truth, axis=1)]))
        return worst

    source = "definition: |signal - signal of the truth|"
    return Metric(name=f"{channel}_ideal_error", unit=unit, source=source, measure=measure)


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
        if law.quantisation > 0 and not random:
            worst.append(float(np.max(_wrong_by(law, run.stream(name), run.stream(f"{name}_ideal")))))
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
        for sensor in run.sensors(Imu, NO_SENSOR):
            name, interval = f"{sensor.name}/{channel}", 1.0 / sensor.rate
            signal, reading = run.true_stream(f"{name}_instant"), run.stream(name)
            time, stamps = run.stream(f"{sensor.name}/time"), run.true_stream(f"{sensor.name}/time")
            if time.shape != stamps.shape or not np.all(np.abs(time - stamps) < 1e-9):
                raise NotMeasurable(f"the truth of '{name}' stands at other times than the readings")
            own = bool(np.all(run.stream(f"{sensor.name}/native") == 1.0))
            due = sensor.latency + (0.5 * interval if channel == "accelerometer" and not own else 0.0)
            worst.append(abs(delay(time, reading, signal, due + REACH * interval) - due))
        return worst

    name, source = f"{channel}_lag_error", "cross-correlation: Knapp, Carter (1976)"
    return Metric(name=name, unit="s", source=source, measure=measure)


accelerometer_lag_error, gyroscope_lag_error = _lag("accelerometer"), _lag("gyroscope")


@metric("s", empty="the scene has no sensor, or none was read")
def time_stamp_error(run: Run) -> Floats:
    """definition: |stamp - k/rate|"""
    worst = [np.zeros(0)]
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
            return np.array([np.inf])
        worst.append(np.abs(stamps - due))
    return np.concatenate(worst)


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
def gyroscope_attitude_error(run: Run) -> Floats:
    """Magnus expansion: Iserles et al. (2000)"""
    from scipy.spatial.transform import Rotation

    worst = []
    for sensor in run.sensors(Imu, NO_SENSOR):
        rates_S, stamps = run.stream(f"{sensor.name}/gyroscope_ideal"), run.stream(f"{sensor.name}/time")
        if sensor.latency > 0:
            raise NotMeasurable(f"sensor '{sensor.name}' has a latency; its rates are of other instants than the attitudes")
        place = run.scene.index(sensor.body)
        rows = np.searchsorted(run.actual.time, stamps - 1e-9)
        if rows[-1] >= len(run.actual) or not np.all(np.abs(run.actual.time[rows] - stamps) < 1e-9):
            raise NotMeasurable(f"the states were not recorded at the stamps of '{sensor.name}'")
        if not np.isfinite(rates_S).all():
            return np.array([np.nan])
        rates_B = Rotation.from_quat(sensor.q_BS, scalar_first=True).apply(rates_S)
        q_WB = run.actual.q_WB[:, place]
        first = Rotation.from_quat(q_WB[0], scalar_first=True).inv().apply(run.actual.w_WB[0, place])
        integral = _integrated(np.concatenate([first[None], rates_B]), 1.0 / sensor.rate, q_WB[0])
        worst.append(angle_between(integral[1:], q_WB[rows]))
    return np.concatenate(worst)


OTHER_SURFACE = 0.1
"""Of a range: what is farther off has met another surface, at an edge, and is no error of the range."""


def _pairs(run: Run, channel: str) -> list[tuple[Floats, Floats]]:
    """The readings of a channel and what was due, of every sensor that has both. Raises: NotMeasurable."""
    pairs = []
    for sensor in run.scene.sensors:
        due, reading = (run.actual.streams.get(f"{sensor.name}/{channel}_{word}") for word in ("due", "ideal"))
        if due is not None and reading is not None:
            known = ~np.isnan(due).reshape(len(due), -1).all(axis=1)
            pairs.append((reading[known], due[known]))
    if not pairs:
        raise NotMeasurable(f"nothing is known of what a {channel} has to read")
    return pairs


@metric("rad/s")
def gyroscope_off_motion(run: Run) -> Floats:
    """definition: |ideal reading - angular velocity of the recorded state in the sensor's frame|"""
    return np.concatenate([np.linalg.norm(reading - due, axis=1) for reading, due in _pairs(run, "gyroscope")])


@metric("m", empty="no beam meets the surface that it has to meet")
def range_off_geometry(run: Run) -> Floats:
    """closed-form intersection of rays and shapes at the recorded state, of beams that meet the same surface"""
    off = []
    for reading, due in _pairs(run, "range"):
        both = np.isfinite(due) & ~np.isinf(reading)
        with np.errstate(invalid="ignore"):
            same = both & ~(np.abs(reading - due) > OTHER_SURFACE * due)
        off.append(np.abs(reading[same] - due[same]))
    return np.concatenate(off)
