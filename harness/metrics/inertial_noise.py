"""Noise of inertial sensors against its law.

Bias of inertial noise: the mean of its beginning against the constant of its law, in standard deviations of that mean.

A random walk soon hides a constant, so the mean is taken over as many first samples as make its variance smallest:
sigma^2/n for white noise, the sum of memory^|i-j| for a Markov process, K^2 dt (n+1)(2n+1)/(6n) for a walk from zero.

Distribution of inertial noise against the normal one of its law: Kolmogorov's distance, and chi-squared of a histogram.

Every second difference of samples is taken: with white noise and a random walk these are independent normal variables of the
variance 2 N^2/T + K^2 T. A Markov process would correlate them, so that a law that has one is not measured.

Source: Kolmogorov (1933), sqrt(n) D; Pearson (1900), with cells of equal probability (Mann, Wald, On the choice of the number
of class intervals, 1942) and Wilson and Hilferty's cube root, which makes a chi-squared variable normal.

Independence of inertial noise: the largest correlation between any two axes, channels and sensors, as a normal score.

Correlations are those of the samples' differences, which are stationary whatever walks. Differences of white noise have
the autocorrelation -1/2 at lag 1, which makes the variance of a correlation of two independent ones (1 + 2/4)/n (Bartlett).
Samples are compared by the number of their draw, over the length that both have: all pairs of axes of one rate.

Spectrum of inertial noise against its law, by Welch's method: the level of each octave of frequency as a normal score.

The samples' differences are taken, which are stationary whatever walks: with z = exp(-i w T), density N, walk K and a Markov
process of variance s^2 and memory m a step, their two-sided spectrum a sample is
|1 - z|^2 (N^2/T + s^2 (1 - m^2)/|1 - m z|^2) + K^2 T. The mean over the bins of an octave of its ratio to the estimate, over K
segments that do not overlap, has the variance 1.944/(K bins): a Hann window correlates the power of neighbouring bins by
(2/3)^2 and of next ones by (1/6)^2. The lowest two bins, into which the window's own width leaks, are left out.

Source: Welch, The use of fast Fourier transform for the estimation of power spectra (1967); Percival, Walden, Spectral Analysis
for Physical Applications (1993), section 6.3 (window correlations); IEEE Std 952-1997, annex C (spectra of the processes).

Allan deviation of inertial noise against its law: levels as confidence scores, and the slopes -1/2, 0 and +1/2.

The overlapping Allan variance is a quadratic form of a Gaussian process whose law is known, so that its mean and its variance
follow exactly from the spectrum; with these two it is compared with a chi-squared variable, and the probability is given as a
normal score. The score is the largest over three axes and all octaves of averaging time up to a ninth of the record.

Source: IEEE Std 952-1997, annex C; Riley, Handbook of Frequency Stability Analysis (NIST SP 1065), sections 5.2.4 and 5.3.
"""

import itertools
from functools import lru_cache
from typing import Literal

import numpy as np

from plumbline.harness.metric import Metric, NotMeasurable, Run, metric
from plumbline.harness.metric.noise_scores import cube_root_score, inertial_residual, kolmogorov_distance, noisy_channels
from plumbline.harness.scene import AxisNoise
from plumbline.harness.trajectory import Floats

NO_NOISE = "no inertial sensor of the scene has random noise"
MARKOV_PEAK = 0.617364
"""Largest Allan deviation of a Gauss-Markov process over its standard deviation (IEEE Std 952, annex C)."""


def variance_of_mean(law: AxisNoise, count: Floats, interval: float) -> Floats:
    """Variance of the mean of the first `count` samples, for each count, in the unit squared."""
    n = np.asarray(count, dtype=np.float64)
    memory = np.exp(-interval / law.instability_time)
    markov = (n * (1 - memory**2) - 2 * memory * (1 - memory**n)) / (1 - memory) ** 2 / n**2
    walk = interval * (n + 1) * (2 * n + 1) / (6 * n)
    white = law.density**2 / interval / n
    variance: Floats = white + (law.instability / MARKOV_PEAK) ** 2 * markov + law.random_walk**2 * walk
    return variance


