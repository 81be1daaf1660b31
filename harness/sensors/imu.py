"""Inertial measurements, from the engine's own sensor or from the states of the body that the sensor is mounted on.

An engine's own sensor gives specific force and rate of the instant. From states, which any engine has, the gyroscope gives
w_WB in S at that instant, and the accelerometer the specific force a - g of the point S, where a is the change of the velocity
of S over the sensor's own interval that ends then, divided by that interval (a backward difference: what a sensor that
integrates and dumps puts out, and all that can be known at that instant), turned into S by the attitude in the middle of the
interval. It is therefore the mean over the interval and lags half an interval. The instant is the time stamp less the latency.

Source: Titterton and Weston, Strapdown Inertial Navigation Technology, 2nd ed., sections 3.5 and 11.3.

What an inertial channel does to a signal besides adding noise: a triad out of line, a scale error, bounds and digits.

The triad A of a channel stands turned against S by the rotation vector `misalignment`, so that it reads u_A = R_SA^T u_S; the
scale error multiplies what it reads. After the noise, readings are rounded to whole multiples of the quantisation, half a
step to the even one, and kept within the bounds: the greatest multiple that does not exceed the saturation.

Source: IEEE Std 952-1997 and IEEE Std 1293-2018 (misalignment, scale factor, full scale, resolution); Widrow, Kollar,
Quantization Noise (2008), section 1.1 (rounding to the nearest level).

Noise of an inertial channel: white noise, constant bias, bias instability and rate random walk.

Conventions: densities are those of IEEE Std 952, whose two-sided spectrum of white noise is N^2, so that samples at a rate f
have the standard deviation N sqrt(f) and the Allan deviation is N / sqrt(tau). Bias instability is a first-order Gauss-Markov
process of the given correlation time, so strong that the maximum of its Allan deviation is the given floor. The random walk
starts from zero and gives the Allan deviation K sqrt(tau / 3).

Source: IEEE Std 952-1997, annex C: angle random walk, bias instability, rate random walk and Markov noise.
"""

from collections.abc import Callable

import numpy as np

from plumbline.harness.scene import AxisNoise, Effect, Imu
from plumbline.harness.sensors.reader import Setting, generator, row_of
from plumbline.harness.trajectory import Floats, State
from plumbline.harness.trajectory.kinematics import conjugate, product, rotate, rotate_back

MARKOV_PEAK = 0.617364
"""Largest Allan deviation of a Gauss-Markov process over its standard deviation, at tau = 1.89 correlation times."""


def axis_noise(noise: AxisNoise, count: int, interval: float, seed: int, sensor: str, channel: str, axis: int) -> Floats:
    """Noise of one axis at `count` instants `interval` [s] apart, (count,), in the channel's unit.

    A longer record begins with the shorter one: each process draws from a generator of its own, in the order of time.
    """
    total = np.full(count, noise.bias)
    if noise.density > 0:
        white = generator(seed, sensor, f"{channel}/white", axis).standard_normal(count)
        total += noise.density / np.sqrt(interval) * white
    if noise.instability > 0:
        from scipy.signal import lfilter  # late: it costs half a second, which only this process of the three needs

        sigma = noise.instability / MARKOV_PEAK
        memory = np.exp(-interval / noise.instability_time)
        driving = generator(seed, sensor, f"{channel}/instability", axis).standard_normal(count)
        # Stationary from the first sample on: that one has the full variance, the others replace what was forgotten.
        driving[1:] *= np.sqrt(-np.expm1(-2.0 * interval / noise.instability_time))
        total += sigma * lfilter([1.0], [1.0, -memory], driving)
    if noise.random_walk > 0:
        steps = generator(seed, sensor, f"{channel}/random_walk", axis).standard_normal(count)
        total += noise.random_walk * np.sqrt(interval) * np.cumsum(steps)
    return total


def three_axes(noise: AxisNoise, count: int, interval: float, seed: int, sensor: str, channel: str) -> Floats:
    """Independent noise of three axes, (count, 3)."""
    return np.stack([axis_noise(noise, count, interval, seed, sensor, channel, axis) for axis in range(3)], axis=1)


