"""What changed over a history, told once: each change with its first night, who acknowledged it, and whether it lasts.

A night looks at the prices of all nights before it, too: for what no single night shows.
"""

import math
import time
from collections.abc import Collection, Iterable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any, Literal

import numpy as np

from plumbline.harness.findings.changes import Change
from plumbline.harness.findings.changes.answers import as_good
from plumbline.harness.findings.changes.values import heaviest_first
from plumbline.harness.findings.changes.words import command_in, sentence, titled
from plumbline.harness.history.folder import History, Night
from plumbline.harness.history.identity import NEAR, Named, acknowledged, change_id, silenced
from plumbline.harness.history.readings import Content, NightOf, said_by, table_of
from plumbline.harness.history.steps import CHANCE_OF_ALL, PriceStep, Series, exact_steps, over_segments, price_steps, series_of
from plumbline.harness.statistics.change_points import levelled, one_drift
from plumbline.harness.store.journal import DamagedFile
from plumbline.harness.store.store import Store

State = Literal["open", "acknowledged", "mended", "another version"]
"""Of a regression: nobody said anything of it yet; somebody did; a later night took it back; its engine or machine is another
by now, on which nothing is known of it."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Dated:
    """A change with its night.

    Terms: id: as `plumbline history ack` takes it. night: index of the first one. stamp, folder: of it. changes: those of one
    kind, case, engine, track, metric and night, the heaviest first. until: index of the night that ended it, None while it
    lasts. note: of who acknowledged it.
    """

    id: str
    night: int
    stamp: str
    folder: str
    changes: tuple[Change, ...]
    state: State
    until: int | None = None
    told: bool = False
    note: str = ""

    @property
    def first(self) -> Change:
        """The heaviest."""
        return self.changes[0]

    def sentence(self, titles: Mapping[str, str] | None = None) -> str:
        """In words, with how many others there are. Args: titles: as `titled` takes them; none where names shall be those that
        commands take."""
        more = len(self.changes) - 1
        first = self.first if titles is None else titled(self.first, titles)
        return sentence(first) + (f" Likewise {more} more of this case, at other steps or parameters." if more else "")

    @property
    def command(self) -> str:
        """What shows it again."""
        return command_in(self.first, self.folder)


@dataclass(frozen=True, eq=False)
class Trends:
    """A history as people look at it.

    Terms: root: its folder. nights: the earliest first. series: of them, steps: of prices. dated: every change, by its night.
    titles: of cases and engines by name, as the last night that has them calls them. unread: what is left out, and why.
    """

    root: str
    nights: tuple[NightOf, ...]
    series: tuple[Series, ...]
    steps: tuple[PriceStep, ...]
    dated: tuple[Dated, ...]
    titles: Mapping[str, str] = field(default_factory=dict)
    unread: tuple[DamagedFile, ...] = ()

    def called(self, name: str) -> str:
        """The title of a case or an engine; its name where no night has one."""
        return self.titles.get(name, name)

    @cached_property
    def regressions(self) -> tuple[Dated, ...]:
        """What got worse, first bad night first."""
        return tuple(one for one in self.dated if one.first.regression)

    def standing(self, engines: Iterable[str] = ()) -> tuple[Dated, ...]:
        """Regressions that last and that nobody acknowledged, of these engines or of all."""
        gated = set(engines)
        return tuple(one for one in self.regressions if one.state == "open" and (not gated or one.first.engine in gated))


def read_trends(history: History) -> Trends:
    """Read every whole night of a history and judge its series. Raises: StoreError, OSError."""
    over, contents, unread = list[Night](), list[Content](), list[DamagedFile]()
    for night in history.each():
        if isinstance(night, DamagedFile):
            unread.append(night)
        elif night.plan.get("complete", True):  # a run folder that was put there by hand has no plan
            try:
                contents.append(said_by(history, night, night.store()))
            except DamagedFile as error:
                unread.append(error)
            else:
                over.append(night)
    nights, table = tuple(content["night"] for content in contents), table_of(contents)
    series = series_of(nights, table)
    steps = *exact_steps(over, table), *price_steps(series)
    return Trends(
        root=str(history.root),
        nights=nights,
        series=series,
        steps=tuple(step for step in steps if step.members),
        dated=date(nights, steps, acknowledged(history)[0], named_by(night.plan for night in over if night.whole)),
        titles={name: title for night in nights for name, title in (night.titles or {}).items()},
        unread=tuple(unread),
    )


def named_by(plans: Iterable[Any]) -> list[Named]:
    """The changes that nights have told, as they called them. Args: plans: of the nights."""
    return [Named.told(row) for plan in plans for row in plan.get("told", ())]


def date(
    nights: Sequence[NightOf], steps: Sequence[PriceStep], known: Mapping[str, Named], named: Collection[Named] = ()
) -> tuple[Dated, ...]:
    """Steps as dated changes: alike ones of one night are one, the earliest first.

    Args: known: what was acknowledged. named: what nights have told, under whose names it goes on.
    """
    grouped: dict[tuple[int, str], list[PriceStep]] = {}
    for step in steps:
        if step.change.sense in ("worse", "better"):
            grouped.setdefault((step.night, change_id(step.change, nights[step.night].stamp)), []).append(step)
    stamps = [night.stamp for night in nights]
    made = []
    for (night, name), group in grouped.items():
        first = group[0].change
        until, state = _end(group, steps, nights)
        same = [other for other in named if _same(other, name, group[0], stamps, steps)]
        seen = [entry for entry in known.values() if _same(entry, name, group[0], stamps, steps)]
        own = next((other.id for other in [*same, *seen] if other.case == first.case or other.id == name), name)
        entry = next((known[other.id] for other in [*seen, *same] if other.id in known), None)
        entry = entry or silenced(Named.of(first, stamps[night]), known, stamps)
        made.append(
            Dated(
                id=own,
                night=night,
                stamp=stamps[night],
                folder=nights[night].folder,
                changes=heaviest_first([step.change for step in group]),
                state="acknowledged" if state == "open" and entry is not None else state,
                until=until,
                told=bool(same),
                note="" if entry is None else entry.note,
            )
        )
    return tuple(sorted(made, key=lambda each: (each.night, -each.first.weight, each.id)))


def _same(other: Named, name: str, step: PriceStep, stamps: Sequence[str], steps: Sequence[PriceStep]) -> bool:
    """Is it the change of this name, or one of a price that contains it, of a night nearby or on one slope with it?"""
    if other.id == name:
        return True
    if not other.contains(step.change) or other.since not in stamps:
        return False
    index = stamps.index(other.since)
    return abs(index - step.night) <= NEAR or _one_slope(step, min(index, step.night), max(index, step.night), steps)


def _one_slope(step: PriceStep, first: int, second: int, steps: Sequence[PriceStep]) -> bool:
    """Is what lies between two nights one slope, by the prices of a step, between the steps the other way beside it?"""
    if not step.members:
        return False
    segments = np.max([each.segments for each in step.members], axis=0)
    values = levelled(np.array([over_segments(each.free, each.segments) for each in step.members]))
    about = (step.change.engine, step.change.case)
    prices = (other for other in steps if other.members and (other.change.engine, other.change.case) == about)
    back = [other.night for other in prices if other.change.sense != step.change.sense]
    if segments[first] != segments[second] or any(first < night <= second for night in back):
        return False
    nights = np.arange(len(values))
    begin = max([night for night in back if night <= first], default=0)
    end = min([night for night in back if night > second], default=len(values))
    values[(segments != segments[second]) | (nights < begin) | (nights >= end)] = np.nan
    return one_drift(values, first, second)


def _end(group: Sequence[PriceStep], steps: Sequence[PriceStep], nights: Sequence[NightOf]) -> tuple[int | None, State]:
    """The night on which all of the group was taken back or became another matter, if any."""
    ends = [_mended(step, steps) for step in group]
    if None not in ends:
        return max(end for end in ends if end is not None), "mended"
    if group[0].change.kind == "price":
        night, engine = group[0].night, group[0].change.engine
        first = nights[night]
        for later, now in enumerate(nights[night + 1 :], night + 1):
            if engine in now.versions and (now.machine, now.versions[engine]) != (first.machine, first.versions.get(engine)):
                return later, "another version"
    return None, "open"


def _mended(step: PriceStep, steps: Sequence[PriceStep]) -> int | None:
    """The first later night that took it back: by the same kind of change the other way; of a price, by most of its size."""
    change = step.change
    size = math.log(change.ratio) if change.kind == "price" and change.ratio else 0.0
    for later in sorted(steps, key=lambda each: each.night):
        other = later.change
        if later.night <= step.night or _about(other) != _about(change) or {change.sense, other.sense} != {"worse", "better"}:
            continue
        if change.kind == "verdict" and change.sense == "worse" and not as_good(str(other.after), str(change.before)):
            continue
        if not size or not other.ratio:
            return later.night
        size += math.log(other.ratio)
        if abs(size) <= abs(math.log(change.ratio or 1.0)) / 2:
            return later.night
    return None


def _about(change: Change) -> tuple[object, ...]:
    return change.kind, change.case, change.engine, change.track, change.where, change.dt


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
    told = [*named_by(night.plan for night in late if night.stamp in stamps), *(Named.of(row, tonight.stamp) for row in own)]
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
