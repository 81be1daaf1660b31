"""How many settings were tried for each case on each engine, and why a search for more of them ended."""

from typing import Literal

import pandas as pd

from plumbline.harness.search.front import RUNS
from plumbline.harness.store.rows import grouped, records
from plumbline.harness.store.store import Store
from plumbline.harness.study.stored_study import experiments_of

Ended = Literal["no search", "nothing left to try", "all points spent"]
ALIKE = 1.5
"""How many times as many settings may be tried of one engine as of another in the same case."""


def efforts(store: Store, trials: pd.DataFrame) -> dict[str, tuple[int, Ended]]:
    """By engine, of the trials of one case at one set of parameters: how many settings were tried, and why there are no more.

    Settings are others whose answers differ, the ladder of both tracks among them; one that leaves every bit of a trajectory as
    it was is no other. 'nothing left to try' is where knobs and steps were used up, or what is left takes too long.
    """
    rooms = {experiment.name: experiment.sweep for experiment in experiments_of(store)}
    by_engine = {}
    rows = records(trials[["engine", "experiment", "trajectory_hash", "round"]])
    for engine, mine in grouped(rows, lambda row: str(row["engine"])).items():
        room = max(rooms.get(row["experiment"], 0) for row in mine)
        answers = {row["trajectory_hash"] for row in mine if isinstance(row["trajectory_hash"], str)}
        beyond = len(answers - {row["trajectory_hash"] for row in mine if row["round"] == 0})
        spent = beyond >= room or sum(row["round"] > 0 for row in mine) >= RUNS * room
        ended: Ended = "no search" if not room else "all points spent" if spent else "nothing left to try"
        by_engine[engine] = len(answers), ended
    return by_engine
