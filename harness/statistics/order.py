"""The order of convergence of an error that shrinks with the time step, with its interval and its floor; promises of one."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache, lru_cache

import numpy as np

from plumbline.harness.statistics.student import percentile

FEWEST = 3
"""Points on the slope: two give a line without an interval."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Order:
    """error = C dt^order above the floor.

    Terms:
        order [1], with its 95 % interval low..high. used: points on the slope. floor: the error below which smaller steps no
        longer help, in the error's unit; None where the ladder did not reach it. coarse, fine [s]: the steps of the slope.
        at_fine_end: the slope over its three finest points alone. left: the floor over the largest error, 0 without a floor.
    """

    order: float
    low: float
    high: float
    used: int
    floor: float | None
    coarse: float
    fine: float
    at_fine_end: float
    left: float


def falls_short(fit: Order, promised: float) -> bool:
    """Is a promise of an order broken?

    Orders of smooth motion are whole numbers. The promise is broken where the whole interval lies nearer to a lower one, under
    promised - 1/2, and the slope over the three finest points does too. An order above the promise never breaks it. Nor does a
    ladder that only begins coarsely, where higher powers of the step still count, nor one on which the error passes through
    zero: there the scatter widens the interval, or the fine end recovers. Where noise alone decides, the interval lies under
    the promise in one of forty ladders; the half order and the fine end make that fewer.

    A floor is no broken promise, unless it is so high that more than half of the largest error is left.
    """
    return (fit.high < promised - 0.5 and fit.at_fine_end < promised - 0.5) or fit.left > 0.5


def fit_order(dt: Sequence[float], error: Sequence[float]) -> Order | None:
    """Fit log(error) = log(C) + order log(dt) over the coarse end of the ladder, and a constant floor over the rest.

    Where the floor begins is chosen by the Bayesian information criterion among all splits, none included; the line and the
    floor share one variance of the logarithm, and a floor has two points at least. The interval is Student's t on the slope
    with (points - 2) degrees of freedom. Zeros and numbers that are not finite are left out, since they have no logarithm.

    Args:
        dt: time steps [s], shape (n,), in any order.
        error: errors, shape (n,), in one unit.

    Returns:
        The fit, or None with fewer than three distinct steps on the slope.

    Source:
        W. L. Oberkampf & C. J. Roy, Verification and Validation in Scientific Computing (2010), ch. 8 (observed order);
        N. R. Draper & H. Smith, Applied Regression Analysis (3rd ed., 1998), sec. 1.4 (interval of a slope);
        G. Schwarz, Annals of Statistics 6 (1978) 461 (the criterion).
    """
    return _fitted(tuple(map(float, dt)), tuple(map(float, error)))


@lru_cache(maxsize=4096)
def _fitted(dt: tuple[float, ...], error: tuple[float, ...]) -> Order | None:
    """As `fit_order`, once: a report asks for the order of the same ladder for each target that it foresees."""
    steps, errors = np.asarray(dt, dtype=np.float64), np.asarray(error, dtype=np.float64)
    keep = np.isfinite(steps) & np.isfinite(errors) & (steps > 0) & (errors > 0)
    down = np.argsort(-steps[keep], kind="stable")
    x, y = np.log(steps[keep][down]), np.log(errors[keep][down])
    n = len(x)
    distinct = np.cumsum(np.diff(x, prepend=np.inf) != 0.0)
    splits = [k for k in range(FEWEST, n + 1) if k != n - 1 and distinct[k - 1] >= FEWEST]  # one point is no floor
    if not splits:
        return None
    best = min(splits, key=lambda k: criterion(x, y, k))
    slope, spread = _line(x[:best], y[:best])
    half = spread * _student(best - 2)
    return Order(
        order=slope,
        low=slope - half,
        high=slope + half,
        used=best,
        floor=float(np.exp(np.mean(y[best:]))) if best < n else None,
        coarse=float(np.exp(x[0])),
        fine=float(np.exp(x[best - 1])),
        at_fine_end=_line(x[best - FEWEST : best], y[best - FEWEST : best])[0],
        left=float(np.exp(np.mean(y[best:]) - y.max())) if best < n else 0.0,
    )


