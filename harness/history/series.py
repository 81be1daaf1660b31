"""Series over a history: what each night said of every price, error and limit, in segments of one machine and one version.

Prices are divided by how far the night moved the other engines, or the canary where there are too few. Each other engine has
one vote, the common motion of its series, and the canary another. The median of the votes is free of one engine that changed,
however many series it has, but as noisy as a vote; the mean of the engines' votes is not, where none is counted for more than
three median departures from that median.
"""

import warnings
from collections.abc import Collection, Sequence
from dataclasses import dataclass
from typing import Any, get_args

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from plumbline.harness.findings.changes.values import Beside
from plumbline.harness.history.readings import SUBJECT, Measured, NightOf
from plumbline.harness.statistics.change_points import common_mode
from plumbline.harness.trajectory import Floats

FEWEST = 2
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
        if len(others) >= FEWEST:
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
