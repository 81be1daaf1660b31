"""World spread: do equal worlds that are stepped together have the same future?"""

import numpy as np

from plumbline.harness.metric import NotMeasurable, Run, metric


@metric("1")
def world_spread(run: Run) -> float:
    """definition: largest difference of any number of a world's state at the end from the first world's, in SI units"""
    if "worlds/spread" not in run.actual.streams:
        raise NotMeasurable("the worlds were not compared")
    return float(np.max(run.actual.streams["worlds/spread"], initial=0.0))
