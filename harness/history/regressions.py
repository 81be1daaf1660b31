"""What changed over a history, told once: each change with its first night, who acknowledged it, and whether it lasts."""

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Literal

from harness.findings.changes import Change
from harness.findings.changes.weights import heaviest_first
from harness.findings.changes.words import command_in, sentence
from harness.history.acknowledged import Acknowledgement, acknowledged, change_id
from harness.history.exact_changes import ExactChanges
from harness.history.folder import History
from harness.history.price_steps import PriceStep, price_steps
from harness.history.series import NightOf, Readings, Series

__all__ = ["Dated", "State", "Trends", "read_trends"]

State = Literal["open", "acknowledged", "mended", "another version"]
"""Of a regression: nobody said anything of it yet; somebody did; a later night took it back; its engine or machine is another
by now, on which nothing is known of it."""

_NEAR = 3
"""Nights by which the night of a step may still move as more nights come: what it was acknowledged by may be off by as many."""


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
    note: str = ""
    when: str = ""

    @property
    def first(self) -> Change:
        """The heaviest."""
        return self.changes[0]

    @property
    def sentence(self) -> str:
        """In words, with how many others there are."""
        more = len(self.changes) - 1
        return sentence(self.first) + (f" So {more} more of the same case, at other steps or parameters." if more else "")

    @property
    def command(self) -> str:
        """What shows it again."""
        return command_in(self.first, self.folder)


@dataclass(frozen=True, eq=False)
class Trends:
    """A history as people look at it. Terms: root: its folder. nights: the earliest first. series, steps: of them. dated: every
    change, by its night."""

    root: str
    nights: tuple[NightOf, ...]
    series: tuple[Series, ...]
    steps: tuple[PriceStep, ...]
    dated: tuple[Dated, ...]

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
    readings, exact = Readings(), ExactChanges()
    for night in history.nights():
        if night.plan.get("complete", True):  # a run folder that was put there by hand has no plan
            store = night.store()
            readings.add(night, store)
            exact.add(night, store)
    series = readings.series()
    steps = tuple(price_steps(series))
    nights = tuple(readings.nights)
    dated = date(nights, [*exact.changes, *((step.night, step.change) for step in steps)], acknowledged(history))
    return Trends(root=str(history.root), nights=nights, series=series, steps=steps, dated=dated)


def date(
    nights: Sequence[NightOf], changes: Iterable[tuple[int, Change]], known: Mapping[str, Acknowledgement]
) -> tuple[Dated, ...]:
    """Changes, each with the index of its night, as dated ones: alike ones of one night are one, the earliest first."""
    every = list(changes)
    grouped: dict[tuple[int, str], list[Change]] = {}
    for night, change in every:
        if change.sense in ("worse", "better"):
            grouped.setdefault((night, change_id(change, nights[night].stamp)), []).append(change)
    made = []
    for (night, name), group in grouped.items():
        until, state = _end(night, group, every, nights)
        entry = _acknowledged(night, group[0], nights, known)
        made.append(
            Dated(
                id=name,
                night=night,
                stamp=nights[night].stamp,
                folder=nights[night].folder,
                changes=heaviest_first(group),
                state="acknowledged" if state == "open" and entry is not None else state,
                until=until,
                note="" if entry is None else entry.note,
                when="" if entry is None else entry.when,
            )
        )
    return tuple(sorted(made, key=lambda one: (one.night, -one.first.weight, one.id)))


def _acknowledged(
    night: int, change: Change, nights: Sequence[NightOf], known: Mapping[str, Acknowledgement]
) -> Acknowledgement | None:
    """By its own id, or, of a step in a price, by that of a night nearby."""
    near = range(max(0, night - _NEAR), min(len(nights), night + _NEAR + 1)) if change.kind == "price" else ()
    ids = (change_id(change, nights[k].stamp) for k in (night, *near))
    return next((known[name] for name in ids if name in known), None)


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
        if not size or not other.ratio:
            return later
        size += math.log(other.ratio)
        if abs(size) <= abs(math.log(change.ratio or 1.0)) / 2:
            return later
    return None
