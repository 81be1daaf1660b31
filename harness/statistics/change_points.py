"""Change points: the nights from which on a series lies on another level."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

__all__ = ["ChangePoint", "change_points"]


@dataclass(frozen=True, slots=True, kw_only=True)
class ChangePoint:
    """Terms: index: the first value on the new level. ratio: new level over old. p_value: how often chance alone does as much."""

    index: int
    ratio: float
    p_value: float


def change_points(series: NDArray[np.float64], segments: NDArray[np.int64] | None = None) -> tuple[ChangePoint, ...]:
    """The change points of a series, shape (n,), positive, one value a night, NaN for a night without one; in order.

    Args: segments (n,): nights of different numbers (another version, another machine) are never compared; one for all if None.
    """
    raise NotImplementedError
