"""Every step of a series over the nights, told once: of what is exact, each night on which it is another than the last time; of
prices, the nights from which on they lie on another level: of an engine as a whole, of a case on it, or of one series.

What moves together is judged together: series of one case on one engine as one of less noise, and their medians as the engine.
A step counts for the group where most of its members take it; it is then taken out of them before they are judged alone.

A series is what each night said of a price, error or limit, in segments of one machine and one version. Prices are divided by
how far the night moved the other engines, or the canary where there are too few. Each other engine has one vote, the common
motion of its series, and the canary another. The median of the votes is free of one engine that changed, however many series it
has, but as noisy as a vote; the mean of the engines' votes is not, where none is counted for more than three median departures
from that median.
"""

import json
import math
import warnings
from collections.abc import Collection, Generator, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from typing import Any, get_args

import numpy as np
import pandas as pd
from numpy.typing import NDArray
from pydantic import TypeAdapter

from plumbline.harness.findings.changes import Change
from plumbline.harness.findings.changes.answers import answer_changes
from plumbline.harness.findings.changes.matching import LOST, TrialPair, by_question
from plumbline.harness.findings.changes.studied import lost_and_won, moved_limits
from plumbline.harness.findings.changes.values import Beside
from plumbline.harness.findings.limits_found import Search
from plumbline.harness.findings.tables.determinism import Repetition
from plumbline.harness.history.folder import Night
from plumbline.harness.history.readings import EXACT, SUBJECT, Measured, NightOf, answer_key
from plumbline.harness.statistics.change_points import FEWEST, ChangePoint, change_points, common_mode, levelled
from plumbline.harness.trajectory import Floats

FEWEST_OTHERS = 2
"""Other engines: with the canary three votes, of which one may be wrong."""
CLIP = 3.0
"""A vote further from the middle than so many median departures is not counted."""


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Series:
    """One number over all nights.

    Terms:
        experiment, where, track, dt [s]: as in a change; metric, unit: of its values.
        values (n,): NaN where a night has none. over (n,): what prices are divided by to be free of what the machine did to all
        of them, 1 for anything else; beside: what that was. segments (n,): nights of one number share machine and version; -1
        where there is no value. trials: of each night, '' for none. hashes: of trajectories, likewise.
    """

    kind: Measured
    experiment: str
    case: str
    where: str
    engine: str
    track: str
    dt: float
    metric: str
    unit: str
    values: Floats
    over: Floats
    beside: Beside
    segments: NDArray[np.int64]
    trials: tuple[str, ...]
    hashes: tuple[str, ...]

    @property
    def free(self) -> Floats:
        """The values over what they were divided by, shape (n,)."""
        quotients: Floats = self.values / self.over
        return quotients


def series_of(
    nights: Sequence[NightOf], table: pd.DataFrame, kinds: Collection[Measured] = get_args(Measured)
) -> tuple[Series, ...]:
    """All series of these kinds, in the order in which they were first seen; prices with what they are divided by.

    Args: table: of these nights, as `table_of` gives it.
    """
    table = table[table["kind"].isin(kinds)]
    table = table.assign(series=pd.factorize(table["key"])[0]).sort_values(["series", "night"], kind="stable")
    # Numbers of segments are shared by all series, so that those of one engine can be judged together.
    table["segment"] = pd.factorize(pd.MultiIndex.from_frame(table[["engine", "part", "version"]]))[0]
    first = table.drop_duplicates("series")
    at, shape = (table["series"].to_numpy(), table["night"].to_numpy()), (len(first), len(nights))

    def spread(column: str, none: object) -> NDArray[Any]:
        over_nights = np.full(shape, none, object if isinstance(none, str) else None)
        over_nights[at] = table[column].to_numpy()
        return over_nights

    values, segments, canaries = spread("value", np.nan), spread("segment", -1), spread("canary", np.nan)
    trials, hashes = spread("trial", ""), spread("hash", "")
    prices = np.flatnonzero(first["kind"] == "price").tolist()
    machines = np.unique([night.machine for night in nights], return_inverse=True)[1]
    of_all = np.array([night.canary for night in nights])
    engines = first["engine"].to_numpy()[prices].tolist()
    over = dict(
        zip(prices, yardsticks(values[prices], segments[prices], engines, canaries[prices], of_all, machines), strict=True)
    )
    none: tuple[Floats, Beside] = (np.ones(len(nights)), "")
    return tuple(
        Series(
            **subject,
            values=values[k],
            over=over.get(k, none)[0],
            beside=over.get(k, none)[1],
            segments=segments[k],
            trials=tuple(trials[k]),
            hashes=tuple(hashes[k]),
        )
        for k, subject in enumerate(first[[*SUBJECT]].to_dict("records"))
    )


