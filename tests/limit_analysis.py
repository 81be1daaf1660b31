"""Limit analysis of blocks in a plane: can forces that only push, within Coulomb's cones, bear their weights?

Source: Livesley, Limit analysis of structures formed from rigid blocks, Int. J. Numer. Meth. Eng. 12 (1978) 1853 (equilibrium
of blocks as a linear program); Heyman, The stone skeleton, Int. J. Solids Struct. 2 (1966) 249 (the safe theorem).
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import linprog

GROUND = -1
"""The place of what does not move."""


@dataclass(frozen=True)
class Point:
    """A point (x, z) m at which body b, a place among the blocks, stands against body a, with the normal from a to b."""

    a: int
    b: int
    at: tuple[float, float]
    normal: tuple[float, float]
    friction: float


def stands(
    centres: Sequence[Sequence[float]], masses: Sequence[float], points: Sequence[Point], tolerance: float = 1e-9
) -> bool:
    """Whether there are normal forces N >= 0 and tangential ones |T| <= mu N at the points that balance all weights.

    Args: centres of mass (n, 2), x and z [m]; masses [kg]; tolerance: of the balance, as a share of the weight of all.
    """
    where: NDArray[np.float64] = np.asarray(centres, dtype=np.float64)
    rows = np.zeros((3 * len(masses), 2 * len(points)))
    for k, point in enumerate(points):
        n = np.array(point.normal)
        for column, way in ((2 * k, n), (2 * k + 1, np.array([n[1], -n[0]]))):
            for body, sign in ((point.a, -1.0), (point.b, 1.0)):
                if body != GROUND:
                    arm = np.array(point.at) - where[body]
                    rows[3 * body : 3 * body + 2, column] += sign * way
                    rows[3 * body + 2, column] += sign * (arm[0] * way[1] - arm[1] * way[0])
    weights = np.zeros(3 * len(masses))
    weights[1::3] = np.asarray(masses) / np.sum(masses)
    cone = np.zeros((2 * len(points), 2 * len(points)))
    for k, point in enumerate(points):
        cone[2 * k, 2 * k : 2 * k + 2] = -point.friction, 1.0
        cone[2 * k + 1, 2 * k : 2 * k + 2] = -point.friction, -1.0
    # The least sum of what is left unbalanced: 0 where the blocks stand.
    left = np.hstack((rows, np.eye(len(weights)), -np.eye(len(weights))))
    price = np.concatenate((np.zeros(2 * len(points)), np.ones(2 * len(weights))))
    bounds = [bound for _ in points for bound in ((0.0, None), (None, None))] + [(0.0, None)] * (2 * len(weights))
    padded = np.hstack((cone, np.zeros((len(cone), 2 * len(weights)))))
    found = linprog(price, A_ub=padded, b_ub=np.zeros(len(cone)), A_eq=left, b_eq=weights, bounds=bounds, method="highs")
    assert found.status == 0, found.message
    return bool(found.fun < tolerance)
