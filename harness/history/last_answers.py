"""What was answered the last time, whatever it rested on: status, hash and price of every trial that asked the same."""

import json
import math
from collections.abc import Hashable, Mapping
from dataclasses import dataclass, field
from typing import NamedTuple

from plumbline.harness.history.blocks import Key, Seen
from plumbline.harness.history.folder import Night
from plumbline.harness.study.trial import Trial


class LastAnswer(NamedTuple):
    """Terms: hash: None where nothing was kept. price: CPU seconds of a unit, NaN where it was not clocked."""

    status: str
    hash: str | None
    price: float


@dataclass(slots=True)
class LastAnswers:
    """Answers of earlier nights, each of which is read once, when it is wanted. Terms: seen: the last night of each block."""

    seen: Mapping[Key, Seen]
    _known: dict[str, dict[Hashable, LastAnswer]] = field(default_factory=dict)

    def of(self, trial: Trial) -> LastAnswer | None:
        """None where nobody asked this before. Raises: StoreError."""
        block = trial.experiment.name, trial.case
        if block not in self.seen:
            return None
        night = self.seen[block].night_of(trial.engine)
        if night.stamp not in self._known:
            self._known[night.stamp] = self._read(night)
        alteration = json.dumps(trial.alteration.plain(), sort_keys=True)
        parameters = json.dumps(dict(trial.parameters), sort_keys=True)
        asked = (*block, trial.engine, trial.track, trial.settings.dt, trial.seed, trial.members, trial.parts, trial.remedy)
        return self._known[night.stamp].get((*asked, alteration, parameters))

    def _read(self, night: Night) -> dict[Hashable, LastAnswer]:
        """What a night says of the blocks that it was the last to do."""
        blocks = {key for key, known in self.seen.items() if night in known.nights}
        rows = night.store_of(blocks).trials.itertuples()
        known: dict[Hashable, LastAnswer] = {}
        for row in rows:
            cell = (row.experiment, row.case, row.engine, row.track, row.dt, row.seed, row.members, row.parts, row.remedy)
            answer = row.trajectory_hash if isinstance(row.trajectory_hash, str) else None
            price = math.nan if row.cpu_per_unit is None else float(row.cpu_per_unit)
            known[*cell, row.alteration, row.parameters] = LastAnswer(str(row.status), answer, price)
        return known
