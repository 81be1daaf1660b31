"""In how many of several starts, which differ by less than anybody can build, all bodies have come to rest."""

import numpy as np

from plumbline.harness.metric import NotMeasurable, Run
from plumbline.harness.metric.series import other_starts, proportion
from plumbline.harness.scene import EARTH_GRAVITY


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
