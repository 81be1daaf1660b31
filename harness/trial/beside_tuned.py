"""What settings cost over what the track 'tuned' costs, roughly: whole runs of both in turns, beside an accuracy run.

A single run is clocked from cold, beside whatever else the machine does; of short ones that says little, and a few more are
cheap. Where a run is long it says enough, and more would be dear.
"""

import time
from statistics import median

from plumbline.harness.adapter import Adapter
from plumbline.harness.case import Case
from plumbline.harness.study.trial import Trial
from plumbline.harness.trial.bench import Bench, rough_cost_beside

SHORT = 0.05
"""Of steps [s]: a run that takes no longer is repeated."""
TURNS = 3
AT_MOST = 0.5
"""After so much CPU time [s] no further turn begins."""


def ratio_to_tuned(trial: Trial, case: Case, adapter: Adapter) -> float:
    """The CPU time of whole runs over that of 'tuned' at the same time step and parameters: the median of a few turns.

    Where rays are what costs, of casts. Raises: whatever a build or a step does.
    """
    tuned = adapter.tracks["tuned"].with_dt(trial.settings.dt)
    own, beside = (
        Bench(case, adapter, side, settled=False)
        for side in (trial, trial.probing(case, track="tuned", base="", settings=tuned))
    )
    if own.unit == "ray":
        return rough_cost_beside(own, beside)[1]
    ratios, until = list[float](), time.process_time() + AT_MOST
    try:
        while len(ratios) < TURNS and (not ratios or time.process_time() < until):
            ratios.append(_whole(own) / _whole(beside))
    finally:
        own.stop()
        beside.stop()
    return median(ratios)


def _whole(bench: Bench) -> float:
    bench.start()
    return bench.clock(bench.whole)[0]
