"""Many equal worlds stepped together: how many steps a second, how far off, in how much memory, and alike bit for bit?

A rate is that of one thread: steps of a world in a second of CPU time. The error beside it is of the same settings, in the
world in the last place.
"""

import json
import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from operator import attrgetter, itemgetter
from typing import Any, Literal

from plumbline.harness.findings.columns import Cell, Column, Table, names, plain, scene
from plumbline.harness.findings.once import once
from plumbline.harness.findings.parameter_words import differing, said
from plumbline.harness.metrics.equivalence import world_spread
from plumbline.harness.statistics.interval import Interval
from plumbline.harness.store.record import short_of
from plumbline.harness.store.rows import grouped, records
from plumbline.harness.store.store import Store

WORLDS = "worlds"
"""The parameter of a case that says how many there are."""
Alike = Literal["alike", "differ", "not known"]
Facts = Mapping[str, Any]
"""What the table of trials holds of one."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Throughput(Cell):
    """One engine under one group of settings in so many worlds of one scene.

    Terms: rate [1/s]: steps of a world in a second of CPU time, with its interval; None where nothing was clocked. pace [1]:
    simulated seconds of a world in one of CPU time. error: the case's headline. memory [B]: what each further world takes, by
    how much more the process grew than with the fewest worlds that were run; None there. places: has the world in the first
    place the bits of that in the last? sizes: has the world in the last place the bits that it has in each other number of
    worlds? short: what the engine had no room for; '' where it held all. best: is this the number of worlds at which the engine
    is fastest under these settings?
    """

    worlds: int
    dt: float
    rate: Interval | None
    pace: float | None
    error: float | None
    error_metric: str
    memory: float | None
    places: Alike
    sizes: Alike
    short: str
    status: str
    reason: str
    unstable: bool | None
    trial: str
    best: bool = False


@once
def throughputs(store: Store) -> tuple[Throughput, ...]:
    """All rows: scene by scene, setting by setting, by the number of worlds."""
    trials = [row | {"given": json.loads(row["parameters"])} for row in records(store.asked)]
    settings = grouped((row for row in trials if WORLDS in row["given"] and _plain(row)), _setting)
    swept: dict[str, list[str]] = {}
    for name, rows in grouped(trials, itemgetter("case")).items():
        own = store.catalogue.get("cases", {}).get(name, {}).get("parameters", {})
        swept[name] = [each for each in differing((row["given"] for row in rows), own) if each != WORLDS]
    return tuple(row for group in settings.values() for row in _rows(store, group, swept[group[0]["case"]]))


def _plain(row: Facts) -> bool:
    return (row.get("clocks", "work"), row.get("workers", 1)) == ("work", 1)


def _setting(row: Facts) -> tuple[object, ...]:
    return row["case"], json.dumps(_scene(row), sort_keys=True), row["engine"], row["track"], row["dt"]


def _scene(row: Facts) -> dict[str, Any]:
    return {name: value for name, value in row["given"].items() if name != WORLDS}


def _rows(store: Store, trials: Sequence[Facts], swept: Sequence[str]) -> Iterator[Throughput]:
    """The rows of one engine under one group of settings in one scene. Args: swept: what tells scenes of the case apart."""
    trials = sorted(trials, key=lambda row: int(row["given"][WORLDS]))
    headline = store.catalogue.get("cases", {}).get(trials[0]["case"], {}).get("headline", "")
    hashes = {row["trajectory_hash"] for row in trials if isinstance(row["trajectory_hash"], str)}
    rates = [_rate(row) for row in trials]
    fastest = max((rate.value for rate in rates if rate is not None), default=None)
    for row, rate in zip(trials, rates, strict=True):
        values, count = store.values(row["trial"]), int(row["given"][WORLDS])
        apart, error = values.get(world_spread.name), values.get(headline)
        given = {name: row["given"][name] for name in swept if name in row["given"]}
        yield Throughput(
            case=row["case"],
            where=", ".join(said(row["case"], name, value) for name, value in given.items()),
            engine=row["engine"],
            track=row["track"],
            worlds=count,
            dt=row["dt"],
            rate=rate,
            pace=None if rate is None else rate.value * row["dt"],
            error=error,
            error_metric=headline,
            memory=_further(trials[0], row),
            places="not known" if apart is None or count == 1 else "alike" if apart == 0.0 else "differ",
            sizes="not known" if len(trials) < 2 or error is None else "alike" if len(hashes) == 1 else "differ",
            short=short_of(store.notices.get(row["trial"], ())),
            status=row["status"],
            reason=row["reason"],
            unstable=row["unstable_timing"],
            trial=row["trial"],
            best=rate is not None and rate.value == fastest,
        )


def _rate(row: Facts) -> Interval | None:
    """Steps a second of CPU time, from what a step of a world costs."""
    cost, low, high = (row[f"cpu_per_unit{end}"] for end in ("", "_low", "_high"))
    return Interval(1 / cost, 1 / high, 1 / low) if math.isfinite(cost) else None


def _further(fewest: Facts, row: Facts) -> float | None:
    """Memory [B] of each world beyond the fewest."""
    more = int(row["given"][WORLDS]) - int(fewest["given"][WORLDS])
    grown = float(row["memory"]) - float(fewest["memory"])
    return grown / more if more > 0 and math.isfinite(grown) else None


def bests(rows: Sequence[Throughput]) -> list[Throughput]:
    """The rows at the number of worlds at which each setting is fastest, scene by scene."""
    return [row for group in grouped(rows, attrgetter("case", "where")).values() for row in group if row.best]


TABLE = Table(
    holds=names(Throughput),
    objects=throughputs,
    shown=(
        Column("scene", scene),
        Column("engine", "engine"),
        Column("setting", lambda row: f"{row.track}, {1e3 * row.dt:.3g} ms"),
        *plain("worlds", "steps/s=rate.value:,.0f", "error=error:.3g"),
        Column("kB a world", lambda row: "" if row.memory is None else f"{row.memory / 1e3:.3g}"),
        *plain("places", "sizes"),
        # * the engine's fastest number of worlds, ~ an unstable timing
        Column("marks", lambda row: ("*" if row.best else "") + ("~" if row.unstable else "")),
        Column("status", lambda row: row.status if row.status == "passed" else f"{row.status}: {row.reason[:64]}"),
    ),
)
