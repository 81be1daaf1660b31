"""What still moves where everything should rest: jitter, and the vibration of machines.

Vibration: how strongly, and how fast, the joints of a machine tremble where they should stand still.

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

NO_BODY = "no body can move"


def _root_mean_square(vectors: Floats) -> Floats:
    """Over time: (t, n, 3) to (n,)."""
    rms: Floats = np.sqrt(np.mean(np.sum(vectors**2, axis=2), axis=0))
    return rms


@metric("m/s", empty=NO_BODY)
def rms_speed(run: Run) -> Floats:
    """root mean square of |v_WB| over the window, worst body"""
    return _root_mean_square(run.actual.v_WB[:, run.movable])


@metric("rad/s", empty=NO_BODY)
def rms_spin(run: Run) -> Floats:
    """root mean square of |w_WB| over the window, worst body"""
    return _root_mean_square(run.actual.w_WB[:, run.movable])


@metric("m", samples=3, empty=NO_BODY)
def rms_second_difference(run: Run) -> Floats:
    """root mean square of |p(t+dt) - 2 p(t) + p(t-dt)| over the window, worst body; dt^2 times an accelerometer's noise"""
    dt, spacing = run.actual.dt, np.diff(run.actual.time)
    if dt > 0 and np.any(np.abs(spacing - dt) > 1e-6 * dt):
        raise NotMeasurable(f"samples {spacing.max():g} s apart, expected one every step of {dt:g} s")
    return _root_mean_square(np.diff(run.actual.p_WB[:, run.movable], n=2, axis=0))


@metric("m", samples=2, empty=NO_BODY)
def height_spread(run: Run) -> Floats:
    """99th less 1st percentile of the height over the window, worst body"""
    span: Floats = np.ptp(np.percentile(run.actual.p_WB[:, run.movable, 2], [1, 99], axis=0), axis=0)
    return span


@metric("m", samples=2, empty=NO_BODY)
def rest_drift(run: Run) -> Floats:
    """way from the window's start to its end, worst body"""
    drift: Floats = np.linalg.norm((run.actual.p_WB[-1] - run.actual.p_WB[0])[run.movable], axis=1)
    return drift


WELCH = "Welch, IEEE Trans. Audio Electroacoust. 15 (1967) 70"
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
    late = run.actual.between(float(run.actual.time[0] + run.actual.time[-1]) / 2, math.inf)
    spacing = np.diff(late.time)
    dt = float(spacing.mean())
    if np.abs(spacing - dt).max() > 1e-6 * dt:
        raise NotMeasurable(f"samples {spacing.min():g} to {spacing.max():g} s apart, expected them even")
    rates = np.stack([joint_rate(run.scene, hinge, late) for hinge in hinges], axis=1)
    spectrum = welch(rates, fs=1 / dt, window="hann", nperseg=len(rates) // 2, detrend="linear", axis=0)
    return np.asarray(spectrum[0]), np.asarray(spectrum[1])


@metric("rad/s", WELCH, samples=2 * FEWEST)
def vibration_rms(run: Run) -> float:
    """root of the density of a hinge's rate, summed over all frequencies, worst hinge"""
    frequency, density = _spectrum(run)
    return float(np.sqrt(density.sum(axis=0).max() * (frequency[1] - frequency[0])))


@metric("Hz", WELCH, samples=2 * FEWEST)
def vibration_frequency(run: Run) -> float:
    """where the densities of all hinges' rates, added, are greatest; 0 where all stand still"""
    frequency, density = _spectrum(run)
    total = density.sum(axis=1)
    return float(frequency[total.argmax()]) if total.max() * frequency[1] > STILL**2 else 0.0
