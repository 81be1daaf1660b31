"""Noise of a depth camera: the spread of its depth errors against the depth, and pixels that got lost.

By its law a depth z errs with the standard deviation sigma + sigma_square z^2 where the law says so itself; z^2 sigma_d/(f b)
where a disparity errs by sigma_d pixels at a focal length of f pixels and a baseline of b metres (a disparity in steps of q
adds q^2/12 to its variance); (sigma + slope r) z/r where a range r = z/cos errs.

Source: Khoshelham, Elberink, Accuracy and resolution of Kinect depth data, Sensors 12 (2012) 1437, eq. 10; Widrow, Kollar,
Quantization Noise (2008), chapter 4 (a step's uniform error).
"""

import math
from collections.abc import Mapping
from dataclasses import asdict
from typing import Any

import numpy as np
from numpy.typing import NDArray

from plumbline.harness.findings.sensor_readings.channel import Channel, Noise, NoiseCurve, lost_share, spread, spread_interval
from plumbline.harness.scene import DepthCamera, Lidar, LidarNoise
from plumbline.harness.statistics.percentiles import binomial_percentile
from plumbline.harness.trajectory import Floats

BINS, LEAST = 16, 50
"""Stretches of depth of equally many pixels, and the fewest pixels of one."""
CAUSES = ("occlusion", "shadow", "least_texture", "least_signal", "least_contrast")
"""Words of a law by which pixels are lost for a reason and not by chance."""
UNTOLD = ("shot_sigma", "multipath")
"""Words of a law whose part in the spread hangs on more than the depth."""

Law = Mapping[str, Any]


def _law_of(channel: Channel) -> Law | None:
    sensor = channel.sensor
    if not isinstance(sensor, DepthCamera) or sensor.noise is None or channel.channel != "depth":
        return None
    return asdict(sensor.noise)


def depth_sigma(camera: DepthCamera, law: Law, depth: Floats) -> Floats | None:
    """Standard deviation [m] of each pixel of depth (k, h, w) m by law; None where the depth alone does not tell it."""
    if any(law.get(word) for word in UNTOLD):
        return None
    if "disparity_sigma" in law:
        match_sigma = math.hypot(law["disparity_sigma"], law.get("disparity_step", 0.0) / math.sqrt(12.0))
        by_disparity: Floats = np.square(depth) * match_sigma / (camera.focal_x * law["baseline"])
        return by_disparity
    if "range_sigma" in law:
        longer = _longer(camera)
        by_range: Floats = (law["range_sigma"] + law.get("range_sigma_slope", 0.0) * depth * longer) / longer
        return by_range
    if "sigma" in law:
        by_depth: Floats = law["sigma"] + law.get("sigma_square", 0.0) * np.square(depth)
        return by_depth
    return None


def _longer(camera: DepthCamera) -> Floats:
    """Range over depth of each pixel, (h, w)."""
    x = (np.arange(camera.width) + 0.5 - camera.centre_x) / camera.focal_x
    y = (np.arange(camera.height) + 0.5 - camera.centre_y) / camera.focal_y
    longer: Floats = np.sqrt(1.0 + np.square(x)[None, :] + np.square(y)[:, None])
    return longer


def _clear(channel: Channel, law: Law, sigma: Floats | None) -> NDArray[np.bool_]:
    """Pixels whose noise the camera's bounds cannot have touched, nor carried over the range at which phases start anew."""
    camera = channel.sensor
    assert isinstance(camera, DepthCamera)
    margin = 0.0 if sigma is None else 5.0 * sigma
    depth = np.where(np.isfinite(channel.ideal), channel.ideal, np.nan)
    mask: NDArray[np.bool_] = (depth - margin > camera.near) & (depth + margin < camera.far)
    if law.get("unambiguous_range"):
        mask &= (depth + margin) * _longer(camera) < law["unambiguous_range"]
    if channel.excused is not None:
        mask &= channel.excused == 0
    return mask


