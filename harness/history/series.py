"""Series over a history: what each night said of every price, error and limit, in segments of one machine and one version."""

from collections.abc import Collection, Sequence
from dataclasses import dataclass
from typing import Any, get_args

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from plumbline.harness.findings.changes.values import Beside
from plumbline.harness.history.normalisation import yardsticks
from plumbline.harness.history.readings import SUBJECT, Measured, NightOf
from plumbline.harness.trajectory import Floats


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
