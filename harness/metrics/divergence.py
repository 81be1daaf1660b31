"""Divergence: zero while every number of every state is finite, infinite otherwise."""

import numpy as np

from plumbline.harness.metric import NotMeasurable, Run, metric


@metric("1", verdict="a number is not finite", finite=False)
def divergence(run: Run) -> float:
    """definition: 0 if all states are finite, else infinite"""
    if len(run.actual) == 0:
        raise NotMeasurable("no sample lies in the time that is judged")
    return 0.0 if run.actual.finite else float(np.inf)