def sensed(law: AxisNoise, signal_S: Floats) -> Floats:
    """The signal (k, 3) as the channel's own triad and scale have it, before noise."""
    turn = np.array(law.misalignment)
    angle = float(np.linalg.norm(turn))
    scaled: Floats = (1.0 + law.scale_error) * signal_S
    if angle == 0.0:
        return scaled
    q_SA = np.array([np.cos(angle / 2), *(np.sin(angle / 2) / angle * turn)])
    return rotate_back(np.broadcast_to(q_SA, (len(scaled), 4)), scaled)


def read_out(law: AxisNoise, signal: Floats) -> Floats:
    """What comes out for a signal with its noise, in digits and within bounds; what is not a number stays none."""
    step, bound = law.quantisation, law.saturation
    if step > 0.0:
        signal = step * np.rint(signal / step)
        # A bound written as 16 g and a step of 16 g / 2^15 may miss each other by a rounding.
        bound = None if bound is None else step * np.floor(bound / step * (1.0 + 1e-12))
    return signal if bound is None else np.clip(signal, -bound, bound)


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
    """Readings '<name>/accelerometer' and '<name>/gyroscope' (k, 3), and '<name>/native' (k,), 1 where the engine's own spoke.

    `read` is called at the instants that the readings tell of; a reading is stamped with that instant and the latency. There
    is none before a whole interval has passed, whoever speaks, so that all engines give the same stamps.
    """

    def __init__(self, imu: Imu, setting: Setting, start: State) -> None:
        self._imu, self._setting = imu, setting
        self._start = row_of(setting.scene, imu.body, start)
        self._times: list[float] = []
        self._rows: list[Floats] = []
        self._own: Callable[[str], tuple[Floats, Floats]] | None = None
        if imu.reading == "native":
            self._own = getattr(setting.simulation, "inertial", None)
        self._felt: list[tuple[Floats, Floats]] = []

    def read(self, time: float, state: State) -> None:
        """Note the state of the carrying body, and what the engine's own sensor says where it is asked."""
        if not self._times and time * self._imu.rate > 1.0 - 1e-6:
            # Nobody read at time 0.
            self._times, self._rows = [0.0], [self._start]
        if self._own is not None and self._times:
            self._felt.append(self._own(self._imu.name))
        self._times.append(time)
        self._rows.append(self._start if time == 0.0 else row_of(self._setting.scene, self._imu.body, state))

    def _ideal(self) -> tuple[Floats, Floats]:
        """Specific force and angular velocity of the instants that the readings tell of, each (k, 3)."""
        scene = self._setting.scene
        if len(self._times) < 2:
            return np.zeros((0, 3)), np.zeros((0, 3))
        if self._own is not None:
            force, rate = (np.array([pair[channel] for pair in self._felt]) for channel in (0, 1))
            return force, rate
        felt = (0.0, 0.0, 0.0) if Effect.GRAVITY in scene.narrow else scene.gravity
        rows = np.stack(self._rows)
        return ideal(self._imu, np.array(self._times), rows[:, 3:7], rows[:, 7:10], rows[:, 10:], felt)

    def streams(self) -> dict[str, Floats]:
        """Both channels, ideal and with all errors."""
        imu, name, count = self._imu, self._imu.name, max(len(self._times) - 1, 0)
        signals = dict(zip(("accelerometer", "gyroscope"), self._ideal(), strict=True))
        streams: dict[str, Floats] = {f"{name}/time": np.array(self._times[1:]) + imu.latency}
        streams[f"{name}/native"] = np.full(count, float(self._own is not None))
        for channel, signal in signals.items():
            streams[f"{name}/{channel}_ideal"] = signal
            streams[f"{name}/{channel}"] = signal.copy()
            if imu.noise is not None:
                law = getattr(imu.noise, channel)
                noise = three_axes(law, count, 1.0 / imu.rate, self._setting.seed, name, channel)
                streams[f"{name}/{channel}"] = read_out(law, sensed(law, signal) + noise)
        return streams
