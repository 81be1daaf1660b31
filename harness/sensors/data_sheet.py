"""Figures of data sheets in the units of `AxisNoise`: rad/s and m/s2, densities of the two-sided spectrum N^2, Allan levels.

A level read off an Allan plot belongs to a process: white noise has sigma(t) = N/sqrt(t), a rate random walk K sqrt(t/3), the
floor is what `AxisNoise.instability` means. A 'noise density' of a sheet is mostly this N, measured as sigma(1 s) or as the
spread of samples at a rate f over sqrt(f); where the sheet means a one-sided spectrum, `two_sided` turns it into N.

Source: IEEE Std 952-1997, annex C (N, B, K and their units; one degree an hour is 4.85 urad/s); the standard acceleration of
gravity 9.80665 m/s2 (3rd CGPM, 1901).
"""

from math import log, pi, sqrt

STANDARD_GRAVITY = 9.80665
"""[m/s2]"""
HOUR = 3600.0


def from_deg_per_second(value: float) -> float:
    """[rad/s] from deg/s; likewise [rad/s/sqrt(Hz)] from deg/s/sqrt(Hz)."""
    return value * pi / 180.0


def from_deg_per_hour(value: float) -> float:
    """Bias or instability [rad/s] from deg/h."""
    return from_deg_per_second(value) / HOUR


def from_deg_per_root_hour(value: float) -> float:
    """Density [rad/s/sqrt(Hz)] from an angle random walk in deg/sqrt(h): 1 deg/sqrt(h) is 1/60 deg/s/sqrt(Hz)."""
    return from_deg_per_second(value) / sqrt(HOUR)


def from_deg_per_hour_per_root_hour(value: float) -> float:
    """Random walk [rad/s/s/sqrt(Hz)] from a rate random walk in deg/h/sqrt(h)."""
    return from_deg_per_hour(value) / sqrt(HOUR)


def from_metre_per_second_per_root_hour(value: float) -> float:
    """Density [m/s2/sqrt(Hz)] from a velocity random walk in m/s/sqrt(h)."""
    return value / sqrt(HOUR)


def from_g(value: float) -> float:
    """[m/s2] from g."""
    return value * STANDARD_GRAVITY


def from_mg(value: float) -> float:
    """Bias or instability [m/s2] from thousandths of g; likewise densities from mg/sqrt(Hz)."""
    return from_g(value * 1e-3)


def from_ug(value: float) -> float:
    """Density [m/s2/sqrt(Hz)] from ug/sqrt(Hz); likewise [m/s2] from ug."""
    return from_g(value * 1e-6)


def two_sided(density: float) -> float:
    """The density N of samples with the spread N sqrt(f) from one whose square is a one-sided spectrum: 1/sqrt(2) of it."""
    return density / sqrt(2.0)


def density_from_spread(spread: float, rate: float) -> float:
    """Density [u/sqrt(Hz)] from the standard deviation [u] of white samples at `rate` [Hz]."""
    return spread / sqrt(rate)


def density_from_allan(level: float, tau: float = 1.0) -> float:
    """Density [u/sqrt(Hz)] from the Allan deviation [u] on the slope -1/2 at `tau` [s]: N = sigma sqrt(tau)."""
    return level * sqrt(tau)


def random_walk_from_allan(level: float, tau: float = 3.0) -> float:
    """Random walk [u/s/sqrt(Hz)] from the Allan deviation [u] on the slope +1/2 at `tau` [s]: K = sigma sqrt(3/tau)."""
    return level * sqrt(3.0 / tau)


def floor_from_coefficient(coefficient: float) -> float:
    """Floor [u] of the Allan deviation from the coefficient B of flicker noise: sqrt(2 ln 2/pi) B, about 0.664 B."""
    return coefficient * sqrt(2.0 * log(2.0) / pi)


def quantisation_from_bits(full_scale: float, bits: int) -> float:
    """Distance of neighbouring readings [u] where -full_scale..full_scale [u] is told in `bits` bits."""
    return 2.0 * full_scale / 2.0**bits
