"""What changed tonight: each engine in each block against the last night that saw it there; other answers to the same digest.

An answer that the night before had lost is compared with the last one that there was: else a fault would hide behind a crash.
What creeps is told against the night that told of it last, as a night is against the last one.
"""

import sys
from collections import Counter
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from typing import Any

from plumbline.harness.findings.changes import Change, Changes, Judged, compare
from plumbline.harness.findings.changes.matching import matched
from plumbline.harness.findings.changes.prices import price_changes
from plumbline.harness.findings.changes.values import heaviest_first
from plumbline.harness.findings.parameter_words import where_of
from plumbline.harness.findings.vendor_findings import SECONDS, Finding, ScriptAnswer, ask
from plumbline.harness.history.blocks import Key, SeenCell, cell_of, seen_cells
from plumbline.harness.history.folder import Night
from plumbline.harness.history.identity import Named, change_id, silenced
from plumbline.harness.history.regressions import MOST, Dated
from plumbline.harness.store.journal import DamagedFile
from plumbline.harness.store.machine_fingerprint import machine_digest
from plumbline.harness.store.store import Store

EARLIER = 3
"""Nights up to which back a question is looked for that the last night to see its cell was not asked: a narrower study may have
come in between."""


@dataclass(frozen=True, slots=True)
class News:
    """What changed.

    Terms: changes: what nobody has acknowledged; acknowledged: the others. since: of each the night that it is called by, from
    which on it is so. ended: ids of earlier changes that are over.
    """

    changes: Changes
    acknowledged: tuple[Change, ...]
    since: Mapping[Change, str] = field(default_factory=dict)
    ended: frozenset[str] = frozenset()

    def regressions(self, gated: Collection[str]) -> tuple[Change, ...]:
        """What of these engines is worse."""
        return self.changes.regressions(gated)


def news_of(
    store: Store,
    stamp: str,
    before: Sequence[Night],
    blocks: Collection[Key],
    known: Mapping[str, Named],
    earlier: Mapping[str, str],
    over: Callable[[Sequence[Change]], Sequence[Dated]] = lambda _rows: (),
) -> News | None:
    """What changed in a night; None where nothing of it was seen before.

    Args: store, stamp: of the night. before: whole nights, the earliest first. blocks: that it carried out.
    known: what was acknowledged. earlier: first nights of changes that last, by what they are called without one.
    over: of what the night tells by itself, what all nights tell beside it.
    Raises: StoreError.
    """
    differences = _compared(store, before, blocks)
    if not differences:
        return None
    others = {row.trial_b: row for row in _disagreements(store)}
    every = heaviest_first(
        dict.fromkeys(
            [*(row for difference in differences for row in difference.rows if not _left_aside(row, others)), *others.values()]
        )
    )
    every = heaviest_first([*every, *crept(store, before, every)])
    stamps = [*(night.stamp for night in before), stamp]
    since = {row: earlier.get(change_id(row, ""), stamp) for row in every}
    told = [row for row in every if silenced(Named.of(row, since[row]), known, stamps) is None]
    dated = over(every)
    fresh = {heaviest_first([change.first])[0]: change.stamp for change in dated if change.state == "open"}
    judged = [difference.judged for difference in differences]
    changes = replace(
        differences[0],
        b=replace(differences[0].b, trials=len(store.trials)),
        rows=heaviest_first([*told, *fresh]),
        matched=sum(difference.matched for difference in differences),
        same=sum(difference.same for difference in differences),
        clocked=sum(difference.clocked for difference in differences),
        unread=tuple(dict.fromkeys(text for difference in differences for text in difference.unread)),
        judged={
            engine: sum((each[engine] for each in judged if engine in each), Judged())
            for engine in dict.fromkeys(engine for each in judged for engine in each)
        },
    )
    return News(
        changes,
        tuple(row for row in every if row not in told),
        since | fresh,
        frozenset(change.id for change in dated if change.state != "open"),
    )


