"""Noise of a scanning range finder: Gaussian range noise, and beams that return nothing.

The range gets a normal deviate of standard deviation range_sigma + range_sigma_slope * range; a return stays a return whatever
its noisy range, so that the noise is not cut off at the bounds. Each beam that hit is dropped independently with the
given probability: infinite range, intensity 0.

Source: Thrun, Burgard, Fox, Probabilistic Robotics, section 6.3.1 (beam model: p_hit, and p_max for failures).
"""

import numpy as np

from harness.scene import LidarNoise
from harness.sensors.seeds import generator
from harness.trajectory import Floats

__all__ = ["noisy"]


def noisy(noise: LidarNoise, ranges: Floats, intensities: Floats, seed: int, sensor: str) -> tuple[Floats, Floats]:
    """Noisy ranges [m] and intensities [1] from ideal ones, each (scans, channels, columns)."""
    normal = generator(seed, sensor, "range").standard_normal(ranges.shape)
    uniform = generator(seed, sensor, "dropout").random(ranges.shape)
    returned = ~np.isinf(ranges)
    sigma = noise.range_sigma + noise.range_sigma_slope * np.where(returned, ranges, 0.0)
    lost = uniform < noise.dropout
    return np.where(lost, np.inf, ranges + sigma * normal), np.where(lost, 0.0, intensities)
