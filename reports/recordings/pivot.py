"""The point of a body that stays where it is, as the tip of a top does: told of it, a pose over time is an attitude alone."""

from dataclasses import dataclass

import numpy as np

from reports.recordings.rotation import Floats, rotate

__all__ = ["ROUNDING", "Pivot", "pivot_of"]

ROUNDING = 2.0**-24
"""Half a unit in the last place of single precision, which recordings are written in."""


@dataclass(frozen=True, slots=True)
class Pivot:
    """A point P that a body turns about. Terms: p_WP (3,) m: where it is. p_BP (3,) m: the same point in the body."""

    p_WP: Floats
    p_BP: Floats


def pivot_of(p_WB: Floats, q_WB: Floats) -> Pivot | None:
    """The point about which a body at places p_WB (t, 3) m with attitudes q_WB (t, 4) turns; None where there is none.

    p_WB + R_WB p_BP = p_WP at all instants. With the means over them taken off, that is an equation for p_BP alone, solved by
    least squares; of an axis that stays, it gives the point next to the body's origin. What is found is a pivot if the place of
    the body put together again from single precision is the one that was given, but for roundings: one of p_WP, one of p_BP,
    and two of the attitude (a quaternion says half of an angle), of numbers no larger than the body's own coordinates.
    """
    turned = np.stack([rotate(q_WB, np.broadcast_to(axis, p_WB.shape)) for axis in np.eye(3)], axis=-1)
    swing, way = turned - turned.mean(axis=0), p_WB - p_WB.mean(axis=0)
    # Three equations in the mean, not three an instant: the rounding of their squares lies far below that of single precision.
    square, pull = np.einsum("tij,tik->jk", swing, swing), -np.einsum("tij,ti->j", swing, way)
    p_BP = np.linalg.lstsq(square, pull, rcond=1e-12)[0]
    p_WP = (p_WB + turned @ p_BP).mean(axis=0)
    again = single(p_WP) - rotate(single(q_WB), np.broadcast_to(single(p_BP), p_WB.shape))
    off, size = np.abs(again - p_WB).max(), np.abs(p_WB).max()
    return Pivot(p_WP, p_BP) if off <= 4 * ROUNDING * size else None


def single(values: Floats) -> Floats:
    """The numbers as single precision has them."""
    return values.astype(np.float32).astype(np.float64)
