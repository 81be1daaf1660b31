"""Allan deviation of inertial noise against its law: levels as confidence scores, and the slopes -1/2, 0 and +1/2.

The overlapping Allan variance is a quadratic form of a Gaussian process whose law is known, so that its mean and its variance
follow exactly from the spectrum; with these two it is compared with a chi-squared variable, and the probability is given as a
normal score. The score is the largest over three axes and all octaves of averaging time up to a ninth of the record.

Source: IEEE Std 952-1997, annex C; Riley, Handbook of Frequency Stability Analysis (NIST SP 1065), sections 5.2.4 and 5.3.
"""

from functools import lru_cache
from typing import Literal

import numpy as np

from plumbline.harness.metric import Metric, NotMeasurable, Run
from plumbline.harness.metric.inertial_residual import inertial_residual
from plumbline.harness.metric.series import maximum
from plumbline.harness.scene import AxisNoise, Imu, Scene
from plumbline.harness.trajectory import Floats, Trajectory

Channel = Literal["gyroscope", "accelerometer"]
Regime = Literal["white", "floor", "random_walk"]
SOURCE = "IEEE Std 952-1997, annex C; overlapping estimator: NIST SP 1065, section 5.2.4"
SLOPE = {"white": -0.5, "floor": 0.0, "random_walk": 0.5}
PEAK = 1.89
"""Averaging time of the flat top of a Gauss-Markov process, in correlation times."""
SHARPEST = 8.2
"""Largest normal score whose probability a double can tell from 0."""


def overlapping_variance(signal: Floats, m: int) -> Floats:
    """Overlapping Allan variance of each column of signal (n, k), averaged over m samples, (k,) in the unit squared."""
    return _of_sums(_sums(signal), m)


def _sums(signal: Floats) -> Floats:
    """Of the first 0, 1, ..., n samples of each column about its mean, (n + 1, k)."""
    return np.concatenate([np.zeros((1, signal.shape[1])), np.cumsum(signal - signal.mean(axis=0), axis=0)])


def _of_sums(total: Floats, m: int) -> Floats:
    z = (total[2 * m :] - 2.0 * total[m:-m] + total[: -2 * m]) / m
    variance: Floats = 0.5 * np.mean(np.square(z), axis=0)
    return variance


