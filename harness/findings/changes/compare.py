"""Two run folders side by side: what of the second differs from the first."""

from collections.abc import Callable, Iterator

from plumbline.harness.findings.changes.answers import answer_changes
from plumbline.harness.findings.changes.circumstances import (
    machine_changes,
    setting_changes,
    source_changes,
    trial_changes,
    version_changes,
    warning_changes,
)
from plumbline.harness.findings.changes.limits import limit_changes
from plumbline.harness.findings.changes.matching import matched
from plumbline.harness.findings.changes.own_verdicts import own_verdict_changes
from plumbline.harness.findings.changes.prices import clocked, price_changes
from plumbline.harness.findings.changes.repetitions import repetition_changes
from plumbline.harness.findings.changes.values import Change, Changes, Side
from plumbline.harness.findings.changes.weights import heaviest_first
from plumbline.harness.store.journal import StoreError
from plumbline.harness.store.machine_fingerprint import machine_digest
from plumbline.harness.store.store import Store


def compare(store_a: Store, store_b: Store) -> Changes:
    """All that differs from `store_a` to `store_b`, heaviest first. Raises: StoreError."""
    every = matched(store_a, store_b)
    pairs = [pair for pair in every if pair.a is not None and pair.b is not None]
    unread: list[str] = []
    rows = [
        *answer_changes(store_a, store_b, pairs),
        *price_changes(store_a, store_b, pairs),
        *_where_kept(lambda: limit_changes(store_a, store_b), "limits", unread),
        *_where_kept(lambda: repetition_changes(store_a, store_b), "determinism", unread),
        *_where_kept(lambda: own_verdict_changes(store_a, store_b), "verdicts on scenes of one's own", unread),
        *warning_changes(store_a, store_b, pairs),
        *version_changes(store_a, store_b),
        *setting_changes(pairs),
        *source_changes(pairs),
        *machine_changes(store_a, store_b),
        *trial_changes(every),
    ]
    return Changes(
        a=_side(store_a),
        b=_side(store_b),
        rows=heaviest_first(rows),
        matched=len(pairs),
        same=sum(pair.same_bits for pair in pairs),
        clocked=len(clocked(pairs)),
        unread=tuple(unread),
        titles={**store_a.titles, **store_b.titles},
    )


def _where_kept(read: Callable[[], Iterator[Change]], what: str, unread: list[str]) -> list[Change]:
    """What can be read off files that a history may not have kept."""
    try:
        return list(read())
    except StoreError as error:
        unread.append(f"{what}: {error}")
        return []


def _side(store: Store) -> Side:
    versions = store.trials.groupby("engine")["engine_version"].agg(lambda column: ", ".join(sorted(set(map(str, column)))))
    return Side(
        folder=str(store.folder),
        study=str(store.study.get("name", "")),
        started=str(store.machine.get("started", "")),
        machine=machine_digest(store.machine),
        trials=len(store.trials),
        versions=tuple((str(engine), str(version)) for engine, version in versions.items()),
    )
