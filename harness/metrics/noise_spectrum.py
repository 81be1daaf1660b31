"""Spectrum of inertial noise against its law, by Welch's method: the level of each octave of frequency as a normal score.

The samples' differences are taken, which are stationary whatever walks: with z = exp(-i w T), density N, walk K and a Markov
process of variance s^2 and memory m a step, their two-sided spectrum a sample is
|1 - z|^2 (N^2/T + s^2 (1 - m^2)/|1 - m z|^2) + K^2 T. The mean over the bins of an octave of its ratio to the estimate, over K
segments that do not overlap, has the variance 1.944/(K bins): a Hann window correlates the power of neighbouring bins by
(2/3)^2 and of next ones by (1/6)^2. The lowest two bins, into which the window's own width leaks, are left out.

Source: Welch, The use of fast Fourier transform for the estimation of power spectra (1967); Percival, Walden, Spectral Analysis
for Physical Applications (1993), section 6.3 (window correlations); IEEE Std 952-1997, annex C (spectra of the processes).
"""

import numpy as np

from plumbline.harness.metric import NotMeasurable, Run, metric
from plumbline.harness.metric.inertial_residual import inertial_residual
from plumbline.harness.scene import AxisNoise, Imu
from plumbline.harness.trajectory import Floats

SEGMENT = 256
"""Differences a segment."""
LOWEST = 2
CORRELATED = 1.0 + 2.0 * (2 / 3) ** 2 + 2.0 * (1 / 6) ** 2
MARKOV_PEAK = 0.617364
"""Largest Allan deviation of a Gauss-Markov process over its standard deviation (IEEE Std 952, annex C)."""


def difference_spectrum(law: AxisNoise, turn: Floats, interval: float) -> Floats:
    """Two-sided spectrum [u^2 a sample] of the differences of consecutive samples, at the angles w T = `turn` [rad]."""
    memory = np.exp(-interval / law.instability_time)
    markov = (law.instability / MARKOV_PEAK) ** 2 * (1 - memory**2) / (1 - 2 * memory * np.cos(turn) + memory**2)
    spectrum: Floats = 2 * (1 - np.cos(turn)) * (law.density**2 / interval + markov) + law.random_walk**2 * interval
    return spectrum


def _scores(law: AxisNoise, noise: Floats, interval: float) -> Floats:
    """One for each octave and axis."""
    from scipy.signal import welch  # late: a listing must not pay for it

    change = np.diff(noise, axis=0)
    segments = len(change) // SEGMENT
    cycles, power = welch(
        change[: segments * SEGMENT], window="hann", nperseg=SEGMENT, noverlap=0, detrend=False, axis=0, return_onesided=True
    )
    # The last bin, half the sampling rate, stands alone and is real: it is left to the others.
    bins = np.arange(LOWEST, SEGMENT // 2)
    ratio = 0.5 * power[bins] / difference_spectrum(law, 2 * np.pi * cycles[bins], interval)[:, None]
    octave = np.floor(np.log2(bins)).astype(int)
    scores = []
    for number in np.unique(octave):
        inside = ratio[octave == number]
        # A mean of few exponential variables is chi-squared, which Wilson and Hilferty's cube root makes normal.
        spread = 2.0 / (9.0 * segments * len(inside) / CORRELATED * 2.0)
        scores.append(np.abs(inside.mean(axis=0) ** (1 / 3) - (1 - spread)) / np.sqrt(spread))
    return np.concatenate(scores)


@metric("1")
def inertial_spectrum_score(run: Run) -> Floats:
    """Welch (1967); IEEE Std 952-1997, annex C"""
    scores = []
    for sensor in run.scene.sensors:
        if not isinstance(sensor, Imu) or sensor.noise is None:
            continue
        for channel in ("accelerometer", "gyroscope"):
            law: AxisNoise = getattr(sensor.noise, channel)
            if law.density == law.instability == law.random_walk == 0:
                continue
            noise = inertial_residual(sensor, channel, run.actual)
            if len(noise) <= 8 * SEGMENT:
                raise NotMeasurable(
                    f"stream '{sensor.name}/{channel}' has {len(noise)} samples, more than {8 * SEGMENT} are needed"
                )
            scores.append(_scores(law, noise, 1.0 / sensor.rate))
    if not scores:
        raise NotMeasurable("no inertial sensor of the scene has random noise")
    return np.concatenate(scores)


"""Of six axes and seven octaves the largest."""
