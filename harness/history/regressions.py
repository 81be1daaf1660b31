"""What changed over a history, told once: each change with its first night, who acknowledged it, and whether it lasts."""

import math
from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any, Literal, TypeAlias

import numpy as np

from plumbline.harness.findings.changes import Change
from plumbline.harness.findings.changes.answers import as_good
from plumbline.harness.findings.changes.weights import heaviest_first
from plumbline.harness.findings.changes.words import command_in, sentence, titled
from plumbline.harness.history.acknowledged import Acknowledgement, acknowledged, silenced
from plumbline.harness.history.exact_changes import exact_changes
from plumbline.harness.history.folder import History, Night
from plumbline.harness.history.identity import NEAR, Named, change_id
from plumbline.harness.history.kept_readings import kept_readings
from plumbline.harness.history.night_readings import NightOf, Readings
from plumbline.harness.history.normalisation import over_segments
from plumbline.harness.history.price_steps import PriceStep, price_steps
from plumbline.harness.history.series import Series, series_of
from plumbline.harness.statistics.change_points import levelled
from plumbline.harness.statistics.drift import one_drift
from plumbline.harness.store.journal import DamagedFile

State = Literal["open", "acknowledged", "mended", "another version"]
"""Of a regression: nobody said anything of it yet; somebody did; a later night took it back; its engine or machine is another
by now, on which nothing is known of it."""

SameSlope: TypeAlias = Callable[[Change, int, int], bool]
"""Of a step in a price and the indices of two nights: is what lies between them one slope?"""


@dataclass(frozen=True, slots=True, kw_only=True)
class Dated:
    """A change with its night.

    Terms: id: as `plumbline history ack` takes it. night: index of the first one. stamp, folder: of it. changes: those of one
    kind, case, engine, track, metric and night, the heaviest first. until: index of the night that ended it, None while it
    lasts. note, when: of who acknowledged it.
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
    when: str = ""

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

    Terms: root: its folder. nights: the earliest first. series, steps: of them. dated: every change, by its night. titles: of
    cases and engines by their names, as the last night that has them calls them. unread: what is left out, and why.
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
    # A run folder that was put there by hand has no plan.
    unread = list(history.unread())
    over, readings = list[Night](), list[Readings]()
    for night in history.nights():
        if night.plan.get("complete", True):
            try:
                readings.append(kept_readings(history, night, night.store()))
            except DamagedFile as error:
                unread.append(error)
            else:
                over.append(night)
    titles = {name: title for reading in readings for name, title in (reading.night.titles or {}).items()}
    series = series_of(readings)
    steps = tuple(price_steps(series))
    nights = tuple(reading.night for reading in readings)
    every = [*exact_changes(over, readings), *((step.night, step.change) for step in steps)]
    plans = [night.plan for night in over if night.whole]
    dated = date(nights, every, acknowledged(history), named_by(plans), same_slope(steps))
    return Trends(
        root=str(history.root), nights=nights, series=series, steps=steps, dated=dated, titles=titles, unread=tuple(unread)
    )


def named_by(plans: Iterable[Any]) -> list[Named]:
    """The changes that nights have told, as they called them. Args: plans: of the nights."""
    return [Named.told(row) for plan in plans for row in plan.get("told", ())]


def same_slope(steps: Sequence[PriceStep]) -> SameSlope:
    """By the prices of a step's own members, between the steps the other way beside it."""
    members = {step.change: step.members for step in steps}

    def same(change: Change, first: int, second: int) -> bool:
        group = members[change]
        segments = np.max([one.segments for one in group], axis=0)
        values = levelled(np.array([over_segments(one.free, one.segments) for one in group]))
        back = [
            step.night
            for step in steps
            if (step.change.engine, step.change.case) == (change.engine, change.case) and step.change.sense != change.sense
        ]
        nights = np.arange(len(values))
        begin = max([night for night in back if night <= first], default=0)
        end = min([night for night in back if night > second], default=len(values))
        if segments[first] != segments[second] or any(first < night <= second for night in back):
            return False
        values[(segments != segments[second]) | (nights < begin) | (nights >= end)] = np.nan
        return one_drift(values, first, second)

    return same


