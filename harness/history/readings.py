"""What nights say, as one long table: a row for each price, error, limit, answer, search and repetition of each night.

A night that is over does not change, and is read once: a file beside it keeps what it says, and names all that this rests on,
the night's own files and the texts of the rooms that read them. Where one is another, or the file is damaged, it is read anew.
"""

import hashlib
import json
from collections.abc import Collection, Hashable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import asdict, dataclass
from functools import cache
from itertools import chain
from pathlib import Path
from typing import Any, Literal, TypeAlias

import numpy as np
import pandas as pd

from plumbline.harness.findings.changes.matching import by_question
from plumbline.harness.findings.changes.studied import repetitions_by_cell, searched_by
from plumbline.harness.findings.limits_found import searches
from plumbline.harness.findings.parameter_words import where_of
from plumbline.harness.history.folder import History, Night
from plumbline.harness.store import disk
from plumbline.harness.store.journal import StoreError
from plumbline.harness.store.machine_fingerprint import machine_digest
from plumbline.harness.store.seal import sealed_json
from plumbline.harness.store.store import Store, read_plain
from plumbline.harness.store.stored_tables import TABLES

Measured: TypeAlias = Literal["price", "error", "limit"]
"""What a series is of: seconds of a unit of work; the headline of a case, in its unit; the last value of an axis that held."""
EXACT = ("answer", "search", "repetition")
"""What is the same as before or another, and nothing in between."""
SUBJECT = ("kind", "experiment", "case", "where", "engine", "track", "dt", "metric", "unit")
COLUMNS: Mapping[str, Any] = {
    "key": "", **dict.fromkeys(SUBJECT, ""), "dt": 0.0, "value": np.nan, "part": "", "version": "", "trial": "", "hash": "",
    "canary": np.nan, "status": "", "said": "",
}  # fmt: skip
"""Of the table, beside 'night', with what stands where nothing is said. kind: as in `Measured` or `EXACT`. key: what all nights
of a series have in common. experiment to unit: as in a `Change`. part, version: nights of others are not compared. canary [s]:
clocked beside a price. said: of an answer a digest of all its metrics, of a search and a repetition all of it, as JSON."""

FOLDER = "readings"
"""Of a history; what it holds may be deleted at any time."""
_FILES = ("journal.jsonl", *(f"{name}.parquet" for name in TABLES))
"""What a night's records are read from: its journal or, where a run folder was put there without one, its tables."""
_BESIDE = ("catalogue.json", "machine.json", "study.toml")
_ROOMS = ("findings", "history", "search", "statistics", "store")

Content: TypeAlias = Mapping[str, Any]
"""What one night says: 'night', a `NightOf`, and 'columns' of its rows."""


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


def table_of(contents: Sequence[Content]) -> pd.DataFrame:
    """With COLUMNS and 'night', the index of one of the nights. Args: contents: as `said_by` gives them, the earliest first."""
    columns = {name: [*chain.from_iterable(each["columns"][name] for each in contents)] for name in COLUMNS}
    counts = [len(each["columns"]["key"]) for each in contents]
    return pd.DataFrame({**columns, "night": np.repeat(np.arange(len(contents)), counts)})


def said_by(history: History, night: Night, store: Store) -> Content:
    """What a night says, as it is kept or, where that is not there, read. Raises: StoreError, OSError."""
    path, files = path_of(history, night.stamp), _files(night)
    dates = [_text_digest(), str(night.folder), *(f"{file.name} {_size_and_date(file)}" for file in files)]
    try:
        kept = read_plain(path)
        if kept["dates"] == dates or kept["rests_on"] == _rests_on(night, files):
            content = json.loads(kept["said"])
            return {"night": NightOf(**content["night"]), "columns": {name: content["columns"][name] for name in COLUMNS}}
    except (StoreError, KeyError, TypeError, ValueError):
        pass  # it is made of what is there still
    content = _read(night, store)
    # Numbers that are not finite are among them, which a sealed file has no word for.
    text = json.dumps({**content, "night": asdict(content["night"])})
    file = {"dates": dates, "rests_on": _rests_on(night, files), "said": text}
    with suppress(OSError):  # of a history that can only be read, each reader reads the nights anew
        disk.make_folder(path.parent)
        disk.write_atomically(path, sealed_json(path.name, file))
    return content


def of_others(history: History, stamps: Collection[str]) -> tuple[Path, ...]:
    """The files that are of none of these nights."""
    mine = {path_of(history, stamp) for stamp in stamps}
    return tuple(path for path in sorted((history.root / FOLDER).glob("*.json")) if path not in mine)


def path_of(history: History, stamp: str) -> Path:
    """Where the readings of the night of that name lie, or would."""
    return history.root / FOLDER / f"{stamp}.json"


def versions_of(store: Store) -> dict[str, str]:
    """Of the engines that were there, by name; two side by side in one text."""
    there = store.trials[store.trials["status"] != "unavailable"]
    return {str(engine): ", ".join(sorted(set(map(str, of["engine_version"])))) for engine, of in there.groupby("engine")}


def answer_key(question: Hashable) -> str:
    """The key of an answer. Args: question: as `by_question` names it."""
    return _named("answer", question)


