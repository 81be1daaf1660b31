"""Answers, limits and repetitions that became otherwise, night by night, each against the last night that has them."""

from collections.abc import Iterable
from dataclasses import dataclass, field

from plumbline.harness.findings.changes import Change
from plumbline.harness.findings.changes.answers import answer_changes
from plumbline.harness.findings.changes.limits import moved_limits, searched_by
from plumbline.harness.findings.changes.matching import Pair
from plumbline.harness.findings.changes.repetitions import lost_and_won
from plumbline.harness.findings.limits_found import Search
from plumbline.harness.findings.tables.determinism import Agreement
from plumbline.harness.history.folder import Night
from plumbline.harness.history.night_readings import Answer, Answers, questions

_SILENT = ("unavailable", "interrupted")
"""Statuses that say nothing of an engine: the answer before still stands."""


@dataclass(slots=True)
class ExactChanges:
    """What changed so far. Terms: changes: each with the index of its night, in order."""

    changes: list[tuple[int, Change]] = field(default_factory=list)
    _nights: list[Night] = field(default_factory=list)
    _answers: dict[str, tuple[int, Answer]] = field(default_factory=dict)
    _searches: dict[tuple[object, ...], Search] = field(default_factory=dict)
    _repeated: dict[str, Agreement] = field(default_factory=dict)

    def add(self, night: Night, said: Answers) -> None:
        """Take in what one more night said; its tables are read where an answer is another. Raises: StoreError."""
        index = len(self._nights)
        self._nights.append(night)
        otherwise: dict[int, list[str]] = {}
        for name, answer in said.answers.items():
            if answer.status in _SILENT:
                continue
            known = self._answers.get(name)
            if known is not None and _otherwise(known[1], answer):
                otherwise.setdefault(known[0], []).append(name)
            self._answers[name] = (index, answer)
        self._note(index, self._changed(index, otherwise))
        self._note(index, moved_limits(self._searches.values(), said.searches))
        self._searches |= {searched_by(search): search for search in said.searches}
        self._note(index, lost_and_won(self._repeated, said.repetitions))
        self._repeated |= said.repetitions

    def _changed(self, index: int, otherwise: dict[int, list[str]]) -> Iterable[Change]:
        """Args: otherwise: names of questions, by the index of the night that answered them last."""
        if not otherwise:
            return
        store = self._nights[index].store()
        after = questions(store)
        for earlier, names in otherwise.items():
            store_before = self._nights[earlier].store()
            before = questions(store_before)
            yield from answer_changes(store_before, store, [Pair(before[name], after[name]) for name in names])

    def _note(self, index: int, changes: Iterable[Change]) -> None:
        self.changes += [(index, change) for change in changes]


def _otherwise(before: Answer, after: Answer) -> bool:
    """May a change be told of the two? Not where status, bits and all measured values are the same."""
    other_bits = bool(after.hash) and before.hash != after.hash
    return before.status != after.status or before.values != after.values or other_bits