@metric("1", empty="no inertial sensor of the scene has noise")
def inertial_bias_score(run: Run) -> list[float]:
    """definition: |mean - bias| over its standard deviation"""
    scores = []
    for sensor, channel, law in noisy_channels(run.scene):
        noise = inertial_residual(sensor, channel, run)
        variances = variance_of_mean(law, np.arange(1.0, len(noise) + 1.0), 1.0 / sensor.rate)
        count = int(np.argmin(variances)) + 1
        # A law without randomness leaves the rounding of the signal, which enters when noise and signal are parted again.
        rounding = 4 * np.finfo(np.float64).eps * (1 + np.abs(run.stream(f"{sensor.name}/{channel}")).max())
        scores.append(np.abs(noise[:count].mean(axis=0) - law.bias) / (np.sqrt(variances[count - 1]) + rounding))
    return scores


CELLS = 64
FEWEST = 20 * CELLS
"""Samples below which a cell's count is no normal variable."""


def histogram_score(deviations: Floats) -> float:
    """Pearson's chi-squared over cells of equal probability as a normal score, of (n,); NaN where one is."""
    from scipy.special import ndtri  # late: a listing must not pay for it

    if np.isnan(deviations).any():
        return float("nan")
    edges = ndtri(np.arange(1, CELLS) / CELLS)
    counts = np.bincount(np.searchsorted(edges, deviations), minlength=CELLS)
    mean = len(deviations) / CELLS
    freedom = CELLS - 1
    # Counts that are more even than chance allows are as wrong as uneven ones.
    return cube_root_score(float(np.sum(np.square(counts - mean))) / mean / freedom, freedom)


def _deviations(run: Run) -> list[Floats]:
    """Of each noisy axis, (n,)."""
    deviations: list[Floats] = []
    for sensor, channel, law in noisy_channels(run.scene):
        variance = 2 * law.density**2 * sensor.rate + law.random_walk**2 / sensor.rate
        if variance == 0 and law.instability == 0:
            continue
        if law.instability > 0:
            raise NotMeasurable(f"the {channel} of sensor '{sensor.name}' has bias instability, whose samples are correlated")
        change = np.diff(inertial_residual(sensor, channel, run), axis=0)[::2]
        if len(change) < FEWEST:
            raise NotMeasurable(f"stream '{sensor.name}/{channel}' has {len(change)} differences, {FEWEST} are needed")
        deviations.extend((change / np.sqrt(variance)).T)
    return deviations


@metric("1", empty=NO_NOISE)
def inertial_distribution_distance(run: Run) -> list[float]:
    """Kolmogorov (1933): sqrt(n) D"""
    return [kolmogorov_distance(deviation) for deviation in _deviations(run)]


@metric("1", empty=NO_NOISE)
def inertial_histogram_score(run: Run) -> list[float]:
    """Pearson (1900); Mann, Wald (1942)"""
    return [histogram_score(deviation) for deviation in _deviations(run)]


@metric("1", empty="fewer than two noisy axes of one rate with at least 31 samples")
def inertial_correlation_score(run: Run) -> list[float]:
    """Bartlett, Some aspects of the time-correlation problem (1935)"""
    columns: list[tuple[float, Floats]] = []
    for sensor, channel, law in noisy_channels(run.scene):
        noise = inertial_residual(sensor, channel, run)
        if law.density > 0 or law.instability > 0 or law.random_walk > 0:
            columns.extend((sensor.rate, column) for column in np.diff(noise, axis=0).T)
    scores = []
    for (rate_a, a), (rate_b, b) in itertools.combinations(columns, 2):
        # Generators that share a seed agree draw by draw, whenever the readings come: a late sensor has fewer of them.
        count = min(len(a), len(b))
        if rate_a == rate_b and count >= 30:
            scores.append(abs(np.corrcoef(a[:count], b[:count])[0, 1]) * np.sqrt(count / 1.5))
    return scores


