"""By how much a trial keeps or misses its checks: the figure of the check nearest to its bound, or farthest beyond it."""

import math
from collections.abc import Mapping
from dataclasses import dataclass

from plumbline.harness.findings.once import once
from plumbline.harness.store.store import Store


@dataclass(frozen=True, slots=True)
class Margin:
    """One check of one trial.

    Terms: times [1]: the value over its bound, the bound over the value where more is better; above 1 the check is missed, inf
    where there is no number to compare. metric, value, at_most, unit: as in the table `measurements`.
    """

    times: float
    metric: str
    value: float
    at_most: float
    unit: str

    @property
    def held(self) -> bool:
        """Is the value within its bound?"""
        return self.times <= 1.0


def _times(value: float, bound: float, more: bool) -> float:
    if not math.isfinite(value):
        return math.inf
    above, below = (bound, abs(value)) if more else (abs(value), bound)
    return above / below if below > 0 else math.inf if above > 0 else 0.0


@once
def margins(store: Store) -> Mapping[str, Margin]:
    """Of each trial with a bounded check, by trial; a value that a check leaves unjudged has none."""
    table = store.measurements
    of_case = dict(zip(store.trials["trial"], store.trials["case"], strict=True))
    more = {
        (name, check["metric"])
        for name, case in store.catalogue.get("cases", {}).items()
        for check in case.get("checks", ())
        if check.get("better") == "higher"
    }
    worst: dict[str, Margin] = {}
    judged = table[table["passed"].notna() & table["at_most"].notna()]
    columns = ("trial", "metric", "value", "at_most", "unit", "passed")
    for trial, metric, value, bound, unit, passed in judged[list(columns)].itertuples(index=False):
        times = _times(float(value), float(bound), (of_case.get(trial), metric) in more)
        # A bound met to the last bit of its rounding is met, one that the check calls missed is missed.
        times = min(times, 1.0) if passed else max(times, math.nextafter(1.0, 2.0))
        if trial not in worst or times > worst[trial].times:
            worst[trial] = Margin(times, str(metric), float(value), float(bound), str(unit))
    return worst
