"""What was answered the last time, whatever it rested on: the row of every trial that asked the same."""

import json
from collections.abc import Hashable, Mapping
from dataclasses import dataclass, field
from typing import Any

from plumbline.harness.history.blocks import Key, Seen
from plumbline.harness.store.store import Store
from plumbline.harness.study.trial import Trial


@dataclass(slots=True)
class LastAnswers:
    """Answers of earlier nights, each of which is read once, when it is wanted. Terms: seen: the last night of each block."""

    seen: Mapping[Key, Seen]
    _stores: dict[str, Store] = field(default_factory=dict)
    _rows: dict[str, dict[Hashable, Any]] = field(default_factory=dict)

    def store(self, key: Key, engine: str) -> Store:
        """The last night that did all of a block on an engine, with the blocks that no later one did. Raises: StoreError."""
        night = self.seen[key].night_of(engine)
        if night.stamp not in self._stores:
            self._stores[night.stamp] = night.store_of({key for key, known in self.seen.items() if night in known.nights})
        return self._stores[night.stamp]

    def of(self, trial: Trial) -> Any:
        """A row of the table `trials`; None where nobody asked this before. Raises: StoreError."""
        block = trial.experiment.name, trial.case
        if block not in self.seen:
            return None
        store = self.store(block, trial.engine)
        if (stamp := store.folder.name) not in self._rows:
            self._rows[stamp] = {_question(row): row for row in store.trials.itertuples()}
        plain = (json.dumps(each, sort_keys=True) for each in (trial.alteration.plain(), dict(trial.parameters)))
        question = (trial.engine, trial.track, trial.settings.dt, trial.seed, trial.members, trial.parts, trial.remedy)
        return self._rows[stamp].get((*block, *question, *plain))


def _question(row: Any) -> Hashable:
    question = (row.engine, row.track, row.dt, row.seed, row.members, row.parts, row.remedy)
    return row.experiment, row.case, *question, row.alteration, row.parameters