def _compared(store: Store, before: Sequence[Night], blocks: Collection[Key]) -> list[Changes]:
    """Each cell of tonight against the last night that saw it, the latest night first; what that one had lost, against those
    before it; and what was never asked under its name, against the last night that asked the same under another.

    What has no like at all could not be judged, and counts as that. Prices are those of the last night on this machine.
    """
    every = {str(row.trial): row for row in store.trials.itertuples() if (row.experiment, row.case) in blocks}
    unpaired = dict(every)
    differences = [*_looked_back(store, before, unpaired), *_looked_back(store, before, unpaired, renamed=True)]
    machine = machine_digest(store.machine)
    unpriced = unpaired
    if any(difference.a.machine != machine for difference in differences):
        unpriced = {trial: row for trial, row in every.items() if _clocked(row)}
        alone = _looked_back(store, [night for night in before if night.machine == machine], unpriced)
        differences = [*map(_without_prices, differences), *map(_prices_alone, alone)]
    judged: dict[str, Judged] = {}
    for trial, row in every.items():
        if row.round == 0 and row.status != "unsupported":
            new = Judged(all_answers=int(trial in unpaired), all_prices=int(trial in unpriced and _clocked(row)))
            judged[str(row.engine)] = judged.get(str(row.engine), Judged()) + new
    return differences and [*differences, replace(differences[0], rows=(), matched=0, same=0, clocked=0, judged=judged)]


def _clocked(row: Any) -> bool:
    return row.cpu_per_unit is not None and row.cpu_per_unit > 0


def _without_prices(difference: Changes) -> Changes:
    """Of another machine only answers can be compared."""
    judged = {engine: replace(each, prices=0, all_prices=0) for engine, each in difference.judged.items()}
    return replace(difference, rows=tuple(row for row in difference.rows if row.kind != "price"), clocked=0, judged=judged)


def _prices_alone(difference: Changes) -> Changes:
    """The prices of an earlier night on this machine, where answers are compared with another one's."""
    judged = {engine: replace(each, answers=0, all_answers=0) for engine, each in difference.judged.items()}
    rows = tuple(row for row in difference.rows if row.kind == "price")
    return replace(difference, rows=rows, matched=0, same=0, judged=judged)


def _looked_back(
    store: Store, before: Sequence[Night], unpaired: dict[str, Any], *, renamed: bool = False
) -> Iterator[Changes]:
    """What differs from each night back.

    Args: unpaired: rows of tonight by trial; those with a like go out of it. renamed: whatever study and experiment asked it.
    """

    def asked(cell: SeenCell) -> tuple[str, ...]:
        return cell[1:4] if renamed else cell

    waiting: dict[tuple[str, ...], set[str]] = {}
    for trial, row in unpaired.items():
        waiting.setdefault(asked(cell_of(row)), set()).add(trial)
    looked_at, rows = Counter[tuple[str, ...]](), dict(unpaired)
    for night in reversed(before):
        there: dict[tuple[str, ...], set[Key]] = {}
        compared: list[tuple[bool, Changes]] = []
        try:
            for cell, saw in seen_cells(night).items():
                question = asked(cell)
                # Where all was lost then, too, there is nothing that what was lost since could be compared with.
                if question in waiting and (not looked_at[question] or saw["lost"] < saw["trials"]):
                    there.setdefault(question, set()).add(cell[:2])
            for again in (False, True):
                mine = [question for question in there if bool(looked_at[question]) == again]
                if wanted := {trial for question in mine for trial in waiting[question]}:
                    then = night.store({key for question in mine for key in there[question]})
                    now = store.part({(rows[trial].experiment, rows[trial].case) for trial in wanted})
                    difference = compare(then, now, _among(wanted), renamed=renamed)
                    compared.append((again, difference))
                    for trial in wanted - {*difference.new}:
                        unpaired.pop(trial, None)
        except DamagedFile as error:
            print(f"{error}; what it said is left out", file=sys.stderr)
            continue
        yield from (_counted_already(each) if again else each for again, each in compared if each.matched or not renamed)
        looked_at.update(there.keys())
        lost = {trial for _, difference in compared for trial in difference.regained}
        new = {trial for _, difference in compared for trial in difference.new}
        for question in there:
            waiting[question] &= lost | new if looked_at[question] <= EARLIER else lost
        waiting = {question: trials for question, trials in waiting.items() if trials}
        if not waiting:
            return


def _among(trials: Collection[str]) -> Callable[[Any], bool]:
    """Is a row of the table `trials` one of these?"""
    return lambda row: row.trial in trials


def _counted_already(difference: Changes) -> Changes:
    """Differences without the counts of what an earlier one has counted: it adds what could be judged after all."""
    judged = {engine: replace(each, all_answers=0) for engine, each in difference.judged.items()}
    return replace(difference, matched=0, judged=judged)


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
            where=where_of(store.catalogue, row.case, row.parameters),
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


_ANSWERS = ("still there", "gone")