@lru_cache(maxsize=4096)
def expected_variance(law: AxisNoise, m: int, count: int, interval: float) -> tuple[float, float]:
    """Mean of the overlapping Allan variance of `count` samples, and the degrees of freedom 2 mean^2 / variance."""
    memory = np.exp(-interval / law.instability_time)
    # Long enough that the correlation of neither the filter nor the Markov process wraps around.
    size = 1 << int(np.ceil(np.log2(2 * count + 40 * law.instability_time / interval)))
    blocks = np.concatenate([-np.ones(m), np.ones(m)]) / m
    filtered = np.square(np.abs(np.fft.rfft(blocks, size)))
    spectrum = law.density**2 / interval * filtered
    if law.instability > 0:
        sigma = law.instability / _markov_peak()
        turn = np.exp(-2j * np.pi * np.arange(size // 2 + 1) / size)
        spectrum = spectrum + sigma**2 * (1 - memory**2) / np.square(np.abs(1 - memory * turn)) * filtered
    if law.random_walk > 0:
        # A step of the walk moves all later samples: the filter that it meets is the running sum of the blocks.
        spectrum = spectrum + law.random_walk**2 * interval * np.square(np.abs(np.fft.rfft(np.cumsum(blocks), size)))
    samples = count - 2 * m + 1
    correlation = np.fft.irfft(spectrum, size)[:samples]
    weights = np.where(np.arange(samples) == 0, 1.0, 2.0) * (samples - np.arange(samples))
    mean = 0.5 * correlation[0]
    variance = float(np.sum(weights * np.square(correlation))) / (2.0 * samples**2)
    return float(mean), 2.0 * float(mean) ** 2 / variance


@lru_cache(maxsize=1)
def _markov_peak() -> float:
    """Largest Allan deviation of a Gauss-Markov process over its standard deviation (IEEE Std 952, annex C)."""
    x = np.linspace(1.5, 2.5, 10001)
    return float(np.sqrt(np.max(2 / x * (1 - (3 - 4 * np.exp(-x) + np.exp(-2 * x)) / (2 * x)))))


def octaves(count: int) -> tuple[int, ...]:
    """Numbers of samples to average over: powers of 2 up to a ninth of the record."""
    return tuple(2**k for k in range(int(np.log2(max(count // 9, 1))) + 1))


def _noise(scene: Scene, actual: Trajectory, channel: Channel) -> list[tuple[AxisNoise, Floats, float]]:
    """Law, noise (n, 3) and interval [s] of each inertial sensor that has a law."""
    noises = []
    for sensor in scene.sensors:
        if isinstance(sensor, Imu) and sensor.noise is not None:
            law: AxisNoise = getattr(sensor.noise, channel)
            if law.density == law.instability == law.random_walk == 0:
                continue
            noise = inertial_residual(sensor, channel, actual)
            if len(noise) < 96:
                raise NotMeasurable(f"stream '{sensor.name}/{channel}' has {len(noise)} samples, at least 96 are needed")
            noises.append((law, noise, 1.0 / sensor.rate))
    if not noises:
        raise NotMeasurable(f"no sensor of the scene has a noisy {channel}")
    return noises


def _score(channel: Channel) -> Metric:
    def measure(run: Run) -> float:
        from scipy import stats  # late: a listing must not pay for it

        scores = []
        for law, noise, interval in _noise(run.scene, run.actual, channel):
            total = _sums(noise)
            for m in octaves(len(noise)):
                mean, freedom = expected_variance(law, m, len(noise), interval)
                level = freedom * _of_sums(total, m) / mean
                tail = np.minimum(stats.chi2.sf(level, freedom), stats.chi2.cdf(level, freedom))
                scores.append(np.minimum(np.abs(stats.norm.ppf(np.minimum(tail, 0.5))), SHARPEST))
        return maximum(np.array(scores))

    return Metric(name=f"{channel}_allan_score", unit="1", source=SOURCE, measure=measure)


def windows(law: AxisNoise, count: int, interval: float) -> dict[Regime, tuple[int, int]]:
    """The two numbers of averaged samples between which a slope is taken, for each process that the law has."""
    spans: dict[Regime, tuple[int, int]] = {}
    if law.density > 0:
        spans["white"] = (1, 4)
    top = PEAK * law.instability_time / interval
    if law.instability > 0 and 2 <= top <= count / 18:
        spans["floor"] = (round(top / np.sqrt(2)), round(top * np.sqrt(2)))
    if law.random_walk > 0:
        spans["random_walk"] = (count // 96, count // 24)
    return spans


def slope_bound(law: AxisNoise, regime: Regime, count: int, interval: float, score: float = 5.0) -> float:
    """How far a slope may lie from its pure value: what the other processes add, and `score` standard deviations.

    The deviation counts the two ends as independent; overlapping averages are correlated positively, which makes it smaller.
    """
    low, high = windows(law, count, interval)[regime]
    (a, freedom_a), (b, freedom_b) = (expected_variance(law, m, count, interval) for m in (low, high))
    octave = np.log(high / low)
    mixed = abs(0.5 * np.log(b / a) / octave - SLOPE[regime])
    return float(mixed + score * np.sqrt(1 / (6 * freedom_a) + 1 / (6 * freedom_b)) / octave)


def _slope(channel: Channel, regime: Regime) -> Metric:
    def measure(run: Run) -> float:
        worst = []
        for law, noise, interval in _noise(run.scene, run.actual, channel):
            ends = windows(law, len(noise), interval).get(regime)
            if ends is not None:
                low, high = (float(overlapping_variance(noise, m).mean()) for m in ends)
                worst.append(abs(0.5 * np.log(high / low) / np.log(ends[1] / ends[0]) - SLOPE[regime]))
        if not worst:
            raise NotMeasurable(f"no law of a {channel} shows its {regime.replace('_', ' ')} within the record")
        return maximum(np.array(worst))

    return Metric(name=f"{channel}_allan_slope_{regime}_error", unit="1", source=SOURCE, measure=measure)


gyroscope_allan_score, accelerometer_allan_score = _score("gyroscope"), _score("accelerometer")
SLOPES: dict[tuple[Channel, Regime], Metric] = {
    (channel, regime): _slope(channel, regime)
    for channel in ("gyroscope", "accelerometer")
    for regime in ("white", "floor", "random_walk")
}
