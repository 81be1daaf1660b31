"""Noise of a range finder: spread, mean and distribution of its range errors, the spread of intensities, lost returns."""

import numpy as np
from numpy.typing import NDArray

from plumbline.harness.findings.sensor_readings.channel import Channel
from plumbline.harness.findings.sensor_readings.noise import Noise, NoiseCurve, lost_share, spread
from plumbline.harness.scene import Lidar, LidarNoise
from plumbline.harness.trajectory import Floats

EDGES = np.linspace(-4.0, 4.0, 33)
"""Of a histogram, in standard deviations of the law."""
CLEAR = 4.0
"""An intensity so many standard deviations above 0 is not cut off there by its noise."""


def _law_of(channel: Channel) -> LidarNoise | None:
    return channel.sensor.noise if isinstance(channel.sensor, Lidar) else None


def _heard(channel: Channel) -> NDArray[np.bool_]:
    """Beams that hit and returned."""
    mask: NDArray[np.bool_] = ~np.isinf(channel.read) & ~np.isinf(channel.ideal)
    return mask


def _sigma(law: LidarNoise, ranges: Floats) -> Floats:
    sigma: Floats = law.range_sigma + law.range_sigma_slope * ranges
    return sigma


def range_histogram(channel: Channel) -> NoiseCurve | None:
    """Of a range channel with noise; None without, or with fewer than a hundred returns."""
    from scipy import stats  # late: a listing must not pay for it

    law = _law_of(channel)
    if law is None or channel.channel != "range" or law.range_sigma == law.range_sigma_slope == 0:
        return None
    heard = _heard(channel)
    normalised = (channel.read[heard] - channel.ideal[heard]) / _sigma(law, channel.ideal[heard])
    if len(normalised) < 100 or np.isnan(normalised).any():
        return None
    width = EDGES[1] - EDGES[0]
    share = np.diff(stats.norm.cdf(EDGES))
    low, high = (stats.binom.ppf(p, len(normalised), share) / (len(normalised) * width) for p in (0.025, 0.975))
    counts = np.histogram(normalised, EDGES)[0]
    middle = 0.5 * (EDGES[1:] + EDGES[:-1])
    return NoiseCurve(
        middle,
        counts / (len(normalised) * width),
        share / width,
        low,
        high,
        len(normalised),
        len(normalised) - int(counts.sum()),
    )


def ranging_noise(channel: Channel) -> Noise | None:
    """What is found of the noise of ranges or of intensities; None without a law."""
    law = _law_of(channel)
    if law is None:
        return None
    heard = _heard(channel)
    if channel.channel == "intensity":
        if law.intensity_sigma == 0:
            return None
        law_words = f"normal, sigma {law.intensity_sigma:.3g}"
        ranges = channel.beside.get("range")
        hit = np.ones(heard.shape, dtype=np.bool_) if ranges is None else np.isfinite(ranges[0])
        clear = hit & (channel.read > 0) & (channel.ideal > CLEAR * law.intensity_sigma)
        if clear.sum() < 2:
            return Noise(law=law_words, why=f"no intensity stands {CLEAR:g} sigma above 0, where noise is cut off")
        deviation = channel.read[clear] - channel.ideal[clear]
        return Noise(law=law_words, count=len(deviation), **spread(deviation, np.full(len(deviation), law.intensity_sigma)))
    law_words = f"normal, sigma {law.range_sigma:.3g} m + {law.range_sigma_slope:.3g} r; dropout {law.dropout:.3g}"
    if law.least_intensity > 0:
        law_words += f"; nothing below intensity {law.least_intensity:.3g}"
    hit = np.isfinite(channel.ideal)
    bright = channel.beside.get("intensity")
    if law.least_intensity > 0 and bright is not None:
        # What is too dark to be heard is no dropout.
        hit &= ~(bright[0] < law.least_intensity)
    lost = lost_share(int(np.sum(~np.isfinite(channel.read[hit]))), int(hit.sum()), law.dropout)
    if heard.sum() < 2:
        return Noise(law=law_words, why="no beam returned", **lost)
    deviation = channel.read[heard] - channel.ideal[heard]
    return Noise(law=law_words, count=len(deviation), **spread(deviation, _sigma(law, channel.ideal[heard])), **lost)
