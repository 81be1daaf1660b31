"""What one night says, as values: its prices, errors and limits, and its answers, searches and repetitions by question."""

import hashlib
import json
from collections.abc import Hashable, Mapping
from dataclasses import dataclass
from typing import Any, Literal, TypeAlias

import numpy as np

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


@dataclass(frozen=True, slots=True, kw_only=True)
class NightOf:
    """One night as a reader of series has to know it. Terms: machine: its digest; processor: its name; versions: of engines."""

    stamp: str
    folder: str
    machine: str
    processor: str
    versions: Mapping[str, str]


@dataclass(frozen=True, slots=True, kw_only=True)
class Reading:
    """One value of a series. Terms: key: what all its nights have in common. segment: nights of another are not compared.
    trial, hash: of the answer, '' for none. canary [s]: clocked beside a price, NaN beside anything else."""

    key: str
    subject: Subject
    value: float
    segment: tuple[str, str]
    trial: str = ""
    hash: str = ""
    canary: float = np.nan


@dataclass(frozen=True, slots=True, kw_only=True)
class Numbers:
    """What series are made of. Terms: night; canary [s]: the middle of all of it, NaN where nothing was clocked; readings."""

    night: NightOf
    canary: float
    readings: tuple[Reading, ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class Answer:
    """One answer as far as another night's can differ from it. Terms: hash: '' for none. values: a digest of its metrics."""

    status: str
    hash: str
    values: str


@dataclass(frozen=True, slots=True, kw_only=True)
class Answers:
    """What is compared exactly. Terms: answers: by question. searches: without those for remedies. repetitions: by what was
    repeated and how; nothing where a trajectory that they are read off is not to be had."""

    answers: Mapping[str, Answer]
    searches: tuple[Search, ...]
    repetitions: Mapping[str, Agreement]


def numbers_of(night: Night, store: Store) -> Numbers:
    """Prices, errors and limits of a night. Raises: StoreError."""
    trials, samples = store.trials, store.samples
    answered = trials[trials["status"] != "unavailable"]
    versions = {str(e): ", ".join(sorted(set(map(str, g["engine_version"])))) for e, g in answered.groupby("engine")}
    canaries = {} if samples.empty else samples.groupby("trial")["canary"].median().to_dict()
    about = NightOf(
        stamp=night.stamp,
        folder=str(night.folder),
        machine=machine_digest(store.machine),
        processor=str(store.machine.get("processor", "")),
        versions=versions,
    )
    return Numbers(
        night=about,
        canary=float(np.median(list(canaries.values()))) if canaries else np.nan,
        readings=(*_of_trials(store, about.machine, canaries), *_of_limits(store, versions)),
    )


def _of_trials(store: Store, machine: str, canaries: Mapping[Any, float]) -> list[Reading]:
    cases = store.catalogue.get("cases", {})
    headlines = {name: about.get("headline", "") for name, about in cases.items()}
    metrics = {(str(m.trial), str(m.metric)): m for m in store.measurements.itertuples()}
    asked, made = set(store.asked["trial"]), list[Reading]()
    for key, row in by_question(store).items():
        if row.trial not in asked:
            continue
        trial, version = str(row.trial), str(row.engine_version)
        if row.cpu_per_unit is not None and row.cpu_per_unit > 0:
            unit = f"CPU time of a {row.unit}" if isinstance(row.unit, str) else "CPU time"
            # A timing kept from another machine has that one's digest. Before it was said what was clocked, it could be a part
            # of the motion.
            made.append(
                Reading(
                    key=_named("price", key),
                    subject=_subject("price", row, store, unit, "s"),
                    value=float(row.cpu_per_unit),
                    segment=(f"{str(row.clocked_on) or machine} {row.clocked}", version),
                    trial=trial,
                    canary=float(canaries.get(row.trial, np.nan)),
                )
            )
        measured = metrics.get((trial, str(headlines.get(row.case, ""))))
        if measured is not None:
            made.append(
                Reading(
                    key=_named("error", key),
                    subject=_subject("error", row, store, str(measured.metric), str(measured.unit)),
                    value=float(measured.value),
                    segment=("", version),
                    trial=trial,
                    hash=_text(row.trajectory_hash),
                )
            )
    return made


def _of_limits(store: Store, versions: Mapping[str, str]) -> list[Reading]:
    return [
        Reading(
            key=_named("limit", searched_by(search)),
            subject=Subject(
                kind="limit",
                experiment=search.experiment,
                case=search.case,
                where=search.where,
                engine=search.engine,
                track=search.setting,
                dt=search.dt,
                metric=search.axis,
                unit=search.unit,
            ),
            value=float(search.held),
            segment=("", versions.get(search.engine, "")),
            trial=search.trial_held,
        )
        for search in searches(store)
        if not search.remedied and search.held is not None
    ]


def answers_of(store: Store) -> Answers:
    """Answers, limits and repetitions of a night. Raises: StoreError."""
    values: dict[str, list[str]] = {}
    for row in store.measurements.itertuples():
        values.setdefault(str(row.trial), []).append(f"{row.metric} {float(row.value)!r}")
    try:
        repeated = agreements_by_cell(store)
    except StoreError:
        repeated = {}  # a history may keep hashes only, and a parting cannot be read off these
    return Answers(
        answers={
            name: Answer(status=str(row.status), hash=_text(row.trajectory_hash), values=_digest(values.get(row.trial, ())))
            for name, row in questions(store).items()
        },
        searches=tuple(search for search in searches(store) if not search.remedied),
        repetitions={_named("repeated", cell): agreement for cell, agreement in repeated.items()},
    )


def questions(store: Store) -> dict[str, Any]:
    """The rows of the table `trials` by the names that `Answers` has."""
    return {_named("asked", key): row for key, row in by_question(store).items()}


def _named(kind: str, key: Hashable) -> str:
    return json.dumps([kind, key])


def _digest(values: Any) -> str:
    return hashlib.sha256("\n".join(sorted(values)).encode()).hexdigest()[:16]


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
