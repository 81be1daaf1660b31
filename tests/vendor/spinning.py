"""A plate that spins freely about no principal axis, a top in steady precession, a gimbal: numbers for vendors' scripts."""

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

__all__ = [
    "G",
    "GIMBAL_TILT",
    "MOMENTS",
    "PLATE",
    "RATES",
    "RINGS",
    "SPIN",
    "STEM",
    "TILT",
    "TOP",
    "UNIT",
    "WHEEL",
    "centre",
    "gimbal_energy",
    "momentum_off",
    "precession",
    "top_rate",
]

Floats = NDArray[np.float64]
G = 9.81

PLATE = 0.03
"""Mass [kg] of a plate of 60 x 40 x 10 mm."""
_SQUARES = np.square([0.03, 0.02, 0.005])
MOMENTS: Floats = (_SQUARES.sum() - _SQUARES) * PLATE / 3
"""Of the plate [kg m2], ascending."""
UNIT: Floats = np.array([0.8, 0.1, 0.59]) / np.linalg.norm([0.8, 0.1, 0.59])
"""The axis of its spin in its own frame."""


def momentum_off(R_WB: Floats, w_W: Floats, speed: float) -> float:
    """How far its angular momentum is from that of the start at `speed` [rad/s], as a share of it."""
    start = MOMENTS * UNIT * speed
    return float(np.linalg.norm(R_WB @ (MOMENTS * (R_WB.T @ w_W)) - start) / np.linalg.norm(start))


STEM, TILT = 0.1, math.radians(30)
"""A disc of 1 kg and 0.1 m radius on a massless stem [m], leaning [rad from upright]."""
TOP: tuple[float, float, float] = (0.1**2 / 4, 0.1**2 / 4, 0.1**2 / 2)
"""Its moments about its centre [kg m2]."""


def precession(spin: float) -> float:
    """The slower steady precession [rad/s]: I1 cos(theta) W^2 - I3 w3 W + m g l = 0 (Goldstein, section 5.7)."""
    a, b, c = (TOP[0] + STEM**2) * math.cos(TILT), TOP[2] * spin, G * STEM
    return 2 * c / (b + math.sqrt(b * b - 4 * a * c))


def top_rate(spin: float) -> Floats:
    """Its angular velocity [rad/s] at the start, in W."""
    rate = precession(spin)
    return (spin - rate * math.cos(TILT)) * np.array([math.sin(TILT), 0.0, math.cos(TILT)]) + np.array([0.0, 0.0, rate])


def centre(spin: float, time: float) -> Floats:
    """Where its centre [m] is."""
    azimuth = precession(spin) * time
    level = math.sin(TILT)
    return STEM * np.array([level * math.cos(azimuth), level * math.sin(azimuth), math.cos(TILT)])


SPIN = 150.0
"""Of the wheel of a gimbal [rad/s], about an axis that leans by GIMBAL_TILT [rad] from the upright."""
GIMBAL_TILT = 0.3
RINGS: tuple[tuple[float, float, float], tuple[float, float, float]] = ((5.76e-4, 2.88e-4, 2.88e-4), (1.5e-4, 3e-4, 1.5e-4))
"""Moments [kg m2] of a ring that turns about x of the world, and of one that turns in it about its y."""
WHEEL: tuple[float, float, float] = (0.5e-3, 0.5e-3, 1e-3)
"""Moments of a disc that turns about z of the inner ring."""
RATES = (1.0, 0.5, SPIN)
"""Of the three hinges at the start [rad/s]."""


def gimbal_energy(turns: Sequence[Floats], rates: Sequence[Floats]) -> float:
    """The energy [J] of outer ring, inner ring and wheel by their rotation matrices and angular velocities in W."""
    return sum(
        float(np.array(moments) @ np.square(R.T @ w)) / 2 for moments, R, w in zip((*RINGS, WHEEL), turns, rates, strict=True)
    )
