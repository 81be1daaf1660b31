"""Noise of an inertial channel: white noise, constant bias, bias instability and rate random walk.

Conventions: densities are those of IEEE Std 952, whose two-sided spectrum of white noise is N^2, so that samples at a rate f
have the standard deviation N sqrt(f) and the Allan deviation is N / sqrt(tau). Bias instability is a first-order Gauss-Markov
process of the given correlation time, so strong that the maximum of its Allan deviation is the given floor. The random walk
starts from zero and gives the Allan deviation K sqrt(tau / 3).

Source: IEEE Std 952-1997, annex C: angle random walk, bias instability, rate random walk and Markov noise.
"""

import numpy as np

from plumbline.harness.scene import AxisNoise
from plumbline.harness.sensors.seeds import generator
from plumbline.harness.trajectory import Floats

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
