"""A body that swings about a level hinge at the origin, along y: its poses, and its motion from rest.

Source: Landau, Lifshitz, Mechanics, 3rd ed., section 11, problem 1.

Two equal rods on hinges, the upper one on the world: Lagrange's equations, and where the rods then are.

Source: Landau, Lifshitz, Mechanics, 3rd ed., section 5, problem 1, for rods.
"""

import numpy as np

from plumbline.harness.scene import EARTH_GRAVITY, box_inertia
from plumbline.harness.trajectory import Floats, Trajectory
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


G = -EARTH_GRAVITY[2]
LENGTH, MASS, THICKNESS = 0.5, 1.0, 0.025
D = LENGTH / 2
"""From a hinge to a rod's centre of mass [m]."""
INERTIA = box_inertia(MASS, (THICKNESS, THICKNESS, LENGTH / 2))[1][1]


def poses(theta: Floats) -> tuple[Floats, Floats]:
    """Centres of mass (..., 2, 3) m and attitudes (..., 2, 4) at the rods' angles (..., 2) rad from the downward vertical."""
    zero = np.zeros_like(theta)
    along = np.stack([np.sin(theta), zero, -np.cos(theta)], axis=-1)
    p_WB = D * along
    p_WB[..., 1, :] += LENGTH * along[..., 0, :]
    return p_WB, np.stack([np.cos(theta / 2), zero, -np.sin(theta / 2), zero], axis=-1)


def acceleration(theta: Floats, rate: Floats) -> Floats:
    """theta'' (2, ...) rad/s2 of Lagrange's equations for angles and rates (2, ...), angles counted from the vertical.

    (I + m d^2 + m L^2) a1 + m L d cos(D) a2 = -m L d sin(D) w2^2 - (m d + m L) g sin(theta1), D = theta1 - theta2
    m L d cos(D) a1 + (I + m d^2) a2 = +m L d sin(D) w1^2 - m d g sin(theta2)
    """
    difference = theta[0] - theta[1]
    coupling = MASS * LENGTH * D
    own = INERTIA + MASS * D * D
    a, b, c = own + MASS * LENGTH**2, coupling * np.cos(difference), own
    turn = coupling * np.sin(difference)
    first = -turn * rate[1] ** 2 - MASS * (D + LENGTH) * G * np.sin(theta[0])
    second = turn * rate[0] ** 2 - MASS * D * G * np.sin(theta[1])
    accelerations: Floats = np.array([c * first - b * second, a * second - b * first]) / (a * c - b * b)
    return accelerations


def placed(time: Floats, y: Floats) -> Trajectory:
    """The two rods at angles and rates (t, 4)."""
    truth = Trajectory.of(time, 2)
    theta, rate = y[:, :2], y[:, 2:]
    truth.p_WB[:], truth.q_WB[:] = poses(theta)
    truth.w_WB[:, :, 1] = -rate
    around = np.stack([np.cos(theta), np.zeros_like(theta), np.sin(theta)], axis=-1)
    truth.v_WB[:] = D * rate[..., None] * around
    truth.v_WB[:, 1] += LENGTH * rate[:, :1] * around[:, 0]
    return truth
