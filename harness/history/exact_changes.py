"""Answers, limits and repetitions that became otherwise, night by night, each against the last night that has them."""

from collections.abc import Iterable, Iterator, Sequence

import pandas as pd

from plumbline.harness.findings.changes import Change
from plumbline.harness.findings.changes.answers import answer_changes
from plumbline.harness.findings.changes.limits import moved_limits, searched_by
from plumbline.harness.findings.changes.matching import LOST, Pair
from plumbline.harness.findings.changes.repetitions import lost_and_won
from plumbline.harness.findings.limits_found import Search
from plumbline.harness.findings.tables.determinism import Agreement
from plumbline.harness.history.folder import Night
from plumbline.harness.history.night_readings import Readings, questions

_SILENT = ("unavailable", "interrupted")
"""Statuses that say nothing of an engine: the answer before still stands."""


def exact_changes(nights: Sequence[Night], readings: Sequence[Readings]) -> Iterator[tuple[int, Change]]:
    """What changed, each with the index of its night, in order; the tables of two nights are read where an answer is another.

    Args: nights: the earliest first; readings: of each. Raises: StoreError.
    """
    otherwise = _otherwise([reading.table for reading in readings])
    searched: dict[tuple[object, ...], Search] = {}
    repeated: dict[str, Agreement] = {}
    for index, reading in enumerate(readings):
        changes: list[Iterable[Change]] = []
        for earlier, keys in otherwise.get(index, {}).items():
            before, after = nights[earlier].store(), nights[index].store()
            then, now = questions(before), questions(after)
            changes.append(answer_changes(before, after, [Pair(then[key], now[key]) for key in keys]))
        changes += [moved_limits(searched.values(), reading.searches), lost_and_won(repeated, reading.repetitions)]
        yield from ((index, change) for group in changes for change in group)
        searched |= {searched_by(search): search for search in reading.searches}
        repeated |= reading.repetitions


def _otherwise(tables: Sequence[pd.DataFrame]) -> dict[int, dict[int, list[str]]]:
    """Keys of answers that are others than the last time, by the index of the night, and of the one that answered them last.

    No change is told of two answers whose status, bits and measured values are all the same. One that was lost in between is
    compared with the last that there was, too.
    """
    columns = ["key", "status", "hash", "measured"]
    answers = [table.loc[table["kind"] == "answer", columns].assign(night=k) for k, table in enumerate(tables)]
    table = pd.concat(answers, ignore_index=True) if answers else pd.DataFrame(columns=[*columns, "night"])
    table = table[~table["status"].isin(_SILENT)]
    both = _changed(table), _changed(table[~table["status"].isin(LOST)])
    otherwise: dict[int, dict[int, list[str]]] = {}
    for row in pd.concat(both).drop_duplicates(["key", "night", "before"]).itertuples():
        otherwise.setdefault(int(row.night), {}).setdefault(int(row.before), []).append(str(row.key))
    return otherwise


def _changed(table: pd.DataFrame) -> pd.DataFrame:
    """The answers that are others than the one before them, with the night of that as `before`."""
    before = table.groupby("key", sort=False)[["status", "hash", "measured", "night"]].shift()
    other_bits = (table["hash"] != "") & (table["hash"] != before["hash"])
    other = (table["status"] != before["status"]) | (table["measured"] != before["measured"]) | other_bits
    return table.assign(before=before["night"])[before["night"].notna() & other]