@cache
def _student(freedom: int) -> float:
    """The 97.5th percentile of Student's t: half of a 95 % interval in standard errors."""
    return percentile(0.975, freedom)


def _line(x: np.ndarray, y: np.ndarray) -> tuple[float, float]:
    """Slope of the line of least squares through three points or more, and its standard error.

    The arithmetic is that of `scipy.stats.linregress`, whose test of the slope against 0, which nobody asks for, takes longer
    than all the rest, and of `numpy.cov`, which asks more of its arguments than it computes.
    """
    both = np.array((x, y))
    both -= np.add.reduce(both, axis=1, keepdims=True) / len(x)
    (xx, xy), (_, yy) = np.dot(both, both.T) * (1 / len(x))
    if yy == 0.0 or np.ptp(y) == 0.0:  # equal errors have a slope of zero, exactly
        return float(xy / xx), 0.0
    r = min(1.0, max(-1.0, float(xy / np.sqrt(xx * yy))))
    return float(xy / xx), float(np.sqrt((1 - r**2) * yy / xx / (len(x) - 2)))


def _off_mean(values: np.ndarray) -> np.ndarray:
    """What is left without the mean; for the few numbers of a ladder `mean` takes longer than the sum."""
    left: np.ndarray = values - np.add.reduce(values) / len(values)
    return left


def criterion(x: np.ndarray, y: np.ndarray, k: int) -> float:
    """Schwarz's criterion of a line through the first k points and a constant through the others; the lower, the better."""
    n = len(x)
    across, up = _off_mean(x[:k]), _off_mean(y[:k])
    off_line = up - across * (np.dot(across, up) / np.dot(across, across))
    squares = float(np.dot(off_line, off_line)) + (float(np.add.reduce(_off_mean(y[k:]) ** 2)) if k < n else 0.0)
    # A spread below one per cent of the error is not told from none: without this, two exact points outbid any slope.
    variance = max(squares / n, 1e-4)
    unknowns = 2 + (2 if k < n else 0)  # slope and height; height and place of the floor
    return n * float(np.log(variance)) + unknowns * float(np.log(n))


BLOCKS = 20
"""Means that a long series is cut into: neighbours of a swing are no independent points, twenty long stretches nearly are."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Slope:
    """A trend. Terms: slope with its 95 % interval low..high, per second. swing: of the whole series about the line, largest
    less smallest. secular: does the interval leave out 0, and the trend change the series by more than it swings?"""

    slope: float
    low: float
    high: float
    swing: float
    secular: bool


def fit_slope(time: Sequence[float], value: Sequence[float]) -> Slope | None:
    """A straight line through the means of `BLOCKS` stretches of equal length; None where there are too few samples.

    A bounded oscillation has a slope too, whatever its length; it counts as secular only where what it adds up to over the run
    is more than the oscillation, and its interval by Student's t, with BLOCKS - 2 degrees of freedom, leaves out zero.

    Args:
        time: instants [s], shape (n,), rising. value: shape (n,), finite.

    Source:
        N. R. Draper & H. Smith, Applied Regression Analysis (3rd ed., 1998), sec. 1.4; H. Flyvbjerg & H. G. Petersen, J. Chem.
        Phys. 91 (1989) 461 (block means of correlated series).
    """
    t, y = np.asarray(time, dtype=np.float64), np.asarray(value, dtype=np.float64)
    if len(t) < 2 * BLOCKS:
        return None
    x = np.array([block.mean() for block in np.array_split(t, BLOCKS)])
    means = np.array([block.mean() for block in np.array_split(y, BLOCKS)])
    slope, spread = _line(x, means)
    half = spread * _student(BLOCKS - 2)
    swing = float(np.ptp(y - slope * t))
    far = abs(slope) * float(t[-1] - t[0])
    return Slope(slope=slope, low=slope - half, high=slope + half, swing=swing, secular=abs(slope) > half and far > swing)
