"""How many settings were tried for each case on each engine, and why a search for more of them ended."""

from dataclasses import dataclass
from typing import Literal

import pandas as pd

from plumbline.harness.search.front import RUNS
from plumbline.harness.store.rows import grouped, records
from plumbline.harness.store.store import Store
from plumbline.harness.study.stored_study import experiments_of

Ended = Literal["no search", "nothing left to try", "all points spent"]
ALIKE = 1.5
"""How many times as many settings may be tried of one engine as of another in the same case."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Effort:
    """What was tried of a case on an engine.

    Terms: tried: settings whose answers differ, the ladder of both tracks among them; one that leaves every bit of a trajectory
    as it was is no other. beyond: those that a sweep found beyond the ladder, of `room` that it had. ended: why there are no
    more; 'nothing left to try' where knobs and steps were used up, or what is left takes too long.
    """

    tried: int
    beyond: int
    room: int
    ended: Ended


def efforts(store: Store, trials: pd.DataFrame) -> dict[str, Effort]:
    """By engine, of the trials of one case at one set of parameters."""
    rooms = {experiment.name: experiment.sweep for experiment in experiments_of(store)}
    by_engine = {}
    rows = records(trials[["engine", "experiment", "trajectory_hash", "round"]])
    for engine, mine in grouped(rows, lambda row: str(row["engine"])).items():
        room = max(rooms.get(row["experiment"], 0) for row in mine)
        answers = {row["trajectory_hash"] for row in mine if isinstance(row["trajectory_hash"], str)}
        beyond = len(answers - {row["trajectory_hash"] for row in mine if row["round"] == 0})
        spent = beyond >= room or sum(row["round"] > 0 for row in mine) >= RUNS * room
        ended: Ended = "no search" if not room else "all points spent" if spent else "nothing left to try"
        by_engine[engine] = Effort(tried=len(answers), beyond=beyond, room=room, ended=ended)
    return by_engine
