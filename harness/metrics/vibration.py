"""Vibration: how strongly, and how fast, the joints of a machine tremble where they should stand still.

Read from the rates of the hinges, since what a tremble lacks in angle it has in rate, and from the second half of the record,
since a machine needs time to settle. Each rate gives a power spectral density (Welch's method, Hann windows over half of that
time, a straight line taken off each so that slow drift is none).
"""

import math

import numpy as np

from harness.metric import Metric, NotMeasurable
from harness.scene import Revolute, Scene
from harness.trajectory import Floats, Trajectory
from harness.trajectory.kinematics import joint_rate

SOURCE = "Welch, IEEE Trans. Audio Electroacoust. 15 (1967) 70"
FEWEST = 16
"""Samples of the half below which a spectrum has too few lines to name a frequency."""
STILL = 1e-9
"""Below this [rad/s] a joint stands still: rounding of rates in single precision over a machine's metre."""


def _spectrum(scene: Scene, actual: Trajectory) -> tuple[Floats, Floats]:
    """Frequencies (f,) Hz and densities (f, joints) (rad/s)^2/Hz; not finite where the record is not."""
    from scipy.signal import welch  # late: a listing must not pay for it

    hinges = [joint for joint in scene.joints if isinstance(joint, Revolute)]
    if not hinges:
        raise NotMeasurable("the scene has no hinge that could tremble")
    if len(actual) < 2 * FEWEST:
        raise NotMeasurable(f"{len(actual)} samples, at least {2 * FEWEST} are needed for a spectrum")
    whole = actual.finite
    actual = actual.between(float(actual.time[0] + actual.time[-1]) / 2, math.inf)
    spacing = np.diff(actual.time)
    dt = float(spacing.mean())
    if np.abs(spacing - dt).max() > 1e-6 * dt:
        raise NotMeasurable(f"samples {spacing.min():g} to {spacing.max():g} s apart, expected them even")
    if not whole:
        return np.full(1, math.nan), np.full((1, len(hinges)), math.nan)
    rates = np.stack([joint_rate(scene, hinge, actual) for hinge in hinges], axis=1)
    spectrum = welch(rates, fs=1 / dt, window="hann", nperseg=len(rates) // 2, detrend="linear", axis=0)
    return np.asarray(spectrum[0]), np.asarray(spectrum[1])


def _rms(scene: Scene, actual: Trajectory, expected: Trajectory | None) -> float:
    frequency, density = _spectrum(scene, actual)
    if not np.isfinite(density).all():
        return math.nan
    return float(np.sqrt(density.sum(axis=0).max() * (frequency[1] - frequency[0])))


def _dominant(scene: Scene, actual: Trajectory, expected: Trajectory | None) -> float:
    frequency, density = _spectrum(scene, actual)
    if not np.isfinite(density).all():
        return math.nan
    total = density.sum(axis=1)
    return float(frequency[total.argmax()]) if total.max() * frequency[1] > STILL**2 else 0.0


VIBRATION_RMS = Metric(
    name="vibration_rms",
    unit="rad/s",
    source=f"{SOURCE}; root of the density of a hinge's rate, summed over all frequencies, worst hinge",
    measure=_rms,
)
VIBRATION_FREQUENCY = Metric(
    name="vibration_frequency",
    unit="Hz",
    source=f"{SOURCE}; where the densities of all hinges' rates, added, are greatest; 0 where all stand still",
    measure=_dominant,
)

METRIC = (VIBRATION_RMS, VIBRATION_FREQUENCY)
