"""Slow drift of prices over the nights, which no single night shows; reported once.

What creeps is told against the night that told of it last, as a night is against the last one; what lies on levels of its own
is found over all nights.
"""

import sys
import time
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import replace
from functools import partial

from plumbline.harness.findings.changes import Change
from plumbline.harness.findings.changes.matching import matched
from plumbline.harness.findings.changes.prices import price_changes
from plumbline.harness.history.blocks import SeenCell, cell_of, seen_cells
from plumbline.harness.history.folder import History, Night
from plumbline.harness.history.identity import Named
from plumbline.harness.history.readings import said_by, table_of
from plumbline.harness.history.regressions import Dated, date, named_by
from plumbline.harness.history.series import series_of
from plumbline.harness.history.steps import CHANCE_OF_ALL, price_steps
from plumbline.harness.store.journal import DamagedFile
from plumbline.harness.store.machine_fingerprint import machine_digest
from plumbline.harness.store.store import Store

MOST = 90
"""Nights that are read: prices of a season ago are of another machine or version by now."""
FEWEST = 16
"""Nights, tonight among them: the spread of fewer is too uncertain for a test that is repeated every night. Of 28 histories
without a change, looked at in each of their nights from the eighth on, one told a step, in its twelfth."""
SHARE = 0.5
"""Of what is left of a budget, at most, for reading earlier nights."""


def over_nights(
    history: History,
    before: Sequence[Night],
    tonight: Night,
    store: Store,
    known: Mapping[str, Named],
    own: Sequence[Change],
    left: float,
) -> tuple[Dated, ...]:
    """Regressions of prices that last, that nobody acknowledged and that no night has told, as open ones; and those that a
    later night took back, or whose engine is another by now.

    Args: before: whole nights of the history, the earliest first. store: of tonight. known: what was acknowledged. own: what
    tonight tells by itself. left [s]: of the budget; where reading takes more than half of it, the earliest nights are left.
    Raises: StoreError.
    """
    late = list(before[-MOST:])
    if len(late) + 1 < FEWEST:
        return ()
    begun, contents = time.monotonic(), [said_by(history, tonight, store)]
    for night in reversed(late):
        if time.monotonic() - begun > left * SHARE:
            break
        with suppress(DamagedFile):  # what reads all nights names it
            contents.insert(0, said_by(history, night, night.store()))
    if len(contents) < FEWEST:
        return ()
    # A night looks at what the nights before it have looked at: each has its share of the chance of the history.
    nights = [content["night"] for content in contents]
    steps = tuple(price_steps(series_of(nights, table_of(contents), {"price"}), CHANCE_OF_ALL / len(contents)))
    stamps = {night.stamp for night in nights}
    told = [
        *named_by(night.plan for night in late if night.stamp in stamps),
        *(Named.of(row, tonight.stamp) for row in own),
    ]
    fresh: list[Dated] = []
    while True:
        # What is told of one is told of what goes on with it: a drift has several steps, and one name.
        names = [*told, *(Named.of(one.first, one.stamp) for one in fresh)]
        dated = date(nights, steps, known, names)
        untold = next((one for one in dated if one.first.regression and one.state == "open" and not one.told), None)
        if untold is None:
            break
        fresh.append(untold)
    rows = (replace(one.first, detail=f"over all nights, on this level since {one.stamp}") for one in fresh)
    ended = (change for change in dated if change.state in ("mended", "another version"))
    return *(replace(change, changes=(row,)) for change, row in zip(fresh, rows, strict=True)), *ended


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
