"""A body that swings about a level hinge at the origin, along y: its poses, and its motion from rest.

Source: Landau, Lifshitz, Mechanics, 3rd ed., section 11, problem 1.
"""

import numpy as np

from plumbline.harness.trajectory import Floats
from plumbline.harness.trajectory.kinematics import about


def hanging(theta: Floats, distance: float) -> tuple[Floats, Floats]:
    """Centre of mass (..., 3) m, at a distance [m], and attitude (..., 4) at angles [rad] from hanging, towards +x."""
    p_WB = distance * np.stack([np.sin(theta), np.zeros_like(theta), -np.cos(theta)], axis=-1)
    return p_WB, about(1, -theta)


def swinging(time: Floats, rate: float, amplitude: float) -> tuple[Floats, Floats]:
    """Angle theta [rad] and theta' [rad/s] at each time [s], each (t,), released at rest at the amplitude [rad].

    sin(theta/2) = k sn(K - w0 t, k), theta' = -2 k w0 cn(K - w0 t, k), k = sin(theta0/2).

    Args: rate: w0 of small swings [rad/s].
    """
    from scipy.special import ellipj, ellipk  # late: a listing must not pay for it

    k = float(np.sin(amplitude / 2))
    sn, cn, _, _ = ellipj(ellipk(k * k) - rate * time, k * k)
    return 2.0 * np.arcsin(k * sn), -2.0 * k * rate * cn
