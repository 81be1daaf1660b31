"""What changed tonight: every block against the last night that did all of it, and other answers to the same digest."""

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, field, replace

from plumbline.harness.findings.changes import Change, Changes, compare
from plumbline.harness.findings.changes.matching import where_of
from plumbline.harness.findings.changes.weights import heaviest_first
from plumbline.harness.history.acknowledged import Acknowledgement, silenced
from plumbline.harness.history.blocks import Key, Seen
from plumbline.harness.history.identity import Named, change_id
from plumbline.harness.history.slow_drift import OverNights
from plumbline.harness.store.store import Store


@dataclass(frozen=True, slots=True)
class News:
    """What changed.

    Terms: changes: what nobody has acknowledged; acknowledged: the others. since: the nights from which on it is so, where
    that is not tonight. ended: ids of earlier changes that are over.
    """

    changes: Changes
    acknowledged: tuple[Change, ...]
    since: Mapping[Change, str] = field(default_factory=dict)
    ended: frozenset[str] = frozenset()

    def regressions(self, gated: Collection[str]) -> tuple[Change, ...]:
        """What of these engines is worse."""
        return self.changes.regressions(gated)


def first_seen(change: Change, earlier: Mapping[str, str], stamp: str) -> str:
    """The night that a change is called by.

    Args: earlier: nights by what a change is called without one, of those that last. stamp: of tonight.
    """
    return earlier.get(change_id(change, ""), stamp)


def news_of(
    store: Store,
    stamp: str,
    seen: Mapping[Key, Seen],
    blocks: Collection[Key],
    known: dict[str, Acknowledgement],
    earlier: Mapping[str, str],
    over: Callable[[Sequence[Change]], OverNights] = lambda _rows: OverNights(),
) -> News | None:
    """What changed in a night; None where nothing of it was seen before.

    Args: store, stamp: of the night. blocks: that it carried out. known: what was acknowledged. earlier: see `first_seen`.
    over: of what the night tells by itself, what all nights tell beside it.
    Raises: StoreError.
    """
    known_blocks = {key for key in blocks if key in seen}
    if not known_blocks:
        return None
    fresh = _with_news(store) & known_blocks or {min(known_blocks)}
    before: dict[str, set[Key]] = {}
    for key in fresh:
        before.setdefault(seen[key].night.stamp, set()).add(key)
    nights = {seen[key].night.stamp: seen[key].night for key in fresh}
    parts = [compare(nights[stamp].store_of(keys), store.part(keys)) for stamp, keys in sorted(before.items(), reverse=True)]
    others = {row.trial_b: row for row in _disagreements(store)}
    every = heaviest_first(
        dict.fromkeys([*(row for part in parts for row in part.rows if not _left_aside(row, others)), *others.values()])
    )
    recalled = store.part(known_blocks - fresh).trials
    stamps = sorted({*(sight.night.stamp for sight in seen.values()), stamp})
    told = tuple(row for row in every if silenced(Named.of(row, first_seen(row, earlier, stamp)), known, stamps) is None)
    nights_told = over(every)
    since = {heaviest_first([row])[0]: began for row, began in zip(nights_told.rows, nights_told.since, strict=True)}
    changes = replace(
        parts[0],
        b=replace(parts[0].b, trials=len(store.trials)),
        rows=heaviest_first([*told, *since]),
        matched=sum(part.matched for part in parts) + len(recalled),
        same=sum(part.same for part in parts) + int(recalled["trajectory_hash"].notna().sum()),
        clocked=sum(part.clocked for part in parts),
        unread=tuple(dict.fromkeys(text for part in parts for text in part.unread)),
    )
    return News(changes, tuple(row for row in every if row not in told), since, nights_told.ended)


def _with_news(store: Store) -> set[Key]:
    """The blocks in which anything was answered for the first time, answered otherwise, or clocked: all else was recalled."""
    trials = store.trials
    fresh = (trials["recalled"] == "") & (trials["again"] != trials["trajectory_hash"].fillna(trials["status"]))
    rows = trials[fresh | (trials["cpu_per_unit"] > 0)]
    return {*zip(rows["experiment"], rows["case"], strict=True)}


def _left_aside(row: Change, disagreements: Mapping[str, Change]) -> bool:
    """Is it no news? Searches try other values every night, and a budget leaves others out; and what is as good, but not the
    same to the same digest, is told as that."""
    return row.kind == "trials" or (row.sense == "within tolerance" and row.trial_b in disagreements)


def _disagreements(store: Store) -> list[Change]:
    """A row for each answer that was known, was computed again, and is another."""
    again = store.trials[store.trials["again"] != ""]
    answers = again["trajectory_hash"].fillna(again["status"])
    return [
        Change(
            kind="digest",
            sense="worse",
            case=row.case,
            engine=row.engine,
            track=row.track,
            where=where_of(row, store.catalogue),
            dt=float(row.dt),
            metric="answer",
            trial_a=row.trial,
            trial_b=row.trial,
            before=row.again,
            after=answer,
        )
        for row, answer in zip(again.itertuples(), answers, strict=True)
        if row.again != answer
    ]
