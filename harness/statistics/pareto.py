"""The Pareto front of error and cost: which answers no other beats, and what a wanted error costs between two of them."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

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
    known: Floats = prices_of_draws(error[None, :], cost[None, :], target)[0]
    return known


def prices_of_draws(error: Floats, cost: Floats, target: Floats) -> Floats:
    """As `price`, for many draws of the errors and costs of the same settings at once.

    Args: error, cost: shape (d, n), n >= 1, positive; in any order. target: shape (t,). Returns: shape (d, t).
    """
    up = np.argsort(error, axis=1, kind="stable")
    # Where the more accurate is the cheaper, it serves the coarser target as well.
    cheapest = np.minimum.accumulate(np.take_along_axis(cost, up, axis=1), axis=1)
    errors, costs, targets = np.log(np.take_along_axis(error, up, axis=1)), np.log(cheapest), np.log(target)
    jumps = np.zeros(errors.shape, dtype=np.bool_)
    jumps[:, :-1] = np.diff(errors, axis=1) > STEEPEST * -np.diff(costs, axis=1)
    finer = (errors[:, :, None] <= targets).sum(axis=1) - 1
    last = np.maximum(finer, 0)
    steep = (finer >= 0) & np.take_along_axis(jumps, last, axis=1)
    at_finer = np.take_along_axis(costs, last, axis=1)
    known: Floats = np.exp(np.where(steep, at_finer, _interpolated(errors, costs, targets, finer)))
    return known


def _interpolated(x: Floats, y: Floats, at: Floats, before: NDArray[np.int64]) -> Floats:
    """`numpy.interp(at, x[k], y[k], left=nan)` of every row k at once, by the same arithmetic.

    Args: x, y: shape (d, n), x rising in each row. at: shape (t,). before: the last place with x <= at, -1 before the first;
    shape (d, t). Returns: shape (d, t).
    """
    left = np.clip(before, 0, max(x.shape[1] - 2, 0))
    right = np.minimum(left + 1, x.shape[1] - 1)
    x0, x1, y0, y1 = (np.take_along_axis(values, places, axis=1) for values in (x, y) for places in (left, right))
    with np.errstate(divide="ignore", invalid="ignore"):  # two points of one error are never interpolated between
        between = (y1 - y0) / (x1 - x0) * (at - x0) + y0
    end = y[:, -1:]
    line = np.where(before >= x.shape[1] - 1, end, np.where(x0 == at, y0, between))
    return np.where(before < 0, np.nan, line)
