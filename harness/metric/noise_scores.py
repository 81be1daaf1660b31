"""Scores of noise against its law, of deviations (n,) that are independent standard normal variables where the law holds.

Each score is of the order of 1 then.

The noise of an inertial channel alone: its readings less what the channel's own scale and triad make of the ideal signal.

Source: IEEE Std 952-1997 (scale factor, misalignment); SciPy's rotations, so that an error in ours would show.
"""

from collections.abc import Iterator

import numpy as np

from plumbline.harness.metric import NotMeasurable, Run
from plumbline.harness.scene import AxisNoise, Imu, Scene
from plumbline.harness.trajectory import Floats


def mean_score(deviations: Floats) -> float:
    """The mean over its standard error."""
    return float(abs(deviations.mean()) * np.sqrt(len(deviations)))


def cube_root_score(level: float, freedom: float) -> float:
    """A chi-squared variable over its degrees of freedom: Wilson and Hilferty's cube root makes it normal."""
    third = 2.0 / (9.0 * freedom)
    return float(abs(level ** (1 / 3) - (1 - third)) / np.sqrt(third))


def spread_score(deviations: Floats) -> float:
    """The mean square, to one part in n."""
    return cube_root_score(float(np.mean(np.square(deviations))), len(deviations))


def kolmogorov_distance(deviations: Floats) -> float:
    """sqrt(n) D from the standard normal distribution; NaN where a deviation is."""
    from scipy.special import ndtr  # late: a listing must not pay for it

    if np.isnan(deviations).any():
        return float("nan")
    below, ranks = ndtr(np.sort(deviations)), np.arange(len(deviations) + 1) / len(deviations)
    return float(max(np.max(ranks[1:] - below), np.max(below - ranks[:-1])) * np.sqrt(len(deviations)))


def neighbour_scores(deviation: Floats, least: int) -> list[float]:
    """Correlations of neighbours along each axis of (a, b, c) deviations, infinite where there is none, of at least so many
    pairs: the mean product of deviations is 1/sqrt(n) wide."""
    scores = []
    for axis in range(3):
        count = deviation.shape[axis]
        a, b = (deviation.take(np.arange(start, count - 1 + start), axis=axis).ravel() for start in (0, 1))
        both = ~np.isinf(a) & ~np.isinf(b)
        if both.sum() >= least:
            scores.append(float(abs(np.mean(a[both] * b[both])) * np.sqrt(both.sum())))
    return scores


def share_score(share: float, law: float, count: int) -> float:
    """A share of `count` against its law's, in the standard deviations that the law gives it.

    A score below z says that Wilson's interval for confidence z, drawn about the observed share, holds the law's.
    """
    width = float(np.sqrt(law * (1 - law) / count))
    return abs(share - law) / width if width > 0 else (0.0 if share == law else float("inf"))


SHARE = 1e-2
"""What the rounding of readings, q^2/12, may be of the variance of the white noise before it counts as a law of its own [1]."""


def noisy_channels(scene: Scene) -> Iterator[tuple[Imu, str, AxisNoise]]:
    """The inertial sensors that have a law of noise: each with the name and the law of both its channels."""
    for sensor in scene.sensors:
        if isinstance(sensor, Imu) and sensor.noise is not None:
            yield sensor, "accelerometer", sensor.noise.accelerometer
            yield sensor, "gyroscope", sensor.noise.gyroscope


def inertial_residual(sensor: Imu, channel: str, run: Run) -> Floats:
    """Reading less the ideal one as this channel senses it, (k, 3) in the channel's unit; the noise's bias stays in.

    Raises:
        NotMeasurable: no such stream, or readings at their bound or too coarse to show the noise.
    """
    from scipy.spatial.transform import Rotation  # late: a listing must not pay for it

    law: AxisNoise = AxisNoise() if sensor.noise is None else getattr(sensor.noise, channel)
    name = f"{sensor.name}/{channel}"
    reading, signal = run.stream(name), run.stream(f"{name}_ideal")
    if law.saturation is not None and np.abs(reading).max() >= law.saturation - law.quantisation:
        raise NotMeasurable(f"stream '{name}' is cut off at {law.saturation:g}, which hides its noise")
    if law.quantisation**2 / 12 > SHARE * law.density**2 * sensor.rate:
        raise NotMeasurable(f"stream '{name}' is read in steps of {law.quantisation:g}, which hides its noise")
    if any(law.misalignment):
        signal = Rotation.from_rotvec(law.misalignment).inv().apply(signal)
    return reading - (1.0 + law.scale_error) * signal
