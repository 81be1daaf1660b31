"""What one night says, as one long table: its prices, errors and limits, and each answer with a digest of what was measured."""

import hashlib
import json
from collections.abc import Hashable, Iterator, Mapping
from dataclasses import dataclass
from typing import Any, Literal, TypeAlias

import numpy as np
import pandas as pd

from plumbline.harness.findings.changes.limits import searched_by
from plumbline.harness.findings.changes.matching import by_question, where_of
from plumbline.harness.findings.changes.repetitions import agreements_by_cell
from plumbline.harness.findings.limits_found import Search, searches
from plumbline.harness.findings.tables.determinism import Agreement
from plumbline.harness.history.folder import Night
from plumbline.harness.store.journal import StoreError
from plumbline.harness.store.machine_fingerprint import machine_digest
from plumbline.harness.store.store import Store

Measured: TypeAlias = Literal["price", "error", "limit"]
"""What a series is of: seconds of a unit of work; the headline of a case, in its unit; the last value of an axis that held."""

SUBJECT = ("kind", "experiment", "case", "where", "engine", "track", "dt", "metric", "unit")
COLUMNS: Mapping[str, Any] = {
    "key": "", **dict.fromkeys(SUBJECT, ""), "dt": 0.0, "value": np.nan, "part": "", "version": "", "trial": "", "hash": "",
    "canary": np.nan, "status": "", "measured": "",
}  # fmt: skip
"""Of the table, with what stands where nothing is said. kind: 'answer', or as in `Measured`. key: what all nights of a series
have in common. experiment to unit: as in a `Change`. part, version: nights of others are not compared. canary [s]: clocked
beside a price. measured: a digest of all metrics of an answer."""


@dataclass(frozen=True, slots=True, kw_only=True)
class NightOf:
    """One night as a reader of series has to know it. Terms: machine: its digest; processor: its name; versions: of engines.
    canary [s]: the middle of all of it, NaN where nothing was clocked. titles: of cases and engines, by name."""

    stamp: str
    folder: str
    machine: str
    processor: str
    versions: Mapping[str, str]
    canary: float = np.nan
    titles: Mapping[str, str] | None = None


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Readings:
    """All that is compared of a night.

    Terms: table: with COLUMNS. searches: without those for remedies. repetitions: by what was repeated and how; nothing where a
    trajectory that they are read off is not to be had.
    """

    night: NightOf
    table: pd.DataFrame
    searches: tuple[Search, ...]
    repetitions: Mapping[str, Agreement]


def readings_of(night: Night, store: Store) -> Readings:
    """Read a night. Raises: StoreError."""
    trials, samples = store.trials, store.samples
    answered = trials[trials["status"] != "unavailable"]
    versions = {str(e): ", ".join(sorted(set(map(str, g["engine_version"])))) for e, g in answered.groupby("engine")}
    canaries = {} if samples.empty else samples.groupby("trial")["canary"].median().to_dict()
    machine = machine_digest(store.machine)
    searched = tuple(search for search in searches(store) if not search.remedied)
    rows = (*_of_trials(store, machine, canaries), *_of_limits(searched, versions), *_of_answers(store))
    try:
        repeated = agreements_by_cell(store)
    except StoreError:
        repeated = {}  # a history may keep hashes only, and a parting cannot be read off these
    return Readings(
        night=NightOf(
            stamp=night.stamp,
            folder=str(night.folder),
            machine=machine,
            processor=str(store.machine.get("processor", "")),
            versions=versions,
            canary=float(np.median(list(canaries.values()))) if canaries else np.nan,
            titles=store.titles,
        ),
        table=pd.DataFrame([{**COLUMNS, **row} for row in rows], columns=[*COLUMNS]),
        searches=searched,
        repetitions={_named("repeated", cell): agreement for cell, agreement in repeated.items()},
    )


def _of_trials(store: Store, machine: str, canaries: Mapping[Any, float]) -> Iterator[dict[str, Any]]:
    """Prices and errors."""
    cases = store.catalogue.get("cases", {})
    headlines = {name: about.get("headline", "") for name, about in cases.items()}
    metrics = {(str(m.trial), str(m.metric)): m for m in store.measurements.itertuples()}
    asked = set(store.asked["trial"])
    for key, row in by_question(store).items():
        if row.trial not in asked:
            continue
        trial = str(row.trial)
        about: dict[str, Any] = {name: str(getattr(row, name)) for name in ("experiment", "case", "engine", "track", "trial")}
        about |= {"where": where_of(row, store.catalogue), "dt": float(row.dt), "version": str(row.engine_version)}
        if row.cpu_per_unit is not None and row.cpu_per_unit > 0:
            # A timing kept from another machine has that one's digest. Before it was said what was clocked, it could be a part
            # of the motion.
            yield about | {
                "kind": "price",
                "key": _named("price", key),
                "metric": f"CPU time of a {row.unit}" if isinstance(row.unit, str) else "CPU time",
                "unit": "s",
                "value": float(row.cpu_per_unit),
                "part": f"{str(row.clocked_on) or machine} {row.clocked}",
                "canary": float(canaries.get(row.trial, np.nan)),
            }
        measured = metrics.get((trial, str(headlines.get(row.case, ""))))
        if measured is not None:
            yield about | {
                "kind": "error",
                "key": _named("error", key),
                "metric": str(measured.metric),
                "unit": str(measured.unit),
                "value": float(measured.value),
                "hash": _text(row.trajectory_hash),
            }


def _of_limits(searched: tuple[Search, ...], versions: Mapping[str, str]) -> Iterator[dict[str, Any]]:
    for search in searched:
        if search.held is not None:
            yield {name: getattr(search, name) for name in ("experiment", "case", "where", "engine", "dt", "unit")} | {
                "kind": "limit",
                "key": _named("limit", searched_by(search)),
                "track": search.setting,
                "metric": search.axis,
                "value": float(search.held),
                "version": versions.get(search.engine, ""),
                "trial": search.trial_held,
            }


def _of_answers(store: Store) -> Iterator[dict[str, Any]]:
    values: dict[str, list[str]] = {}
    for row in store.measurements.itertuples():
        values.setdefault(str(row.trial), []).append(f"{row.metric} {float(row.value)!r}")
    for name, row in questions(store).items():
        measured = "\n".join(sorted(values.get(row.trial, ())))
        yield {
            "kind": "answer",
            "key": name,
            "status": str(row.status),
            "hash": _text(row.trajectory_hash),
            "measured": hashlib.sha256(measured.encode()).hexdigest()[:16],
        }


def questions(store: Store) -> dict[str, Any]:
    """The rows of the table `trials` by the keys of answers."""
    return {_named("answer", key): row for key, row in by_question(store).items()}


def _named(kind: str, key: Hashable) -> str:
    return json.dumps([kind, key])


def _text(value: Any) -> str:
    return value if isinstance(value, str) else ""
