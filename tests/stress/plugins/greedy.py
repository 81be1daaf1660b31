"""Cases whose metrics take more memory or time than a trial may; their engines answer soundly."""

from dataclasses import replace

import numpy as np
from faulty import CASE

from plumbline.harness.case import Case, Check
from plumbline.harness.metric import Run, metric


@metric("1")
def memory_metric(run: Run) -> float:
    """definition: a metric that takes two gigabytes"""
    del run
    return float(np.ones(2 << 28).sum())


@metric("1")
def time_metric(run: Run) -> float:
    """definition: a metric that never ends"""
    while len(run.actual):
        pass
    return 0.0


@metric("1")
def refused_metric(run: Run) -> float:
    """definition: a metric that asks for more memory than there is"""
    del run
    return float(np.ones(1 << 55).sum())


def _case(name: str, check: Check) -> Case:
    return replace(CASE, name=name, checks=(check,), headline=check.metric.name)


MEMORY = _case("stress_memory", Check(metric=memory_metric, at_most=lambda _dt, _: 1.0, because="it never comes"))
TIME = _case("stress_time", Check(metric=time_metric, at_most=lambda _dt, _: 1.0, because="it never comes"))
REFUSED = replace(CASE, name="stress_refused", observe=(refused_metric,))
