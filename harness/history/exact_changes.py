"""Answers, limits and repetitions that became otherwise, night by night, each against the last night that has them."""

from collections.abc import Hashable
from dataclasses import dataclass, field
from typing import Any

from harness.findings.changes import Change
from harness.findings.changes.answers import answer_changes
from harness.findings.changes.limits import moved_limits, searched_by
from harness.findings.changes.matching import Pair, by_question
from harness.findings.changes.repetitions import agreements_by_cell, lost_and_won
from harness.findings.limits_found import Search, searches
from harness.findings.tables.determinism import Agreement
from harness.history.folder import Night
from harness.store.journal import StoreError
from harness.store.store import Store

__all__ = ["ExactChanges"]

_SILENT = ("unavailable", "interrupted")
"""Statuses that say nothing of an engine: the answer before still stands."""


@dataclass(slots=True)
class ExactChanges:
    """What changed so far. Terms: changes: each with the index of its night, in order."""

    changes: list[tuple[int, Change]] = field(default_factory=list)
    _nights: list[Night] = field(default_factory=list)
    _answers: dict[Hashable, tuple[int, Any]] = field(default_factory=dict)
    _searches: dict[Hashable, Search] = field(default_factory=dict)
    _repeated: dict[Hashable, Agreement] = field(default_factory=dict)

    def add(self, night: Night, store: Store) -> None:
        """Read one more night. Raises: StoreError."""
        index = len(self._nights)
        self._nights.append(night)
        earlier: dict[int, list[Pair]] = {}
        for key, row in by_question(store).items():
            if row.status in _SILENT:
                continue
            known = self._answers.get(key)
            if known is not None and _otherwise(known[1], row):
                earlier.setdefault(known[0], []).append(Pair(known[1], row))
            self._answers[key] = (index, row)
        for before, pairs in earlier.items():
            self._note(index, answer_changes(self._nights[before].store(), store, pairs))
        searched = searches(store)
        self._note(index, moved_limits(self._searches.values(), searched))
        self._searches |= {searched_by(search): search for search in searched if not search.remedied}
        try:
            repeated = agreements_by_cell(store)
        except StoreError:
            return  # a history may keep hashes only, and a parting cannot be read off these
        self._note(index, lost_and_won(self._repeated, repeated))
        self._repeated |= repeated

    def _note(self, index: int, changes: Any) -> None:
        self.changes += [(index, change) for change in changes]


def _otherwise(before: Any, after: Any) -> bool:
    """May the two differ in more than the name of the trial? The same digest with the same bits is the same measurement."""
    same_bits = before.trajectory_hash == after.trajectory_hash or not isinstance(after.trajectory_hash, str)
    return bool(before.status != after.status or not same_bits or before.trial != after.trial)