SEGMENT = 256
"""Differences a segment."""
LOWEST = 2
CORRELATED = 1.0 + 2.0 * (2 / 3) ** 2 + 2.0 * (1 / 6) ** 2


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


@metric("1", empty=NO_NOISE)
def inertial_spectrum_score(run: Run) -> list[float]:
    """Welch (1967); IEEE Std 952-1997, annex C"""
    scores = []
    for sensor, channel, law in noisy_channels(run.scene):
        if law.density == law.instability == law.random_walk == 0:
            continue
        noise = inertial_residual(sensor, channel, run)
        if len(noise) <= 8 * SEGMENT:
            raise NotMeasurable(
                f"stream '{sensor.name}/{channel}' has {len(noise)} samples, more than {8 * SEGMENT} are needed"
            )
        scores += _scores(law, noise, 1.0 / sensor.rate).tolist()
    return scores


Channel = Literal["gyroscope", "accelerometer"]
Regime = Literal["white", "floor", "random_walk"]
ALLAN_SOURCE = "IEEE Std 952-1997, annex C; overlapping estimator: NIST SP 1065, section 5.2.4"
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


def _noise(run: Run, channel: Channel) -> list[tuple[AxisNoise, Floats, float]]:
    """Law, noise (n, 3) and interval [s] of each inertial sensor that has a law."""
    noises = []
    for sensor, name, law in noisy_channels(run.scene):
        if name == channel and (law.density > 0 or law.instability > 0 or law.random_walk > 0):
            noise = inertial_residual(sensor, channel, run)
            if len(noise) < 96:
                raise NotMeasurable(f"stream '{sensor.name}/{channel}' has {len(noise)} samples, at least 96 are needed")
            noises.append((law, noise, 1.0 / sensor.rate))
    if not noises:
        raise NotMeasurable(f"no sensor of the scene has a noisy {channel}")
    return noises


def _score(channel: Channel) -> Metric:
    def measure(run: Run) -> list[float]:
        from scipy.special import chdtr, chdtrc, ndtri  # late: a listing must not pay for it

        scores = []
        for law, noise, interval in _noise(run, channel):
            total = _sums(noise)
            for m in octaves(len(noise)):
                mean, freedom = expected_variance(law, m, len(noise), interval)
                level = freedom * _of_sums(total, m) / mean
                tail = np.minimum(chdtrc(freedom, level), chdtr(freedom, level))
                scores += np.minimum(np.abs(ndtri(np.minimum(tail, 0.5))), SHARPEST).tolist()
        return scores

    return Metric(name=f"{channel}_allan_score", unit="1", source=ALLAN_SOURCE, measure=measure)


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
    def measure(run: Run) -> list[float]:
        worst = []
        for law, noise, interval in _noise(run, channel):
            ends = windows(law, len(noise), interval).get(regime)
            if ends is not None:
                low, high = (float(overlapping_variance(noise, m).mean()) for m in ends)
                worst.append(abs(0.5 * np.log(high / low) / np.log(ends[1] / ends[0]) - SLOPE[regime]))
        return worst

    name, empty = f"{channel}_allan_slope_{regime}_error", f"no law of a {channel} shows its {regime} within the record"
    return Metric(name=name, unit="1", source=ALLAN_SOURCE, measure=measure, empty=empty)


gyroscope_allan_score, accelerometer_allan_score = _score("gyroscope"), _score("accelerometer")
SLOPES: dict[tuple[Channel, Regime], Metric] = {
    (channel, regime): _slope(channel, regime)
    for channel in ("gyroscope", "accelerometer")
    for regime in ("white", "floor", "random_walk")
}