def asked_again(
    findings: Sequence[Finding],
    engines: Collection[str],
    left: Callable[[], float],
    answer: Callable[[Finding], ScriptAnswer] = ask,
) -> list[dict[str, Any]]:
    """Flat rows of those of these engines, as a night's file keeps them; none more once a hung one would not fit.

    Args: left: seconds of the budget that are left.
    """
    rows = []
    for finding in findings:
        if finding.engine in engines and left() > SECONDS:
            standing = answer(finding)
            rows.append(
                {"name": finding.name, "verdict": standing.verdict, "figure": standing.figure, "version": standing.version}
            )
    return rows


def turned(findings: Sequence[Finding], rows: Sequence[Mapping[str, Any]], plans: Iterable[Mapping[str, Any]]) -> list[str]:
    """A sentence for each that is gone or back: whose answer is another than the last one before. Args: plans: of the nights
    before, the earliest first."""
    before: dict[str, Mapping[str, Any]] = {}
    for plan in plans:
        before |= {row["name"]: row for row in plan.get("findings", ()) if row["verdict"] in _ANSWERS}
    titles = {finding.name: finding.title for finding in findings}
    return [
        f"{row['name']} is {'gone' if row['verdict'] == 'gone' else 'back'} ({_since(was['version'], row['version'])}): "
        f"{titles[row['name']]}; {row['figure']}"
        for row in rows
        if (was := before.get(row["name"])) is not None and row["verdict"] in _ANSWERS and row["verdict"] != was["verdict"]
    ]


def _since(before: str, now: str) -> str:
    """The versions of an engine at two answers, in words."""
    return f"with {now}" if now == before else f"{before} -> {now}"


def crept(store: Store, before: Sequence[Night], own: Sequence[Change]) -> list[Change]:
    """Prices of which tonight tells nothing by itself, and that are others than on the last night that told a change of them,
    or on the first of the nights on this machine that are read.

    Args: store: of tonight. before: whole nights, the earliest first. own: what tonight tells. Raises: StoreError.
    """
    clocked = {cell_of(row) for row in store.trials.itertuples() if row.cpu_per_unit is not None and row.cpu_per_unit > 0}
    bases, last = dict[SeenCell, tuple[Night, ...]](), dict[SeenCell, Night]()
    machine = machine_digest(store.machine)
    for night in (night for night in before[-MOST:] if night.machine == machine):
        changed = {(row["engine"], row["case"]) for row in night.plan.get("told", ()) if row["kind"] == "price"}
        for cell in seen_cells(night).keys() & clocked:
            last[cell] = night
            afresh = changed & {(cell[2], cell[1]), (cell[2], "")}
            bases[cell] = (night,) if afresh else (*bases.get(cell, ()), night)[:2]
    by_itself = {(row.engine, row.case) for row in own if row.kind == "price" and row.sense in ("worse", "better")}
    groups: dict[tuple[Night, ...], set[SeenCell]] = {}
    for cell, base in bases.items():
        if len(base) == 2 and last[cell] not in base:
            groups.setdefault((*base, last[cell]), set()).add(cell)
    rows = list[Change]()
    for nights, cells in groups.items():
        keys = {cell[:2] for cell in cells}
        try:
            stores = [*(night.store(keys) for night in nights), store.part(keys)]
            changes = lasting(partial(price_changes_of, stores, cells))
        except DamagedFile as error:
            print(f"{error}; what it said is left out", file=sys.stderr)
            continue
        rows += [replace(row, detail=f"since {nights[0].stamp}") for row in changes]
    return [row for row in rows if not by_itself & {(row.engine, row.case), (row.engine, "")}]


def lasting(changes: Callable[[int, int], Iterable[Change]]) -> list[Change]:
    """What tonight tells since a night, and would tell since the next one, and what last night told since both: else one noisy
    night, as it comes now and then, would be told against all others.

    Args: changes: what changed from one to another of four nights, by their numbers: the first two, last night and tonight.
    """
    rows = [row for row in changes(0, 3) if row.sense in ("worse", "better")]
    for base, late in ((1, 3), (0, 2), (1, 2)):
        same = {_about(row) for row in changes(base, late)} if rows else ()
        rows = [row for row in rows if _about(row) in same]
    return rows


def _about(row: Change) -> tuple[object, ...]:
    return row.engine, row.case, row.track, row.where, row.dt, row.sense


def price_changes_of(stores: Sequence[Store], cells: Collection[SeenCell], base: int, late: int) -> Iterator[Change]:
    """What is told of the prices of these cells from one night to another, by their numbers among the stores."""
    then, now = stores[base], stores[late]
    pairs = [pair for pair in matched(then, now) if pair.a is not None and pair.b is not None]
    return price_changes(then, now, pairs, lambda row: cell_of(row) in cells)
