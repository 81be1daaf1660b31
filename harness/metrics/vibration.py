"""Vibration: how strongly, and how fast, the joints of a machine tremble where they should stand still.

Read from the rates of the hinges, since what a tremble lacks in angle it has in rate, and from the second half of the record,
since a machine needs time to settle. Each rate gives a power spectral density (Welch's method, Hann windows over half of that
time, a straight line taken off each so that slow drift is none).
"""

import math

import numpy as np

from plumbline.harness.metric import NotMeasurable, Run, metric
from plumbline.harness.scene import Revolute
from plumbline.harness.trajectory import Floats
from plumbline.harness.trajectory.kinematics import joint_rate

SOURCE = "Welch, IEEE Trans. Audio Electroacoust. 15 (1967) 70"
FEWEST = 16
"""Samples of the half below which a spectrum has too few lines to name a frequency."""
STILL = 1e-9
"""Below this [rad/s] a joint stands still: rounding of rates in single precision over a machine's metre."""


def _spectrum(run: Run) -> tuple[Floats, Floats]:
    """Frequencies (f,) Hz and densities (f, joints) (rad/s)^2/Hz."""
    from scipy.signal import welch  # late: a listing must not pay for it

    hinges = [joint for joint in run.scene.joints if isinstance(joint, Revolute)]
    if not hinges:
        raise NotMeasurable("the scene has no hinge that could tremble")
    if len(run.actual) < 2 * FEWEST:
        raise NotMeasurable(f"{len(run.actual)} samples, at least {2 * FEWEST} are needed for a spectrum")
    late = run.actual.between(float(run.actual.time[0] + run.actual.time[-1]) / 2, math.inf)
    spacing = np.diff(late.time)
    dt = float(spacing.mean())
    if np.abs(spacing - dt).max() > 1e-6 * dt:
        raise NotMeasurable(f"samples {spacing.min():g} to {spacing.max():g} s apart, expected them even")
    rates = np.stack([joint_rate(run.scene, hinge, late) for hinge in hinges], axis=1)
    spectrum = welch(rates, fs=1 / dt, window="hann", nperseg=len(rates) // 2, detrend="linear", axis=0)
    return np.asarray(spectrum[0]), np.asarray(spectrum[1])


@metric("rad/s", SOURCE)
def vibration_rms(run: Run) -> float:
    """root of the density of a hinge's rate, summed over all frequencies, worst hinge"""
    frequency, density = _spectrum(run)
    return float(np.sqrt(density.sum(axis=0).max() * (frequency[1] - frequency[0])))


@metric("Hz", SOURCE)
def vibration_frequency(run: Run) -> float:
    """where the densities of all hinges' rates, added, are greatest; 0 where all stand still"""
    frequency, density = _spectrum(run)
    total = density.sum(axis=1)
    return float(frequency[total.argmax()]) if total.max() * frequency[1] > STILL**2 else 0.0
