"""Series over a history: what each night said of every price, error and limit, in segments of one machine and one version."""

from collections.abc import Callable, Hashable, Mapping
from dataclasses import dataclass, field, replace
from functools import partial
from typing import Any, Literal, TypeAlias

import numpy as np
from numpy.typing import NDArray

from harness.findings.changes.limits import searched_by
from harness.findings.changes.matching import by_question, where_of
from harness.findings.changes.values import Beside
from harness.findings.clocked_part import clocked_part
from harness.findings.limits_found import searches
from harness.history.folder import Night
from harness.history.yardsticks import yardsticks
from harness.store.machine_fingerprint import machine_digest
from harness.store.store import Store
from harness.trajectory import Floats

__all__ = ["NightOf", "Readings", "Series", "Subject"]

Measured: TypeAlias = Literal["price", "error", "limit"]
"""What a series is of: seconds of a unit of work; the headline of a case, in its unit; the last value of an axis that held."""


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


@dataclass(frozen=True, slots=True, kw_only=True)
class NightOf:
    """One night as a reader of series has to know it. Terms: machine: its digest; processor: its name; versions: of engines."""

    stamp: str
    folder: str
    machine: str
    processor: str
    versions: Mapping[str, str]


@dataclass(frozen=True, slots=True)
class _Reading:
    value: float
    segment: tuple[str, str]
    trial: str
    hash: str
    canary: float = np.nan


@dataclass(slots=True)
class Readings:
    """What the nights said so far; each is added once, the earliest first. Terms: kinds: of series that are wanted."""

    kinds: frozenset[Measured] = frozenset({"price", "error", "limit"})
    nights: list[NightOf] = field(default_factory=list)
    _by: dict[Hashable, dict[int, _Reading]] = field(default_factory=dict)
    _subjects: dict[Hashable, Subject] = field(default_factory=dict)
    _canary: list[float] = field(default_factory=list)
    _segments: dict[tuple[str, str, str], int] = field(default_factory=dict)

    def add(self, night: Night, store: Store) -> None:
        """Read one more night. Raises: StoreError."""
        machine = machine_digest(store.machine)
        trials = store.trials
        answered = trials[trials["status"] != "unavailable"]
        versions = {str(e): ", ".join(sorted(set(map(str, g["engine_version"])))) for e, g in answered.groupby("engine")}
        self.nights.append(
            NightOf(
                stamp=night.stamp,
                folder=str(night.folder),
                machine=machine,
                processor=str(store.machine.get("processor", "")),
                versions=versions,
            )
        )
        samples = store.samples
        canaries = {} if samples.empty else samples.groupby("trial")["canary"].median().to_dict()
        self._canary.append(float(np.median(list(canaries.values()))) if canaries else np.nan)
        steps = {} if samples.empty else samples.groupby("trial")["steps"].first().to_dict()
        cases = store.catalogue.get("cases", {})
        headlines = {name: about.get("headline", "") for name, about in cases.items()}
        read = store.measurements.itertuples() if "error" in self.kinds else ()
        metrics = {(str(m.trial), str(m.metric)): m for m in read}
        asked = set(store.asked["trial"])
        for key, row in by_question(store).items():
            if row.trial not in asked:
                continue
            if row.cpu_per_unit is not None and row.cpu_per_unit > 0:
                unit = f"CPU time of a {row.unit}" if isinstance(row.unit, str) else "CPU time"
                # A timing kept from another machine has that one's digest; another part of the motion a price of its own.
                part = clocked_part(row, int(steps.get(row.trial, 0)), cases.get(row.case, {}))
                on = (f"{str(row.clocked_on) or machine} {part or ''}", str(row.engine_version))
                canary = float(canaries.get(row.trial, np.nan))
                price = _Reading(float(row.cpu_per_unit), on, str(row.trial), "", canary)
                self._keep(("price", key), price, partial(_subject, "price", row, store, unit, "s"))
            measured = metrics.get((str(row.trial), str(headlines.get(row.case, ""))))
            if measured is not None:
                error = _Reading(
                    float(measured.value), ("", str(row.engine_version)), str(row.trial), _text(row.trajectory_hash)
                )
                self._keep(
                    ("error", key),
                    error,
                    partial(_subject, "error", row, store, str(measured.metric), str(measured.unit)),
                )
        if "limit" in self.kinds:
            self._add_limits(store)

    def _add_limits(self, store: Store) -> None:
        for search in searches(store):
            if search.remedied or search.held is None:
                continue
            version = self.nights[-1].versions.get(search.engine, "")
            subject = Subject(
                kind="limit",
                experiment=search.experiment,
                case=search.case,
                where=search.where,
                engine=search.engine,
                track=search.setting,
                dt=search.dt,
                metric=search.axis,
                unit=search.unit,
            )
            reading = _Reading(float(search.held), ("", version), search.trial_held, "")
            self._keep(("limit", searched_by(search)), reading, partial(replace, subject))

    def _keep(self, key: Hashable, reading: _Reading, subject: Callable[[], Subject]) -> None:
        if key not in self._subjects:
            self._subjects[key] = subject()
        self._by.setdefault(key, {})[len(self.nights) - 1] = reading

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
            self._hosts(),
        )
        for k, (factor, beside) in zip(prices, over, strict=True):
            old = every[k]
            every[k] = Series(
                subject=old.subject,
                values=old.values,
                over=factor,
                beside=beside,
                segments=old.segments,
                trials=old.trials,
                hashes=old.hashes,
            )
        return tuple(every)

    def _hosts(self) -> NDArray[np.int64]:
        """The machine of each night, as a number."""
        known = list(dict.fromkeys(night.machine for night in self.nights))
        return np.array([known.index(night.machine) for night in self.nights], np.int64)

    def _plain(self, key: Hashable) -> Series:
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

    def _of(self, key: Hashable, value: Callable[[_Reading], float]) -> Floats:
        row = np.full(len(self.nights), np.nan)
        for night, reading in self._by[key].items():
            row[night] = value(reading)
        return row

    def _words(self, key: Hashable, word: Callable[[_Reading], str]) -> tuple[str, ...]:
        return tuple(word(self._by[key][n]) if n in self._by[key] else "" for n in range(len(self.nights)))


def _subject(kind: Measured, row: Any, store: Store, metric: str, unit: str) -> Subject:
    return Subject(
        kind=kind,
        experiment=str(row.experiment),
        case=str(row.case),
        where=where_of(row, store.catalogue),
        engine=str(row.engine),
        track=str(row.track),
        dt=float(row.dt),
        metric=metric,
        unit=unit,
    )


def _text(value: Any) -> str:
    return value if isinstance(value, str) else ""
