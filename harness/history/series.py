"""Series over a history: what each night said of every price, error and limit, in segments of one machine and one version."""

from collections.abc import Collection, Sequence
from dataclasses import dataclass, replace
from typing import get_args

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from plumbline.harness.findings.changes.values import Beside
from plumbline.harness.history.night_readings import SUBJECT, Measured, Readings
from plumbline.harness.history.normalisation import yardsticks
from plumbline.harness.trajectory import Floats


@dataclass(frozen=True, slots=True, kw_only=True)
class Subject:
    """What a series is of. Terms: experiment, where, track, dt [s] as in a change; metric, unit: of its values."""

    kind: Measured
    experiment: str
    case: str
    where: str
    engine: str
    track: str
    dt: float
    metric: str
    unit: str


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Series:
    """One number over all nights.

    Terms:
        values (n,): NaN where a night has none. over (n,): what prices are divided by to be free of what the machine did to all
        of them, 1 for anything else; beside: what that was. segments (n,): nights of one number share machine and version; -1
        where there is no value. trials: of each night, '' for none. hashes: of trajectories, likewise.
    """

    subject: Subject
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


def series_of(nights: Sequence[Readings], kinds: Collection[Measured] = get_args(Measured)) -> tuple[Series, ...]:
    """All series of these kinds, in the order in which they were first seen; prices with what they are divided by.

    Args: nights: the earliest first.
    """
    table = pd.concat([reading.table.assign(night=k) for k, reading in enumerate(nights)]) if nights else pd.DataFrame()
    if table.empty or not table["kind"].isin(kinds).any():
        return ()
    table = table[table["kind"].isin(kinds)]
    table = table.assign(series=pd.factorize(table["key"])[0]).sort_values(["series", "night"], kind="stable")
    # Numbers of segments are shared by all series, so that those of one engine can be judged together.
    table["segment"] = pd.factorize(pd.MultiIndex.from_frame(table[["engine", "part", "version"]]))[0]
    first = table.drop_duplicates("series")
    at, shape = (table["series"].to_numpy(), table["night"].to_numpy()), (len(first), len(nights))

    def spread(column: str, none: object) -> NDArray[np.generic]:
        over_nights = np.full(shape, none, object if isinstance(none, str) else None)
        over_nights[at] = table[column].to_numpy()
        return over_nights

    values, segments, canaries = spread("value", np.nan), spread("segment", -1), spread("canary", np.nan)
    words = [spread(column, "") for column in ("trial", "hash")]
    every = [
        Series(
            subject=Subject(**subject),
            values=values[k],
            over=np.ones(len(nights)),
            beside="",
            segments=segments[k],
            trials=tuple(words[0][k]),
            hashes=tuple(words[1][k]),
        )
        for k, subject in enumerate(first[[*SUBJECT]].to_dict("records"))
    ]
    prices = [k for k, series in enumerate(every) if series.subject.kind == "price"]
    over = yardsticks(
        [every[k].values for k in prices],
        [every[k].segments for k in prices],
        [every[k].subject.engine for k in prices],
        [canaries[k] for k in prices],
        np.array([reading.night.canary for reading in nights]),
        np.unique([reading.night.machine for reading in nights], return_inverse=True)[1],
    )
    for k, (factor, beside) in zip(prices, over, strict=True):
        every[k] = replace(every[k], over=factor, beside=beside)
    return tuple(every)
