"""Slow drift of prices over the nights, which no single night shows; reported once."""

import time
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import replace

from plumbline.harness.findings.changes import Change
from plumbline.harness.history.folder import History, Night
from plumbline.harness.history.identity import Named
from plumbline.harness.history.readings import said_by, table_of
from plumbline.harness.history.regressions import Dated, date, named_by
from plumbline.harness.history.series import series_of
from plumbline.harness.history.steps import CHANCE_OF_ALL, price_steps
from plumbline.harness.store.journal import DamagedFile
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
    ended = (one for one in dated if one.state in ("mended", "another version"))
    return *(replace(one, changes=(row,)) for one, row in zip(fresh, rows, strict=True)), *ended
