"""The noise of an inertial channel alone: its readings less what the channel's own scale and triad make of the ideal signal.

Source: IEEE Std 952-1997 (scale factor, misalignment); SciPy's rotations, so that an error in ours would show.
"""

from collections.abc import Iterator

import numpy as np

from plumbline.harness.metric import NotMeasurable, Run
from plumbline.harness.scene import AxisNoise, Imu, Scene
from plumbline.harness.trajectory import Floats

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
