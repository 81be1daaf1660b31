"""The digits of an inertial channel without noise: are readings the nearest levels of the askew, scaled and bounded signal?

The expected reading is made anew from the ideal signal that was recorded: SciPy's rotations turn it into the triad, levels are
counted by floor(x + 1/2), and a signal half way between two levels within a billionth may go to either.

Source: IEEE Std 1293-2018 (misalignment, scale factor, full scale, resolution); Widrow, Kollar, Quantization Noise (2008), 1.1.
"""

import numpy as np

from plumbline.harness.metric import NotMeasurable, Run, metric
from plumbline.harness.metric.series import maximum
from plumbline.harness.scene import AxisNoise, Imu
from plumbline.harness.trajectory import Floats

TIE = 1e-9
"""Distance from half way between two levels, in steps, within which roundings decide."""


def _wrong_by(law: AxisNoise, reading: Floats, ideal: Floats) -> Floats:
    """Distance (k, 3) of each reading from the level that is due, in steps of the quantisation."""
    from scipy.spatial.transform import Rotation  # late: a listing must not pay for it

    steps = (1.0 + law.scale_error) * Rotation.from_rotvec(law.misalignment).inv().apply(ideal) / law.quantisation
    level = np.floor(steps + 0.5)
    highest = np.inf if law.saturation is None else np.floor(law.saturation / law.quantisation + TIE)
    due, other = (np.clip(unclipped, -highest, highest) for unclipped in (level, 2.0 * steps - level))
    wrong = np.abs(reading / law.quantisation - due)
    tied = np.abs(np.abs(steps - np.floor(steps)) - 0.5) < TIE
    error: Floats = np.where(tied, np.minimum(wrong, np.abs(reading / law.quantisation - np.rint(other))), wrong)
    return error


@metric("1", empty="no inertial channel of the scene has digits and no noise")
def inertial_readout_error(run: Run) -> list[float]:
    """IEEE Std 1293-2018: |reading - nearest level|, in steps"""
    worst = []
    for sensor in run.scene.sensors:
        if not isinstance(sensor, Imu) or sensor.noise is None:
            continue
        for channel in ("accelerometer", "gyroscope"):
            law, name = getattr(sensor.noise, channel), f"{sensor.name}/{channel}"
            random = law.density > 0 or law.instability > 0 or law.random_walk > 0 or law.bias != 0
            if law.quantisation == 0 or random:
                continue
            if len(run.actual.streams.get(name, ())) == 0:
                raise NotMeasurable(f"stream '{name}' was not recorded")
            worst.append(maximum(_wrong_by(law, run.actual.streams[name], run.actual.streams[f"{name}_ideal"])))
    return worst
