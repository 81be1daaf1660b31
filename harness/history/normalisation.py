"""What prices of a night are divided by: how far the night moved the other engines, or the canary where there are too few.

Each other engine has one vote, the common motion of its series, and the canary another. The median of the votes is free of one
engine that changed, however many series it has, but as noisy as a vote; the mean of the engines' votes is not, where none is
counted for more than three median departures from that median.
"""

import warnings
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from plumbline.harness.findings.changes.values import Beside
from plumbline.harness.statistics.change_points import common_mode
from plumbline.harness.trajectory import Floats

FEWEST = 2
"""Other engines: with the canary three votes, of which one may be wrong."""
CLIP = 3.0
"""A vote further from the middle than so many median departures is not counted."""


def yardsticks(
    values: Floats,
    segments: NDArray[np.int64],
    engines: Sequence[str],
    canaries: Floats,
    canary: Floats,
    hosts: NDArray[np.int64],
) -> list[tuple[Floats, Beside]]:
    """For each price series its divisor (n,), and what that is.

    Args: values, segments (s, n). engines: of each series. canaries (s, n) [s]: clocked beside it.
    canary (n,) [s]: of each night. hosts (n,): its machine, as a number.
    """
    steady = [over_segments(row, numbers) for row, numbers in zip(values, segments, strict=True)]
    votes = {
        name: _moved(np.array([row for row, engine in zip(steady, engines, strict=True) if engine == name]))
        for name in dict.fromkeys(engines)
    }
    kernel = over_segments(canary, hosts)
    made: list[tuple[Floats, Beside]] = []
    for engine, own in zip(engines, canaries, strict=True):
        others = [vote for name, vote in votes.items() if name != engine]
        if len(others) >= FEWEST:
            made.append((_agreed(np.array(others), kernel), "other engines"))
        else:
            made.append((np.where(np.isfinite(own) & (own > 0), own / _middle(own), np.nan), "canary"))
    return made


def over_segments(values: Floats, segments: NDArray[np.int64]) -> Floats:
    """Each value over the median of its segment: another version or machine is no motion of the night."""
    over = np.full(len(values), np.nan)
    for number in np.unique(segments):
        mine = (segments == number) & np.isfinite(values) & (values > 0)
        if mine.any():
            over[mine] = values[mine] / np.exp(np.median(np.log(values[mine])))
    return over


def _moved(rows: Floats) -> Floats:
    """The common motion of rows (s, n), NaN on nights without any; a case that changed does not move the median of all."""
    return np.where(np.isfinite(rows).any(axis=0), common_mode(rows), np.nan)


def _agreed(votes: Floats, kernel: Floats) -> Floats:
    """What the votes (v, n) of engines and the canary's (n,) come to."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", RuntimeWarning)  # a night on which nothing was clocked
        middle = np.nanmedian(np.log(np.vstack([votes, kernel])), axis=0)
        off = np.log(votes) - middle
        most = CLIP * float(np.nanmedian(np.abs(off)))
        mean = np.nanmean(np.where(np.abs(off) <= most, off, np.nan), axis=0)
        agreed: Floats = np.exp(middle + np.nan_to_num(mean))
    return agreed


def _middle(values: Floats) -> float:
    usable = values[np.isfinite(values) & (values > 0)]
    return float(np.exp(np.median(np.log(usable)))) if len(usable) else 1.0