def date(
    nights: Sequence[NightOf],
    changes: Iterable[tuple[int, Change]],
    known: dict[str, Acknowledgement],
    named: Collection[Named] = (),
    slope: SameSlope = lambda _change, _first, _second: False,
) -> tuple[Dated, ...]:
    """Changes, each with the index of its night, as dated ones: alike ones of one night are one, the earliest first.

    Args: known: what was acknowledged. named: what nights have told, under whose names it goes on. slope: see `SameSlope`.
    """
    every = list(changes)
    grouped: dict[tuple[int, str], list[Change]] = {}
    for night, change in every:
        if change.sense in ("worse", "better"):
            grouped.setdefault((night, change_id(change, nights[night].stamp)), []).append(change)
    stamps = [night.stamp for night in nights]
    made = []
    for (night, name), group in grouped.items():
        until, state = _end(night, group, every, nights)
        same = [other for other in named if _same(other, night, name, group[0], stamps, slope)]
        seen = [entry.what for entry in known.values() if _same(entry.what, night, name, group[0], stamps, slope)]
        own = next((other.id for other in [*same, *seen] if other.case == group[0].case or other.id == name), name)
        called = Named.of(group[0], nights[night].stamp)
        entry = next((known[other.id] for other in [*seen, *same] if other.id in known), None)
        entry = entry or silenced(called, known, stamps)
        made.append(
            Dated(
                id=own,
                night=night,
                stamp=nights[night].stamp,
                folder=nights[night].folder,
                changes=heaviest_first(group),
                state="acknowledged" if state == "open" and entry is not None else state,
                until=until,
                told=bool(same),
                note="" if entry is None else entry.note,
                when="" if entry is None else entry.when,
            )
        )
    return tuple(sorted(made, key=lambda one: (one.night, -one.first.weight, one.id)))


def _same(other: Named, night: int, name: str, change: Change, stamps: Sequence[str], slope: SameSlope) -> bool:
    """Is it the change of this name, or one of a price that contains it, of a night nearby or on one slope with it?"""
    if other.id == name:
        return True
    if not other.contains(change) or other.since not in stamps:
        return False
    index = stamps.index(other.since)
    return abs(index - night) <= NEAR or slope(change, min(index, night), max(index, night))


def _end(
    night: int, group: Sequence[Change], every: Sequence[tuple[int, Change]], nights: Sequence[NightOf]
) -> tuple[int | None, State]:
    """The night on which all of the group was taken back or became another matter, if any."""
    ends = [_mended(night, change, every) for change in group]
    if None not in ends:
        return max(end for end in ends if end is not None), "mended"
    if group[0].kind == "price":
        first = nights[night]
        engine = group[0].engine
        for later in range(night + 1, len(nights)):
            now = nights[later]
            if engine in now.versions and (now.machine, now.versions[engine]) != (first.machine, first.versions.get(engine)):
                return later, "another version"
    return None, "open"


def _mended(night: int, change: Change, every: Sequence[tuple[int, Change]]) -> int | None:
    """The first later night that took it back: by the same kind of change the other way; of a price, by most of its size."""
    size = math.log(change.ratio) if change.kind == "price" and change.ratio else 0.0
    for later, other in sorted(every, key=lambda entry: entry[0]):
        same = (change.kind, change.case, change.engine, change.track, change.where, change.dt) == (
            (other.kind, other.case, other.engine, other.track, other.where, other.dt)
        )
        if later <= night or not same or {change.sense, other.sense} != {"worse", "better"}:
            continue
        if change.kind == "verdict" and change.sense == "worse" and not as_good(str(other.after), str(change.before)):
            continue
        if not size or not other.ratio:
            return later
        size += math.log(other.ratio)
        if abs(size) <= abs(math.log(change.ratio or 1.0)) / 2:
            return later
    return None
