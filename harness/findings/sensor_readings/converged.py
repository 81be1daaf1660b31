"""What sensors should read in a scene without a truth: readings of the engine whose limit is agreed on, at a step of zero.

Its ladder of steps gives each reading several times. Where all are finite they are extrapolated as poses are
(`harness.statistics.richardson`), else those of its finest step stand.
"""

from collections.abc import Mapping
from typing import Any

import numpy as np

from plumbline.harness.findings.agreement.found import agreements
from plumbline.harness.findings.agreement.values import Agreement
from plumbline.harness.findings.once import once
from plumbline.harness.statistics.richardson import extrapolate
from plumbline.harness.store.store import Store
from plumbline.harness.trajectory import Floats

ROUND_OFF = 1e-12
"""Relative: of a reading, over some thousand steps."""


@once
def converged_readings(store: Store, case: str) -> Mapping[str, Floats]:
    """Streams 'truth_stream:<sensor>/<channel>_ideal' and their times, as a stored truth has them; empty where no limit is
    agreed to the end of the run."""
    for agreement in agreements(store):
        if agreement.case == case and agreement.agreed and agreement.until >= 0.999 * agreement.duration:
            return _of(store, agreement)
    return {}


def _of(store: Store, agreement: Agreement) -> dict[str, Floats]:
    voters = [side for side in agreement.members(agreement.agreed) if side.votes and side.limit.until >= agreement.until]
    sharpest = min(voters, key=lambda side: side.limit.bar_at(agreement.until))
    rungs = [rung for rung in sharpest.limit.rungs if rung.run is not None]
    hashes = dict(zip(store.trials["trial"], store.trials["trajectory_hash"], strict=True))
    runs: list[Mapping[str, Any]] = [store.trajectory(str(hashes[rung.trial])) for rung in rungs]
    readings: dict[str, Floats] = {}
    for name, finest in runs[-1].items():
        if not name.startswith("stream:"):
            continue
        ladder = [np.asarray(run[name], float) for run in runs if name in run and run[name].shape == finest.shape]
        regular = len(ladder) > 1 and len(ladder) == len(runs) and all(np.isfinite(each).all() for each in ladder)
        if not regular or name.endswith("/time"):
            readings[f"truth_{name}"] = finest
            continue
        off = ROUND_OFF * float(np.abs(finest).max(initial=0.0))
        readings[f"truth_{name}"] = extrapolate(ladder, [1 / rung.substep for rung in rungs], off).value
    return readings
