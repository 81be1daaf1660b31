"""Two run folders side by side: what of the second differs from the first."""

from collections.abc import Callable, Iterator, Sequence
from typing import Any

from plumbline.harness.findings.changes.answers import answer_changes
from plumbline.harness.findings.changes.circumstances import (
    machine_changes,
    setting_changes,
    source_changes,
    trial_changes,
    version_changes,
    warning_changes,
)
from plumbline.harness.findings.changes.matching import LOST, TrialPair, matched, scene_of
from plumbline.harness.findings.changes.prices import clocked, judged_prices, price_changes
from plumbline.harness.findings.changes.studied import limit_changes, own_verdict_changes, repetition_changes
from plumbline.harness.findings.changes.values import Change, Changes, ComparedRun, Judged, heaviest_first
from plumbline.harness.store.journal import StoreError
from plumbline.harness.store.machine_fingerprint import machine_digest
from plumbline.harness.store.store import Store


def compare(
    store_a: Store, store_b: Store, about: Callable[[Any], bool] = lambda _row: True, *, renamed: bool = False
) -> Changes:
    """All that differs from `store_a` to `store_b`, heaviest first.

    Args: about: of which rows of the table `trials` it is; prices of the others are clocked beside them all the same. renamed:
    as `matched` takes it.
    Raises: StoreError.
    """
    all_pairs = matched(store_a, store_b, renamed=renamed)
    every = [pair for pair in all_pairs if about(pair.either)]
    pairs = [pair for pair in every if pair.a is not None and pair.b is not None]
    answered = [pair for pair in pairs if not pair.lost]
    beside = [pair for pair in all_pairs if pair.a is not None and pair.b is not None]
    cells = {_cell(pair.b) for pair in answered}
    unread: list[str] = []
    of_groups = [
        *_where_kept(lambda: limit_changes(store_a, store_b), "limits", unread),
        *_where_kept(lambda: repetition_changes(store_a, store_b), "determinism", unread),
        *_where_kept(lambda: own_verdict_changes(store_a, store_b), "verdicts on scenes of one's own", unread),
    ]
    rows = [
        *answer_changes(store_a, store_b, pairs),
        *price_changes(store_a, store_b, beside, about),
        *(row for row in of_groups if _cell(row) in cells),
        *warning_changes(store_a, store_b, answered),
        *(row for row in version_changes(store_a, store_b) if row.engine in {pair.b.engine for pair in pairs}),
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
        judged=_judged(store_a, store_b, pairs),
        regained=tuple(str(pair.b.trial) for pair in pairs if pair.a.status in LOST and pair.b.status not in LOST),
        new=tuple(str(pair.b.trial) for pair in every if pair.a is None and getattr(pair.b, "round", 0) == 0),
    )


def _cell(row: Any) -> tuple[str, str, str]:
    """Case, engine and the track that a setting descends from."""
    return scene_of(str(row.case)), str(row.engine), str(row.track).partition(",")[0]


def _judged(store_a: Store, store_b: Store, pairs: Sequence[TrialPair]) -> dict[str, Judged]:
    """By engine, how much of these pairs could be judged."""
    judged = dict.fromkeys((str(pair.b.engine) for pair in pairs), Judged())
    for pair in pairs:
        if "unsupported" not in (pair.a.status, pair.b.status):
            judged[pair.b.engine] += Judged(answers=int(pair.a.status not in LOST), all_answers=1)
    stable = {id(pair) for pair in judged_prices(store_a, store_b, pairs)}
    for pair in clocked(pairs):
        judged[pair.b.engine] += Judged(prices=int(id(pair) in stable), all_prices=1)
    return judged


def _where_kept(read: Callable[[], Iterator[Change]], what: str, unread: list[str]) -> list[Change]:
    """What can be read off files that a history may not have kept."""
    try:
        return list(read())
    except StoreError as error:
        unread.append(f"{what}: {error}")
        return []


def _side(store: Store) -> ComparedRun:
    versions = store.trials.groupby("engine")["engine_version"].agg(lambda column: ", ".join(sorted(set(map(str, column)))))
    return ComparedRun(
        folder=str(store.folder),
        study=str(store.study.get("name", "")),
        started=str(store.machine.get("started", "")),
        machine=machine_digest(store.machine),
        trials=len(store.trials),
        versions=tuple((str(engine), str(version)) for engine, version in versions.items()),
    )
