"""Noise of a depth camera: the spread of its depth errors against the depth, and pixels that got lost."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from harness.readings.channel import Channel
from harness.readings.noise import Noise, lost_share, spread, spread_interval
from harness.scene import DepthCamera, DepthNoise
from harness.trajectory import Floats

__all__ = ["Levels", "depth_levels", "depth_noise"]

BINS, LEAST = 16, 50
"""Stretches of depth of equally many pixels, and the fewest pixels of one."""


@dataclass(frozen=True, slots=True)
class Levels:
    """Spread of depth over depth: mean depth (k,) m of each stretch, standard deviation found (k,) m with its 95 % interval, and
    by law (k,) m."""

    depth: Floats
    sigma: Floats
    low: Floats
    high: Floats
    law: Floats


def _law_of(channel: Channel) -> DepthNoise | None:
    return channel.sensor.noise if isinstance(channel.sensor, DepthCamera) else None


def _sigma(law: DepthNoise, depth: Floats) -> Floats:
    sigma: Floats = law.sigma + law.sigma_square * np.square(depth)
    return sigma


def _clear(channel: Channel, law: DepthNoise) -> NDArray[np.bool_]:
    """Pixels that the noise cannot have carried out of the camera's bounds, which would leave a part of the law only."""
    assert isinstance(channel.sensor, DepthCamera)
    depth = np.where(np.isfinite(channel.ideal), channel.ideal, np.nan)
    margin = 5.0 * _sigma(law, depth)
    mask: NDArray[np.bool_] = (depth - margin > channel.sensor.near) & (depth + margin < channel.sensor.far)
    return mask


def _deviations(channel: Channel, law: DepthNoise) -> tuple[Floats, Floats]:
    """Depths (n,) m and errors (n,) m of the pixels that can be told."""
    kept = _clear(channel, law) & np.isfinite(channel.read)
    return channel.ideal[kept], channel.read[kept] - channel.ideal[kept]


def depth_levels(channel: Channel) -> Levels | None:
    """Of a channel with noise; None without, or with too few pixels."""
    law = _law_of(channel)
    if law is None or law.sigma == law.sigma_square == 0:
        return None
    depth, error = _deviations(channel, law)
    count = min(BINS, len(depth) // LEAST)
    if count == 0:
        return None
    order = np.argsort(depth, kind="stable")
    found = []
    for part in np.array_split(order, count):
        sigma = float(np.sqrt(np.mean(np.square(error[part]))))
        by_law = float(np.sqrt(np.mean(np.square(_sigma(law, depth[part])))))
        found.append((float(depth[part].mean()), sigma, *spread_interval(sigma, len(part)), by_law))
    return Levels(*np.array(found).T)


def depth_noise(channel: Channel) -> Noise | None:
    """What is found of the noise; None without a law."""
    law = _law_of(channel)
    if law is None:
        return None
    told = f"normal, sigma {law.sigma:.3g} m + {law.sigma_square:.3g} z^2/m; missing {law.missing:.3g}"
    clear = _clear(channel, law)
    lost = lost_share(int(np.isnan(channel.read[clear]).sum()), int(clear.sum()), law.missing)
    depth, error = _deviations(channel, law)
    if len(error) < 2:
        return Noise(law=told, why="no pixel lies well within the camera's bounds", **lost)
    return Noise(law=told, count=len(error), **spread(error, _sigma(law, depth)), **lost)
