"""What was answered the last time, whatever it rested on: status and hash of every trial that asked the same."""

import json
from collections.abc import Hashable, Mapping
from dataclasses import dataclass, field

from plumbline.harness.history.blocks import Key, Seen
from plumbline.harness.history.folder import Night
from plumbline.harness.study.trial import Trial


@dataclass(slots=True)
class LastAnswers:
    """Answers of earlier nights, each of which is read once, when it is wanted. Terms: seen: the last night of each block."""

    seen: Mapping[Key, Seen]
    _known: dict[str, dict[Hashable, tuple[str, str | None]]] = field(default_factory=dict)

    def of(self, trial: Trial) -> tuple[str, str | None] | None:
        """Status and hash; None where nobody asked this before. Raises: StoreError."""
        block = trial.experiment.name, trial.case
        if block not in self.seen:
            return None
        night = self.seen[block].night
        if night.stamp not in self._known:
            self._known[night.stamp] = self._read(night)
        alteration = json.dumps(trial.alteration.plain(), sort_keys=True)
        parameters = json.dumps(dict(trial.parameters), sort_keys=True)
        asked = (*block, trial.engine, trial.track, trial.settings.dt, trial.seed, trial.members, trial.parts, trial.remedy)
        return self._known[night.stamp].get((*asked, alteration, parameters))

    def _read(self, night: Night) -> dict[Hashable, tuple[str, str | None]]:
        """What a night says of the blocks that it was the last to do."""
        blocks = {key for key, known in self.seen.items() if known.night.stamp == night.stamp}
        rows = night.store_of(blocks).trials.itertuples()
        known: dict[Hashable, tuple[str, str | None]] = {}
        for row in rows:
            cell = (row.experiment, row.case, row.engine, row.track, row.dt, row.seed, row.members, row.parts, row.remedy)
            answer = row.trajectory_hash if isinstance(row.trajectory_hash, str) else None
            known[*cell, row.alteration, row.parameters] = str(row.status), answer
        return known
