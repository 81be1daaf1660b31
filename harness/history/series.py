"""Series over a history: what each night said of every price, error and limit, in segments of one machine and one version."""

from collections.abc import Callable
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from plumbline.harness.findings.changes.values import Beside
from plumbline.harness.history.night_readings import Measured, NightOf, Numbers, Reading, Subject
from plumbline.harness.history.normalisation import yardsticks
from plumbline.harness.trajectory import Floats


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


@dataclass(slots=True)
class Readings:
    """What the nights said so far; each is added once, the earliest first. Terms: kinds: of series that are wanted."""

    kinds: frozenset[Measured] = frozenset({"price", "error", "limit"})
    nights: list[NightOf] = field(default_factory=list)
    _by: dict[str, dict[int, Reading]] = field(default_factory=dict)
    _subjects: dict[str, Subject] = field(default_factory=dict)
    _canary: list[float] = field(default_factory=list)
    _segments: dict[tuple[str, str, str], int] = field(default_factory=dict)

    def add(self, numbers: Numbers) -> None:
        """Take in what one more night said."""
        self.nights.append(numbers.night)
        self._canary.append(numbers.canary)
        for reading in numbers.readings:
            if reading.subject.kind in self.kinds:
                self._subjects.setdefault(reading.key, reading.subject)
                self._by.setdefault(reading.key, {})[len(self.nights) - 1] = reading

    def series(self) -> tuple[Series, ...]:
        """All series, in the order in which they were first seen; prices with what they are divided by."""
        every = [self._plain(key) for key in self._by]
        prices = [number for number, series in enumerate(every) if series.subject.kind == "price"]
        canaries = [self._of(key, lambda reading: reading.canary) for key in self._by]
        over = yardsticks(
            [every[k].values for k in prices],
            [every[k].segments for k in prices],
            [every[k].subject.engine for k in prices],
            [canaries[k] for k in prices],
            np.array(self._canary),
            np.unique([night.machine for night in self.nights], return_inverse=True)[1],
        )
        for k, (factor, beside) in zip(prices, over, strict=True):
            every[k] = replace(every[k], over=factor, beside=beside)
        return tuple(every)

    def _plain(self, key: str) -> Series:
        readings, count = self._by[key], len(self.nights)
        segments = np.full(count, -1, np.int64)
        for night, reading in readings.items():
            # Numbers are shared by all series, so that those of one engine can be judged together.
            segment = (self._subjects[key].engine, *reading.segment)
            segments[night] = self._segments.setdefault(segment, len(self._segments))
        return Series(
            subject=self._subjects[key],
            values=self._of(key, lambda reading: reading.value),
            over=np.ones(count),
            beside="",
            segments=segments,
            trials=self._words(key, lambda reading: reading.trial),
            hashes=self._words(key, lambda reading: reading.hash),
        )

    def _of(self, key: str, value: Callable[[Reading], float]) -> Floats:
        row = np.full(len(self.nights), np.nan)
        for night, reading in self._by[key].items():
            row[night] = value(reading)
        return row

    def _words(self, key: str, word: Callable[[Reading], str]) -> tuple[str, ...]:
        return tuple(word(self._by[key][n]) if n in self._by[key] else "" for n in range(len(self.nights)))
