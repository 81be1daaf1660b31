"""What was answered the last time, whatever it rested on: status and hash of every trial that asked the same."""

import json
from collections.abc import Hashable, Mapping
from dataclasses import dataclass, field
from typing import Any

from harness.history.blocks import Key, Seen
from harness.study.trial import Trial

__all__ = ["LastAnswers"]


@dataclass(slots=True)
class LastAnswers:
    """Answers of earlier nights, read block by block when they are wanted. Terms: seen: the last night of each block."""

    seen: Mapping[Key, Seen]
    _known: dict[Key, dict[Hashable, tuple[str, str | None]]] = field(default_factory=dict)

    def of(self, trial: Trial) -> tuple[str, str | None] | None:
        """Status and hash; None where nobody asked this before."""
        key = (trial.experiment.name, trial.case)
        if key not in self._known:
            self._known[key] = self._read(key)
        alteration = json.dumps(trial.alteration.plain(), sort_keys=True)
        parameters = json.dumps(dict(trial.parameters), sort_keys=True)
        asked = (trial.engine, trial.track, trial.settings.dt, trial.seed, trial.members, trial.parts, trial.remedy)
        return self._known[key].get((*asked, alteration, parameters))

    def _read(self, key: Key) -> dict[Hashable, tuple[str, str | None]]:
        if key not in self.seen:
            return {}
        rows = self.seen[key].night.store_of({key}).trials.itertuples()
        return {_asked(row): (str(row.status), _text(row.trajectory_hash)) for row in rows}


def _asked(row: Any) -> Hashable:
    asked = (row.engine, row.track, row.dt, row.seed, row.members, row.parts, row.remedy)
    return (*asked, row.alteration, row.parameters)


def _text(value: Any) -> str | None:
    return value if isinstance(value, str) else None
