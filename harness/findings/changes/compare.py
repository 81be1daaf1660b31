"""Two run folders side by side: what of the second differs from the first, and what its answers came about by: versions,
sources, settings, the machine, which trials there are, and what was warned of.
"""

import json
from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any

from plumbline.harness.findings.changes.answers import answer_changes
from plumbline.harness.findings.changes.matching import LOST, TrialPair, matched, requested, scene_of
from plumbline.harness.findings.changes.prices import clocked, judged_prices, price_changes
from plumbline.harness.findings.changes.studied import limit_changes, own_verdict_changes, repetition_changes
from plumbline.harness.findings.changes.values import Change, ChangeKind, Changes, ComparedRun, Judged, Sense, heaviest_first
from plumbline.harness.findings.parameter_words import substeps_of
from plumbline.harness.store.journal import StoreError
from plumbline.harness.store.machine_fingerprint import machine_digest
from plumbline.harness.store.record import StoredNotice
from plumbline.harness.store.store import Store

_MACHINE = ("processor", "cores", "memory_mb", "system", "python")


def version_changes(store_a: Store, store_b: Store) -> Iterator[Change]:
    """A row for each engine on both sides whose versions are others."""
    before, after = (_versions(store) for store in (store_a, store_b))
    for engine in after:
        if engine in before and before[engine] != after[engine]:
            yield Change(kind="version", sense="neither", engine=engine, before=before[engine], after=after[engine])


def _versions(store: Store) -> dict[str, str]:
    answered = store.trials[store.trials["status"] != "unavailable"]
    return {
        str(engine): ", ".join(sorted(set(map(str, group["engine_version"])))) for engine, group in answered.groupby("engine")
    }


def source_changes(pairs: Sequence[TrialPair]) -> Iterator[Change]:
    """A row for each text that answers rest on and that is another: an adapter by engine, a case by name, others once."""

    def about(row: Any, origin: str) -> dict[str, str]:
        return {"engine": row.engine if origin == "adapter" else "", "case": row.case if origin == "case" else ""}

    def read(row: Any) -> dict[str, str]:
        sources = json.loads(getattr(row, "sources", "{}"))
        return {origin: digest for origin, digest in sources.items() if origin != "acting"}

    return _counted("sources", pairs, read, about, "")


def setting_changes(pairs: Sequence[TrialPair]) -> Iterator[Change]:
    """A row for each setting of an engine's track that was asked for otherwise."""

    def asked(row: Any) -> dict[str, Any]:
        settings = requested(row)
        options = settings.pop("options", None) or {}
        return settings | {f"option {name}": value for name, value in options.items()}

    return _counted("settings", pairs, asked, lambda row, _: {"engine": row.engine, "track": row.track}, None)


def _counted(
    kind: ChangeKind,
    pairs: Sequence[TrialPair],
    read: Callable[[Any], Mapping[str, Any]],
    about: Callable[[Any, str], Mapping[str, Any]],
    none: str | None,
) -> Iterator[Change]:
    """A row for each thing that trials say otherwise, with how many. Args: read: things by name. about: what a row is of."""
    counts: Counter[Change] = Counter()
    for pair in pairs:
        then, now = read(pair.a), read(pair.b)
        for name in {**now, **then}:
            before, after = then.get(name, none), now.get(name, none)
            if then.get(name) != now.get(name):
                where = about(pair.b, name)
                counts[Change(kind=kind, sense="neither", **where, metric=name, before=str(before), after=str(after))] += 1
    yield from (replace(change, count=count) for change, count in counts.items())


def machine_changes(store_a: Store, store_b: Store) -> Iterator[Change]:
    """A row for each property of the machine, and each package, that is another."""
    then, now = store_a.machine, store_b.machine
    packages = [machine.get("packages") or {} for machine in (then, now)]
    pairs = [(name, then.get(name), now.get(name)) for name in _MACHINE]
    pairs += [(name, packages[0].get(name), packages[1].get(name)) for name in {**packages[0], **packages[1]}]
    for name, before, after in pairs:
        if before != after:
            yield Change(kind="machine", sense="neither", metric=name, before=str(before), after=str(after))


def trial_changes(pairs: Sequence[TrialPair]) -> Iterator[Change]:
    """A row for each case and engine that has trials on one side only: how many A had of them, and how many B has."""
    alone: dict[tuple[str, str, str], list[int]] = {}
    for pair in pairs:
        if pair.a is None or pair.b is None:
            row = pair.either
            alone.setdefault((row.case, row.engine, row.track), [0, 0])[pair.a is None] += 1
    for (case, engine, track), (gone, new) in alone.items():
        yield Change(
            kind="trials", sense="neither", case=case, engine=engine, track=track, before=float(gone), after=float(new),
            unit="1", count=gone + new,
        )  # fmt: skip


def warning_changes(store_a: Store, store_b: Store, pairs: Sequence[TrialPair]) -> Iterator[Change]:
    """A row for each warning that came, went, or has other words in a case on an engine; what the clock ran into is none."""
    noticed: dict[tuple[str, str, str, StoredNotice, bool, bool], list[TrialPair]] = {}
    for pair in pairs:
        then, now = _said(store_a, pair.a), _said(store_b, pair.b)
        old, new = ({_about(notice) for notice in side if notice.kind != "note"} for side in (then, now))
        for notice in then ^ now:
            before, after = (notice in side or _about(notice) in about for side, about in ((then, old), (now, new)))
            if notice in now or not after:
                noticed.setdefault((pair.b.case, pair.b.engine, pair.b.track, notice, before, after), []).append(pair)
    for (case, engine, track, notice, before, after), where in noticed.items():
        sense: Sense = "neither" if notice.kind == "note" or before == after else "worse" if after else "better"
        named = notice.effect or notice.kind
        yield Change(
            kind="warning", sense=sense, case=case, engine=engine, track=track, metric=notice.kind, count=len(where),
            before=named if before else None, after=named if after else None,
            trial_a=str(where[0].a.trial), trial_b=str(where[0].b.trial), dt=float(where[0].b.dt),
            substeps=substeps_of(str(where[0].b.resolved)), detail=notice.text,
        )  # fmt: skip


def _about(notice: StoredNotice) -> tuple[str, str]:
    """What a notice is of, in whatever words."""
    return notice.kind, notice.effect


def _said(store: Store, row: Any) -> set[StoredNotice]:
    clock = f"timing: {getattr(row, 'timing_note', '')}"
    return {notice for notice in store.notices.get(str(row.trial), ()) if notice.text != clock}


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