def yardsticks(
    values: Floats,
    segments: NDArray[np.int64],
    engines: Sequence[str],
    canaries: Floats,
    canary: Floats,
    hosts: NDArray[np.int64],
) -> list[tuple[Floats, Beside]]:
    """For each price series its divisor (n,), and what that is.

    Args: values, segments (s, n). engines: of each series. canaries (s, n) [s]: clocked beside it.
    canary (n,) [s]: of each night. hosts (n,): its machine, as a number.
    """
    steady = [over_segments(row, numbers) for row, numbers in zip(values, segments, strict=True)]
    votes = {
        name: _moved(np.array([row for row, engine in zip(steady, engines, strict=True) if engine == name]))
        for name in dict.fromkeys(engines)
    }
    kernel = over_segments(canary, hosts)
    made: list[tuple[Floats, Beside]] = []
    for engine, own in zip(engines, canaries, strict=True):
        others = [vote for name, vote in votes.items() if name != engine]
        if len(others) >= FEWEST_OTHERS:
            made.append((_agreed(np.array(others), kernel), "other engines"))
        else:
            made.append((over_segments(own, np.zeros(len(own), np.int64)), "canary"))
    return made


def over_segments(values: Floats, segments: NDArray[np.int64]) -> Floats:
    """Each value over the median of its segment: another version or machine is no motion of the night."""
    over = np.full(len(values), np.nan)
    for number in np.unique(segments):
        mine = (segments == number) & np.isfinite(values) & (values > 0)
        if mine.any():
            over[mine] = values[mine] / np.exp(np.median(np.log(values[mine])))
    return over


def _moved(rows: Floats) -> Floats:
    """The common motion of rows (s, n), NaN on nights without any; a case that changed does not move the median of all."""
    return np.where(np.isfinite(rows).any(axis=0), common_mode(rows), np.nan)


def _agreed(votes: Floats, kernel: Floats) -> Floats:
    """What the votes (v, n) of engines and the canary's (n,) come to."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", RuntimeWarning)  # a night on which nothing was clocked
        middle = np.nanmedian(np.log(np.vstack([votes, kernel])), axis=0)
        off = np.log(votes) - middle
        most = CLIP * float(np.nanmedian(np.abs(off)))
        mean = np.nanmean(np.where(np.abs(off) <= most, off, np.nan), axis=0)
        agreed: Floats = np.exp(middle + np.nan_to_num(mean))
    return agreed


CHANCE_OF_ALL = 1e-3
"""Of a history: how often chance alone may look like a change in any of its series; each has its share."""
FEWEST_CASES = 3
"""Whose median is an engine."""
MOST = 0.6
"""Share of a group's members that take its step, to at least half of it."""
Z_95 = 1.96
_SILENT = ("unavailable", "interrupted")
"""Statuses that say nothing of an engine: the answer before still stands."""


@dataclass(frozen=True, slots=True)
class PriceStep:
    """Terms: night: index of the first that is otherwise. change: what is told of it. members: the prices that took it."""

    night: int
    change: Change
    members: tuple[Series, ...] = ()


def exact_steps(nights: Sequence[Night], table: pd.DataFrame) -> Iterator[PriceStep]:
    """What is exact and another than the last time; where one was lost in between, than the last that there was, too: the
    tables of two nights are read where an answer is another. Args: table: of these nights. Raises: StoreError."""
    exact = table[table["kind"].isin(EXACT) & ~table["status"].isin(_SILENT)]
    both = _others(exact), _others(exact[~exact["status"].isin(LOST)])
    others = pd.concat(both).drop_duplicates(["key", "night", "before"])
    for (night, before, kind), rows in others.groupby(["night", "before", "kind"]):
        for change in _changes(kind, nights[int(before)], nights[night], rows):
            yield PriceStep(night, change)


def _others(rows: pd.DataFrame) -> pd.DataFrame:
    """The rows that are others than the one before them of their key: `before` is the night of that, `was` what it said."""
    before = rows.groupby("key", sort=False)[["status", "hash", "said", "night"]].shift()
    bits = (rows["hash"] != "") & (rows["hash"] != before["hash"])
    other = (rows["status"] != before["status"]) | (rows["said"] != before["said"]) | bits
    return rows.assign(before=before["night"], was=before["said"])[before["night"].notna() & other]


def _changes(kind: str, before: Night, after: Night, rows: pd.DataFrame) -> Iterable[Change]:
    """What is told of rows of one kind of a night, each against the same one before."""
    if kind == "answer":
        then, now = before.store(), after.store()
        were, are = ({answer_key(key): row for key, row in by_question(store).items()} for store in (then, now))
        return answer_changes(then, now, [TrialPair(were[key], are[key]) for key in rows["key"]])
    form = _form(Search if kind == "search" else Repetition)
    sides: list[Mapping[str, Any]] = [
        {key: form.validate_python(json.loads(text)) for key, text in zip(rows["key"], rows[side], strict=True)}
        for side in ("was", "said")
    ]
    return moved_limits(*(side.values() for side in sides)) if kind == "search" else lost_and_won(*sides)


