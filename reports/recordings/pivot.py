"""The point of a body that stays where it is, as the tip of a top does: told of it, a pose over time is an attitude alone."""

import math
from dataclasses import dataclass

import numpy as np

from plumbline.reports.recordings.rotation import Floats, rotate

ROUNDING = 2.0**-24
"""Half a unit in the last place of single precision, which recordings are written in."""

FAR = 2.0
"""No pivot and no arm is longer than this many times the body's own largest distance from the origin: the difference of two
large numbers would shake in single precision."""

SOUGHT = 32
"""Instants that a pivot is sought at; all of them say whether it is one."""


@dataclass(frozen=True, slots=True)
class Pivot:
    """A point P that a body turns about. Terms: p_WP (3,) m: where it is. p_BP (3,) m: the same point in the body."""

    p_WP: Floats
    p_BP: Floats


def pivot_of(p_WB: Floats, q_WB: Floats) -> Pivot | None:
    """The point about which a body at places p_WB (t, 3) m with attitudes q_WB (t, 4) turns; None where there is none.

    p_WB + R_WB p_BP = p_WP at all instants. With the means over some of them taken off, that is an equation for p_BP alone,
    solved by least squares; of an axis that stays, it gives the point next to the body's origin. What is found is a pivot if
    the place of the body put together again from single precision is everywhere the one that was given, but for roundings of
    the larger of both points' distances: one of p_WP, one of p_BP and two of the attitude (a quaternion says half of an angle).
    """
    reach = FAR * float(np.linalg.norm(p_WB, axis=1).max())
    if _outruns(p_WB, q_WB, reach):
        return None
    some = np.unique(np.linspace(0, len(p_WB) - 1, SOUGHT).astype(np.int64))
    near = p_WB[some]
    turned = rotate(q_WB[some][:, None], np.eye(3)).swapaxes(1, 2)
    swing, way = turned - turned.mean(axis=0), near - near.mean(axis=0)
    p_BP = np.linalg.lstsq(swing.reshape(-1, 3), -way.reshape(-1), rcond=1e-6)[0]
    p_WP = (near + turned @ p_BP).mean(axis=0)
    size = max(float(np.linalg.norm(p_WP)), float(np.linalg.norm(p_BP)))
    allowed = 4 * ROUNDING * size
    if size > reach or np.abs(near + turned @ p_BP - p_WP).max() > allowed:
        return None
    again = single(p_WP) - rotate(single(q_WB), single(p_BP))
    return Pivot(p_WP, p_BP) if np.abs(again - p_WB).max() <= allowed else None


def _outruns(p_WB: Floats, q_WB: Floats, reach: float) -> bool:
    """Does a body go farther between its first instant and its last than an arm of length `reach` [m] carries it as it turns?

    Turned by an angle a, such an arm has a chord of 2 sin(a/2) of its length, and cos(a/2) is the product of both quaternions.
    Most bodies that fly, fall or slide turn so little that nothing else needs to be asked. A pivot may be off by four roundings
    at either end, and the attitudes as recordings have them by as many.
    """
    half_cosine = min(1.0, abs(float(q_WB[0] @ q_WB[-1])))
    chord = 2.0 * math.sqrt(1.0 - half_cosine**2) * reach
    return float(np.linalg.norm(p_WB[-1] - p_WB[0])) > chord + 16 * ROUNDING * reach


def single(values: Floats) -> Floats:
    """The numbers as single precision has them."""
    return values.astype(np.float32).astype(np.float64)