def _told(channel: Channel, law: Law) -> tuple[Floats | None, NDArray[np.bool_]]:
    """The predicted sigma of each pixel, and a mask of the valid ones."""
    assert isinstance(channel.sensor, DepthCamera)
    depth = np.where(np.isfinite(channel.ideal), channel.ideal, np.nan)
    sigma = depth_sigma(channel.sensor, law, depth)
    return sigma, _clear(channel, law, sigma)


def depth_levels(channel: Channel) -> NoiseCurve | None:
    """The spread of depth over the mean depth of each stretch, of a channel with noise.

    None without, where the law leaves more than the depth to ask for, or with too few pixels.
    """
    law = _law_of(channel)
    if law is None:
        return None
    sigma, clear = _told(channel, law)
    kept = clear & np.isfinite(channel.read)
    count = min(BINS, int(kept.sum()) // LEAST)
    if sigma is None or count == 0 or not sigma[kept].any():
        return None
    depth, error, by_law = channel.ideal[kept], channel.read[kept] - channel.ideal[kept], sigma[kept]
    order = np.argsort(depth, kind="stable")
    levels = []
    for pixels in np.array_split(order, count):
        spread_found = float(np.sqrt(np.mean(np.square(error[pixels]))))
        expected = float(np.sqrt(np.mean(np.square(by_law[pixels]))))
        sigma_found, low, high = spread_interval(spread_found, len(pixels))
        levels.append((float(depth[pixels].mean()), sigma_found, expected, low, high))
    return NoiseCurve(*np.array(levels).T)


def depth_noise(channel: Channel) -> Noise | None:
    """What is found of the noise; None without a law."""
    law = _law_of(channel)
    if law is None:
        return None
    law_words = _words(law)
    sigma, clear = _told(channel, law)
    lost = lost_share(int(np.isnan(channel.read[clear]).sum()), int(clear.sum()), float(law.get("missing", 0.0)))
    caused = any(law.get(word) for word in CAUSES) or law.get("steepest", math.inf) < math.pi / 2
    if caused and channel.excused is None:
        lost.pop("lost_law", None)
    kept = clear & np.isfinite(channel.read)
    if kept.sum() < 2:
        return Noise(law=law_words, why="no pixel lies well within the camera's bounds", **lost)
    error = channel.read[kept] - channel.ideal[kept]
    if sigma is None:
        return Noise(law=law_words, count=len(error), why="the law's spread hangs on more than the depth", **lost)
    if not sigma[kept].any():
        return Noise(law=law_words, count=len(error), **lost)
    return Noise(law=law_words, count=len(error), **spread(error, sigma[kept]), **lost)


def _words(law: Law) -> str:
    terms = [f"{name.replace('_', ' ')} {value:.3g}" for name, value in law.items() if isinstance(value, float) and value]
    kind = str(law.get("type", "normal")).replace("_", " ")
    return ", ".join([kind, *terms])


EDGES = np.linspace(-4.0, 4.0, 33)
"""Of a histogram, in standard deviations of the law."""
CLEAR = 4.0
"""An intensity so many standard deviations above 0 is not cut off there by its noise."""


def _lidar_law(channel: Channel) -> LidarNoise | None:
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
    from scipy.special import ndtr  # late: a listing must not pay for it

    law = _lidar_law(channel)
    if law is None or channel.channel != "range" or law.range_sigma == law.range_sigma_slope == 0:
        return None
    heard = _heard(channel)
    normalised = (channel.read[heard] - channel.ideal[heard]) / _sigma(law, channel.ideal[heard])
    if len(normalised) < 100 or np.isnan(normalised).any():
        return None
    width = EDGES[1] - EDGES[0]
    share = np.diff(ndtr(EDGES))
    low, high = (binomial_percentile(p, len(normalised), share) / (len(normalised) * width) for p in (0.025, 0.975))
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
    law = _lidar_law(channel)
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