def _read(night: Night, store: Store) -> Content:
    versions, machine, samples = versions_of(store), machine_digest(store.machine), store.samples
    canaries = {} if samples.empty else samples.groupby("trial")["canary"].median().to_dict()
    about = NightOf(
        stamp=night.stamp,
        folder=str(night.folder),
        machine=machine,
        processor=str(store.machine.get("processor", "")),
        versions=versions,
        canary=float(np.median(list(canaries.values()))) if canaries else np.nan,
        titles=store.titles,
    )
    questions = by_question(store)
    rows = [
        {**COLUMNS, **row}
        for row in chain(
            _of_trials(store, questions, machine, canaries),
            _of_searches(store, versions),
            _of_answers(store, questions),
            _of_repetitions(store),
        )
    ]
    return {"night": about, "columns": {name: [row[name] for row in rows] for name in COLUMNS}}


def _of_trials(
    store: Store, questions: Mapping[Hashable, Any], machine: str, canaries: Mapping[Any, float]
) -> Iterator[dict[str, Any]]:
    """Prices and errors."""
    headlines = {name: about.get("headline", "") for name, about in store.catalogue.get("cases", {}).items()}
    metrics = {(str(m.trial), str(m.metric)): m for m in store.measurements.itertuples()}
    asked = set(store.asked["trial"])
    for key, row in questions.items():
        if row.trial not in asked:
            continue
        about: dict[str, Any] = {name: str(getattr(row, name)) for name in ("experiment", "case", "engine", "track", "trial")}
        about |= {
            "where": where_of(store.catalogue, row.case, row.parameters),
            "dt": float(row.dt),
            "version": str(row.engine_version),
        }
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
        measured = metrics.get((about["trial"], str(headlines.get(row.case, ""))))
        if measured is not None:
            yield about | {
                "kind": "error",
                "key": _named("error", key),
                "metric": str(measured.metric),
                "unit": str(measured.unit),
                "value": float(measured.value),
                "hash": _text(row.trajectory_hash),
            }


def _of_searches(store: Store, versions: Mapping[str, str]) -> Iterator[dict[str, Any]]:
    """Searches, but for remedies, and the limits that they found."""
    for search in searches(store):
        if search.remedied:
            continue
        key = searched_by(search)
        yield {"kind": "search", "key": _named("search", key), "said": json.dumps(asdict(search))}
        if search.held is not None:
            yield {name: getattr(search, name) for name in ("experiment", "case", "where", "engine", "dt", "unit")} | {
                "kind": "limit",
                "key": _named("limit", key),
                "track": search.setting,
                "metric": search.axis,
                "value": float(search.held),
                "version": versions.get(search.engine, ""),
                "trial": search.trial_held,
            }


def _of_answers(store: Store, questions: Mapping[Hashable, Any]) -> Iterator[dict[str, Any]]:
    values: dict[str, list[str]] = {}
    for row in store.measurements.itertuples():
        values.setdefault(str(row.trial), []).append(f"{row.metric} {float(row.value)!r}")
    for key, row in questions.items():
        measured = "\n".join(sorted(values.get(row.trial, ()))).encode()
        about = {"status": str(row.status), "hash": _text(row.trajectory_hash)}
        yield {"kind": "answer", "key": answer_key(key), "said": hashlib.sha256(measured).hexdigest()[:16]} | about


def _of_repetitions(store: Store) -> Iterator[dict[str, Any]]:
    """Nothing where a history keeps hashes only: a parting cannot be read off these."""
    with suppress(StoreError):
        for cell, repetition in ({} if store.trials.empty else repetitions_by_cell(store)).items():
            yield {"kind": "repetition", "key": _named("repeated", cell), "said": json.dumps(asdict(repetition))}


def _named(kind: str, key: Hashable) -> str:
    return json.dumps([kind, key])


def _text(value: Any) -> str:
    return value if isinstance(value, str) else ""


def _files(night: Night) -> list[Path]:
    """What a night is read from: the journal decides alone where there is one."""
    journal, *tables = (night.folder / name for name in _FILES)
    return [*([journal] if journal.is_file() else tables), *(night.folder / name for name in _BESIDE)]


def _size_and_date(path: Path) -> str:
    if not path.is_file():
        return "missing"
    status = path.stat()
    return f"{status.st_size} {status.st_mtime_ns}"


def _rests_on(night: Night, files: Collection[Path]) -> str:
    """Of the content, which a copy shares whose dates are others."""
    whole = hashlib.sha256(f"{_text_digest()} {night.folder}".encode())
    for path in files:
        content = disk.read(path) if path.is_file() else b""
        whole.update(f"{path.name} {len(content)}\n".encode() + content)
    return whole.hexdigest()


@cache
def _text_digest() -> str:
    """Of the sources that read a run folder and make these values."""
    whole, root = hashlib.sha256(), Path(__file__).parents[1]
    for path in sorted(path for room in _ROOMS for path in (root / room).rglob("*.py")):
        whole.update(f"{path.relative_to(root)}\n".encode() + path.read_bytes())
    return whole.hexdigest()
