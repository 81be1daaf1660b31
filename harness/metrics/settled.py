"""In how many of several starts, which differ by less than anybody can build, all bodies have come to rest."""

import re

import numpy as np

from plumbline.harness.metric import NotMeasurable, Run
from plumbline.harness.metric.series import proportion
from plumbline.harness.scene import EARTH_GRAVITY
from plumbline.harness.trajectory import Floats

START = "start_"
"""The streams of another start are named so, with its number: 'start_3/v_WB'."""


def other_starts(run: Run, of: str) -> list[Floats]:
    """A stream of each other start, 'p_WB' (k, n, 3) m say."""
    return [stream for name, stream in run.actual.streams.items() if re.fullmatch(rf"{START}\d+/{of}", name)]


def _rested(run: Run) -> tuple[int, int]:
    """Starts in which no body is faster than one step of gravity makes it, of how many. Raises: NotMeasurable."""
    bound, others = -EARTH_GRAVITY[2] * run.actual.dt, other_starts(run, "v_WB")
    if not others:
        raise NotMeasurable("one start alone was run")
    speeds = []
    for v_WB in (run.actual.v_WB, *others):
        squares = np.sum(v_WB[:, run.movable] ** 2, axis=2)
        speeds.append(float(np.sqrt(squares.mean(axis=0)).max()) if squares.size else np.inf)
    return sum(speed <= bound for speed in speeds), len(speeds)


settled_share, settled_share_low, settled_share_high = proportion(
    "settled_share",
    "definition: starts in which all rest over the window, over all; at rest is what g dt covers, root mean square",
    "",
    _rested,
    better="higher",
)
