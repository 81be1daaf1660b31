"""What would decide between engines: the figure whose interval, if it were half as wide, moves the answer most."""

from dataclasses import dataclass

import numpy as np
import pandas as pd

from plumbline.harness.findings.selection.evidence import Evidence
from plumbline.harness.findings.selection.rank import Resampled, first_shares
from plumbline.harness.store.store import Store

LEAST = 0.02
"""Share of resamples below which a figure decides nothing: half of the resolution of the shares themselves is as much."""
STUDIES = {"speed": "accuracy", "limits": "limits"}
"""The built-in study that measures a criterion more closely: speeds over a ladder of steps, limits to a narrower bracket."""


@dataclass(frozen=True, kw_only=True)
class Decider:
    """criterion, case, engine: of the figure. moves: the share of resamples that its interval, halved, moves at most from the
    first engine to others. seconds: what this engine's runs of the case took in the folder, runs: how many they are."""

    criterion: str
    case: str
    engine: str
    moves: float
    seconds: float
    runs: int

    @property
    def command(self) -> str:
        """What measures it more closely."""
        return f"plumbline run {STUDIES[self.criterion]} --engine {self.engine} --case {self.case}"


def decider(store: Store, evidence: Evidence, samples: Resampled) -> Decider | None:
    """None where no figure's interval moves the answer by `LEAST`. A figure moves scores in proportion, so that its effect is
    known without a rank of its own."""
    leader = int(np.argmax(first_shares(samples.scores)))
    best: tuple[float, str, str, str] | None = None
    for (criterion, case, engine), datum in evidence.table.items():
        if criterion not in STUDIES or criterion not in samples.criteria or datum.possible <= datum.low:
            continue
        k, c, e = samples.criteria.index(criterion), samples.cases.index(case), evidence.engines.index(engine)
        ends = []
        for end in (datum.low, datum.possible):
            moved = samples.scores.copy()
            moved[:, e] += samples.share[:, k, c] * (end - samples.drawn[:, k, c, e])
            ends.append(first_shares(moved)[leader])
        moves = abs(ends[1] - ends[0]) / 2
        if moves >= LEAST and (best is None or moves > best[0]):
            best = float(moves), criterion, case, engine
    if best is None:
        return None
    seconds, runs = _spent(store, best[2], best[3])
    return Decider(criterion=best[1], case=best[2], engine=best[3], moves=best[0], seconds=seconds, runs=runs)


def _spent(store: Store, case: str, engine: str) -> tuple[float, int]:
    """Seconds of all runs of an engine in a case, clocked ones with their samples, and how many runs these are."""
    trials = store.asked[(store.asked["case"] == case) & (store.asked["engine"] == engine)]
    once = (pd.to_numeric(trials["cpu_per_sim_s"]).fillna(pd.to_numeric(trials["rough_cost"])) * trials["sim_seconds"]).sum()
    clocked = store.samples.loc[store.samples["trial"].isin(trials["trial"]), "wall"].sum()
    return float(once + clocked), len(trials)
