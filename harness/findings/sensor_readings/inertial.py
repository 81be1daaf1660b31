"""Noise of an inertial channel: its Allan deviation against that of its law, its spread from reading to reading, its bias.

Where the law also turns or stretches the signal, so is the ideal signal before it is taken off: a triad turned by a rotation
reads the inverse rotation of a vector, and the scale error stretches what it reads.

Source: IEEE Std 952-1997, annex C; see `harness.metrics.inertial_noise`.
"""

from typing import Any

import numpy as np

from plumbline.harness.findings.sensor_readings.channel import Channel, Noise, NoiseCurve, spread_interval
from plumbline.harness.metrics.inertial_noise import expected_variance, octaves, overlapping_variance, variance_of_mean, windows
from plumbline.harness.scene import AxisNoise, Imu
from plumbline.harness.statistics.interval import Interval
from plumbline.harness.statistics.percentiles import chi_squared_percentile
from plumbline.harness.statistics.student import Z_95
from plumbline.harness.trajectory import Floats

LEAST = 96
"""Readings below which no Allan deviation is taken: ten octaves less than two would be left."""


def _law_of(channel: Channel) -> AxisNoise | None:
    if not isinstance(channel.sensor, Imu) or channel.sensor.noise is None:
        return None
    law: AxisNoise = getattr(channel.sensor.noise, channel.channel)
    return None if law == AxisNoise() else law


def _noise(channel: Channel, law: AxisNoise) -> Floats:
    """What was read beyond the ideal signal as the law's own triad and scale have it, (k, 3)."""
    from scipy.spatial.transform import Rotation  # another route than the one by which readings are made

    turned: Floats = Rotation.from_rotvec(law.misalignment).inv().apply(channel.ideal)
    rest: Floats = channel.read - (1.0 + law.scale_error) * turned
    return rest


def _random(law: AxisNoise) -> bool:
    return law.density > 0 or law.instability > 0 or law.random_walk > 0


def allan_curve(channel: Channel) -> NoiseCurve | None:
    """Of the noise of a channel over octaves, a mean square over the axes; None without a law, or where too little was read."""
    law = _law_of(channel)
    if law is None or not _random(law) or len(channel.read) < LEAST or _clipped(channel, law) > 0:
        return None
    assert isinstance(channel.sensor, Imu)
    interval, noise = 1.0 / channel.sensor.rate, _noise(channel, law)
    counts = octaves(len(noise))
    deviations = np.array([np.sqrt(np.mean(overlapping_variance(noise, m))) for m in counts])
    expected = [expected_variance(law, m, len(noise), interval) for m in counts]
    by_law = np.sqrt([mean for mean, _ in expected])
    freedom = noise.shape[1] * np.array([degrees for _, degrees in expected])
    low, high = (by_law * np.sqrt(chi_squared_percentile(p, freedom) / freedom) for p in (0.025, 0.975))
    return NoiseCurve(interval * np.array(counts, dtype=np.float64), deviations, by_law, low, high)


def _clipped(channel: Channel, law: AxisNoise) -> float:
    """The share of readings that ended at the law's bound."""
    if law.saturation is None:
        return 0.0
    return float(np.mean(np.abs(channel.read) >= law.saturation * (1 - 1e-12)))


def inertial_noise(channel: Channel) -> Noise | None:
    """What is found of the noise; None without a law."""
    law = _law_of(channel)
    if law is None:
        return None
    law_words = _words(law, channel.unit)
    if len(channel.read) < LEAST:
        return Noise(law=law_words, why=f"{len(channel.read)} readings, at least {LEAST} are needed")
    if (clipped := _clipped(channel, law)) > 0:
        return Noise(
            law=law_words, why=f"{100 * clipped:.3g} % of the readings end at the bound of {law.saturation:g} {channel.unit}"
        )
    assert isinstance(channel.sensor, Imu)
    noise, interval = _noise(channel, law), 1.0 / channel.sensor.rate
    fields = _bias(noise, law, interval)
    if not _random(law):
        return Noise(law=law_words, count=noise.size, **fields)
    variance, freedom = expected_variance(law, 1, len(noise), interval)
    sigma = spread_interval(float(np.sqrt(np.mean(overlapping_variance(noise, 1)))), noise.shape[1] * freedom)
    fields |= {"sigma": sigma, "sigma_law": float(np.sqrt(variance + law.quantisation**2 / 12))}
    return Noise(law=law_words, count=noise.size, **fields, **_levels(noise, law, interval))


def _bias(noise: Floats, law: AxisNoise, interval: float) -> dict[str, Any]:
    """From as many first readings as tell it best, since a walk soon hides a constant."""
    variances = variance_of_mean(law, np.arange(1.0, len(noise) + 1.0), interval)
    count = int(np.argmin(variances)) + 1
    mean = float(noise[:count].mean())
    width = Z_95 * float(np.sqrt(variances[count - 1] / noise.shape[1]))
    return {"bias": Interval(mean, mean - width, mean + width), "bias_law": law.bias}


def _levels(noise: Floats, law: AxisNoise, interval: float) -> dict[str, Any]:
    """Allan deviation over the law's in the middle of each process's own stretch."""
    ratios = {}
    for regime, ends in windows(law, len(noise), interval).items():
        m = max(1, round(float(np.sqrt(ends[0] * ends[1]))))
        expected = expected_variance(law, m, len(noise), interval)[0]
        ratios[regime.removeprefix("random_")] = float(np.sqrt(np.mean(overlapping_variance(noise, m)) / expected))
    return ratios


def _words(law: AxisNoise, unit: str) -> str:
    parts = [
        (any(law.misalignment), f"misalignment {np.linalg.norm(law.misalignment):.3g} rad"),
        (law.scale_error != 0, f"scale error {law.scale_error:.3g}"),
        (law.density > 0, f"white {law.density:.3g} {unit}/sqrt(Hz)"),
        (law.bias != 0, f"bias {law.bias:.3g} {unit}"),
        (law.instability > 0, f"instability {law.instability:.3g} {unit} over {law.instability_time:.3g} s"),
        (law.random_walk > 0, f"walk {law.random_walk:.3g} {unit}/s/sqrt(Hz)"),
        (law.saturation is not None, f"bound {law.saturation or 0:.4g} {unit}"),
        (law.quantisation > 0, f"step {law.quantisation:.3g} {unit}"),
    ]
    return ", ".join(words for there, words in parts if there)