_form: Any = cache(TypeAdapter)


def price_steps(series: Sequence[Series], chance: float = CHANCE_OF_ALL) -> Iterator[PriceStep]:
    """Every step of the prices among the series, engine by engine. Args: chance: of a history, see `CHANCE_OF_ALL`."""
    prices = [each for each in series if each.kind == "price"]
    engines: dict[str, dict[tuple[str, str], list[Series]]] = {}
    for each in prices:
        engines.setdefault(each.engine, {}).setdefault((each.case, each.metric), []).append(each)
    groups = [group for cases in engines.values() for group in cases.values()]
    together = sum(len(group) > 1 for group in groups) + sum(len(cases) >= FEWEST_CASES for cases in engines.values())
    for cases in engines.values():
        yield from _of_engine(list(cases.values()), chance / max(len(prices) + together, 1))


def _of_engine(groups: Sequence[Sequence[Series]], chance: float) -> Iterator[PriceStep]:
    members = [each for group in groups for each in group]
    segments = np.max([each.segments for each in members], axis=0)
    rows = [np.array([over_segments(each.free, each.segments) for each in group]) for group in groups]
    taken = np.ones(len(segments))
    if len(groups) >= FEWEST_CASES:
        by_case = np.array([levelled(group) for group in rows])
        whole = np.where(np.isfinite(by_case).any(axis=0), common_mode(by_case), np.nan)
        taken = yield from _together(whole, by_case, members, segments, chance)
    for group, values in zip(groups, rows, strict=True):
        alone, case = values / taken, group[0].case
        if len(group) > 1:
            alone = alone / (yield from _together(levelled(alone), alone, group, segments, chance, case))
        for each, row in zip(group, alone, strict=True):
            yield from (_step(point, [each], case) for point in change_points(row, each.segments, chance))


def _together(
    whole: Floats, rows: Floats, members: Sequence[Series], segments: NDArray[np.int64], chance: float, case: str = ""
) -> Generator[PriceStep, None, Floats]:
    """The steps of what moves together (n,) that most of its rows (s, n) take. Returns: what they multiply nights by (n,)."""
    factor, nights = np.ones(len(segments)), np.arange(len(segments))
    for point in _shared(change_points(whole, segments, chance), rows, segments):
        factor[(segments == segments[point.index]) & (nights >= point.index)] *= point.ratio
        yield _step(point, members, case)
    return factor


def _shared(points: Sequence[ChangePoint], rows: Floats, segments: NDArray[np.int64]) -> list[ChangePoint]:
    """The points that most of the rows (s, n) take."""
    shared, nights = [], np.arange(len(segments))
    for point in points:
        same = segments == segments[point.index]
        begin = max([other.index for other in points if other.index < point.index], default=0)
        end = min([other.index for other in points if other.index > point.index], default=len(segments))
        before, after = same & (begin <= nights) & (nights < point.index), same & (point.index <= nights) & (nights < end)
        sizes = [_size(row, before, after) for row in rows]
        took = [size / (math.log(point.ratio) / 2) >= 1 for size in sizes if not math.isnan(size)]
        if took and sum(took) >= MOST * len(took):
            shared.append(point)
    return shared


def _size(row: Floats, before: NDArray[np.bool_], after: NDArray[np.bool_]) -> float:
    """The step of logarithms between medians; NaN where a side has too few nights."""
    logs = [np.log(row[side & np.isfinite(row)]) for side in (before, after)]
    return float(np.median(logs[1]) - np.median(logs[0])) if min(map(len, logs)) >= FEWEST else math.nan


def _step(point: ChangePoint, members: Sequence[Series], case: str) -> PriceStep:
    """Args: case: '' for an engine as a whole."""
    first, alone = members[0], len(members) == 1
    about: dict[str, Any] = {"metric": first.metric if case else "CPU time", "unit": "1"}
    if alone:
        about = {name: getattr(first, name) for name in ("track", "where", "dt", "metric")} | {
            "unit": "s",
            "trial_b": next(filter(None, first.trials[point.index :]), ""),
            "before": _median(first, point.index, later=False),
            "after": _median(first, point.index, later=True),
        }
    beside: Beside = "other engines" if all(each.beside == "other engines" for each in members) else "canary"
    change = Change(
        kind="price",
        sense="worse" if point.ratio > 1 else "better",
        case=case,
        engine=first.engine,
        ratio=point.ratio,
        low=point.ratio * math.exp(-Z_95 * point.error),
        high=point.ratio * math.exp(Z_95 * point.error),
        beside=beside,
        count=len(members),
        **about,
    )
    return PriceStep(point.index, change, tuple(members))


def _median(series: Series, night: int, *, later: bool) -> float | None:
    """Of the values [s] on one side of a night, within its segment."""
    same = (series.segments == series.segments[night]) & np.isfinite(series.values)
    side = same & ((np.arange(len(same)) >= night) == later)
    return float(np.median(series.values[side])) if side.any() else None
