"""The Pareto front of error and cost: which answers no other beats, and what a wanted error costs between two of them."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

__all__ = ["near_front", "on_front", "price"]

Floats = NDArray[np.float64]
Flags = NDArray[np.bool_]
STEEPEST = 8.5
"""The order of convergence above which an error jumps rather than converges: half an order above the highest that an integrator
here promises, the eighth of the reference engine's splitting."""


def near_front(error: Sequence[float], cost: Sequence[float], factor: float = 1.0) -> Flags:
    """Which points no other makes superfluous: one that errs no more and is cheaper by more than `factor`.

    Args: error, cost: shape (n,), positive and finite. factor: at least 1.
    Returns: shape (n,).
    """
    errors, costs = np.asarray(error, dtype=np.float64), np.asarray(cost, dtype=np.float64)
    no_worse = errors[None, :] <= errors[:, None]
    cheaper = costs[None, :] * factor < costs[:, None]
    return np.asarray(~np.any(no_worse & cheaper, axis=1), dtype=np.bool_)


def on_front(error: Sequence[float], cost: Sequence[float]) -> Flags:
    """Which points no other beats in one of error and cost while being no worse in the other; of equal points the first.

    Args: error, cost: shape (n,), positive and finite.
    Returns: shape (n,).
    """
    front = np.zeros(len(error), dtype=np.bool_)
    least = np.inf
    for k in sorted(range(len(error)), key=lambda k: (cost[k], error[k])):
        if error[k] < least:
            front[k], least = True, error[k]
    return front


def price(error: Floats, cost: Floats, target: Floats) -> Floats:
    """What errors cost under settings that differ in the time step alone: the logarithm of the cost is linear in the error's.

    A target that the cheapest answer already meets costs what that one does; nan where none is as accurate. Where the error
    falls more steeply than any order would have it (a wall holds from some step on), nothing is known of what lies between:
    the finer step is the price.

    Args: error, cost: shape (n,), n >= 1, positive; in any order. target: shape (t,).
    Returns: shape (t,), in the unit of the cost.
    """
    up = np.argsort(error, kind="stable")
    # Where the more accurate is the cheaper, it serves the coarser target as well.
    errors, costs, targets = np.log(error[up]), np.log(np.minimum.accumulate(cost[up])), np.log(target)
    interpolated = np.interp(targets, errors, costs, left=np.nan)
    jumps = np.append(np.diff(errors) > STEEPEST * -np.diff(costs), False)
    finer = np.searchsorted(errors, targets, side="right") - 1
    known: Floats = np.exp(np.where((finer >= 0) & jumps[finer], costs[finer], interpolated))
    return known
