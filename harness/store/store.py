"""A run folder read back as tables, trajectories and catalogue; and its Parquet tables made from the journal."""

import dataclasses
import hashlib
import json
import math
import tomllib
from collections.abc import Callable, Collection, Mapping, Sequence
from functools import cached_property
from pathlib import Path
from typing import Any, Literal

import pandas as pd
from numpy.typing import NDArray

from plumbline.harness.store import disk
from plumbline.harness.store.arrays import read_arrays
from plumbline.harness.store.journal import DamagedFile, NoRun, NotKept, StoreError, Written, read_journal, read_written
from plumbline.harness.store.notices import StoredNotice, notice_of
from plumbline.harness.store.record import Measurement, Record, Sample
from plumbline.harness.store.rows import records
from plumbline.harness.store.seal import Damaged, check_seal, sealed_json
from plumbline.harness.store.stored_tables import read_tables

_JSON = json.JSONEncoder(sort_keys=True)
_JSON_COLUMNS = ("parameters", "settings", "resolved", "warnings", "alteration", "sources")
TABLES = ("trials", "measurements", "samples")
TRIAL_COLUMNS = tuple(f.name for f in dataclasses.fields(Record) if f.name not in {"base", "idle", "measurements", "samples"})
_MEASUREMENT_COLUMNS = ("trial", *(f.name for f in dataclasses.fields(Measurement)))
_SAMPLE_COLUMNS = ("trial", *(f.name for f in dataclasses.fields(Sample)))
_NUMBERS = ("dt", "sim_seconds", "cpu_per_sim_s", "cpu_low", "cpu_high", "wall_per_sim_s", "realtime_factor")
_PRICES = ("cpu_per_unit", "cpu_per_unit_low", "cpu_per_unit_high", "rough_cost", "substep", "emulated")
_TRIAL_TYPES = dict.fromkeys((*_NUMBERS, *_PRICES), "float64") | {
    "unstable_timing": "boolean",
    "seed": "int64",
    "steps": "int64",
}
_MEASUREMENT_TYPES = {"value": "float64", "at_most": "float64", "passed": "boolean"}


Table = Callable[[Sequence[Mapping[str, Any]], Sequence[str], Mapping[str, str]], pd.DataFrame]
"""A table of these rows and columns, some of which have their types by name."""


def _in_arrow(rows: Sequence[Mapping[str, Any]], columns: Sequence[str], types: Mapping[str, str]) -> pd.DataFrame:
    """A table as pandas makes it, to be written. Most columns have their types: what has is left alone, since each change costs
    as much as the table."""
    frame = pd.DataFrame(rows, columns=list(columns))
    for name, kind in types.items():
        if frame[name].dtype != kind:
            frame[name] = frame[name].astype(kind)
    return frame


def tables_of(records: Mapping[str, Record], table: Table = _in_arrow) -> dict[str, pd.DataFrame]:
    """The tables `TABLES` by name."""
    trials, measurements, samples = [], [], []
    for record in sorted(
        records.values(), key=lambda r: (r.study, r.experiment, r.case, -r.dt, r.seed, r.track, r.engine, r.trial)
    ):
        row = {name: getattr(record, name) for name in TRIAL_COLUMNS}
        row["warnings"] = [str(notice) for notice in record.warnings]
        row |= {name: _JSON.encode(row[name]) for name in _JSON_COLUMNS}
        trials.append(row)
        measurements += [{"trial": record.trial, **_plain(m, _MEASUREMENT_COLUMNS)} for m in record.measurements]
        samples += [{"trial": record.trial, **_plain(s, _SAMPLE_COLUMNS)} for s in record.samples]
    return {
        "trials": table(trials, TRIAL_COLUMNS, _TRIAL_TYPES),
        "measurements": table(measurements, _MEASUREMENT_COLUMNS, _MEASUREMENT_TYPES),
        "samples": table(samples, _SAMPLE_COLUMNS, {"emulated": "float64"}),
    }


def _plain(row: Measurement | Sample, columns: Sequence[str]) -> dict[str, Any]:
    """The fields of a row, all of which are numbers and texts; the first column is not its own."""
    return {name: getattr(row, name) for name in columns[1:]}


def _in_python(rows: Sequence[Mapping[str, Any]], columns: Sequence[str], types: Mapping[str, str]) -> pd.DataFrame:
    """A table with words as Python's own strings: reports take rows and cells out of it by the ten thousand, and each string
    that Arrow keeps is made anew whenever it is looked at."""
    index = pd.RangeIndex(len(rows))
    return pd.DataFrame({name: _column([row[name] for row in rows], index, types.get(name)) for name in columns}, index)


def _column(values: list[Any], index: pd.Index, kind: str | None) -> "list[Any] | pd.Series[Any]":
    """Of that type; or words with nan for none, as the type of words has it, and nothing at all; or what pandas makes of
    numbers."""
    if kind is not None:
        return pd.Series(values, index, kind)
    if values and not any(isinstance(value, str) for value in values):
        return values
    return pd.Series([math.nan if value is None else value for value in values], index, object)


def parquet(frame: pd.DataFrame) -> bytes:
    """The bytes of a table's file; equal tables have equal bytes."""
    made: bytes = disk.calls.filled(lambda: frame.to_parquet(index=False))
    return made


def write_tables(folder: Path) -> dict[str, str]:
    """Make the Parquet tables from the journal, and give the digest of each file's bytes. Raises: StoreError, OSError."""
    digests = {}
    for name, frame in tables_of(read_journal(folder / "journal.jsonl")).items():
        content = parquet(frame)
        disk.write_atomically(folder / f"{name}.parquet", content)
        digests[name] = hashlib.sha256(content).hexdigest()
    return digests


def write_json(path: Path, content: Mapping[str, Any]) -> None:
    """Write a JSON object with its seal. Raises: OSError."""
    disk.write_atomically(path, disk.calls.filled(lambda: sealed_json(path.name, content)))


def read_plain(path: Path) -> dict[str, Any]:
    """What a JSON or TOML file of the store says, without its seal; nothing of one that is not there. Raises: DamagedFile."""
    if not path.is_file():
        return {}
    content = disk.read(path)
    try:
        check_seal(path, content)
        text = content.decode()
        table: dict[str, Any] = tomllib.loads(text) if path.suffix == ".toml" else json.loads(text)
    except (Damaged, ValueError) as error:
        raise DamagedFile(path, str(error), "restore it, or --resume writes it anew") from error
    table.pop("checksum", None)
    return table


def ends_early(written: Written, machine: Mapping[str, Any]) -> str:
    """How a journal ends before the line that it had when its folder's machine.json was written; '' where it does not."""
    known = machine.get("journal", {"lines": 0, "checksum": ""})
    lines, checksum = known["lines"], known["checksum"]
    if lines == 0 or (lines <= len(written.checksums) and written.checksums[lines - 1] == checksum):
        return ""
    if lines > len(written.checksums):
        return f"ends at line {len(written.checksums)}, and had {lines}: what the others held is missing"
    return f"line {lines} is another than was there when a run last ended: the file was exchanged"


class Store:
    """A run folder, read only. Tables come from the journal where there is one, so a killed run reads as well as a whole one.

    Terms:
        trials, measurements, samples: tables with the columns of `harness.store.record`; parameters, settings, resolved
        and warnings hold JSON. catalogue: the questions and engines as they stood when the run was made. machine, study:
        provenance.
    """

    def __init__(self, folder: Path, only: Collection[tuple[str, str]] | None = None) -> None:
        """Args: only: these experiments and cases, all for None. Raises: NoRun."""
        self.folder, self._only = Path(folder), only
        if not (self.folder / "journal.jsonl").is_file() and not (self.folder / "trials.parquet").is_file():
            raise NoRun(f"{self.folder}: no run folder (neither journal.jsonl nor trials.parquet); give the --out of a run")

    def part(self, only: Collection[tuple[str, str]]) -> "Store":
        """The same folder with these experiments and cases alone; its journal is not read again."""
        other = Store(self.folder, only)
        if (self.folder / "journal.jsonl").is_file():
            other.__dict__["_written"] = self._written
        return other

    @cached_property
    def _written(self) -> Written:
        return read_written(self.folder / "journal.jsonl")

    @property
    def notes(self) -> tuple[str, ...]:
        """What a reader has to know of how the folder came down: what was dropped, what is missing. Raises: StoreError."""
        written = self._written
        early = ends_early(written, self.machine)
        return (*written.notes, *([f"{written.path}: {early}"] if early else []))

    @cached_property
    def _read(self) -> dict[str, pd.DataFrame]:
        journal = self.folder / "journal.jsonl"
        if journal.is_file():
            records, only = self._written.records, self._only
            if only is not None:
                records = {name: record for name, record in records.items() if (record.experiment, record.case) in only}
            return tables_of(records, _in_python)
        needed = {"trials": TRIAL_COLUMNS, "measurements": ("trial", "metric", "value"), "samples": ("trial",)}
        return read_tables(self.folder, needed, _JSON_COLUMNS)

    @property
    def trials(self) -> pd.DataFrame:
        """One row a trial."""
        return self._read["trials"]

    @cached_property
    def notices(self) -> Mapping[str, tuple[StoredNotice, ...]]:
        """What the engine of each trial, its adapter or the harness said, by trial."""
        if (self.folder / "journal.jsonl").is_file():
            return {trial: record.warnings for trial, record in self._written.records.items()}
        sentences = zip(self.trials["trial"], self.trials["warnings"], strict=True)
        return {str(trial): tuple(map(notice_of, json.loads(text))) for trial, text in sentences}

    @cached_property
    def bases(self) -> Mapping[str, str]:
        """The track that the settings of each trial descend from, by trial."""
        if (self.folder / "journal.jsonl").is_file():
            return {trial: record.base for trial, record in self._written.records.items()}
        tracks = zip(self.trials["trial"], self.trials["track"], strict=True)
        return {str(trial): str(track).partition(",")[0] for trial, track in tracks}  # what was turned stands behind a comma

    @cached_property
    def idle(self) -> Mapping[str, tuple[tuple[str, Any], ...]]:
        """By trial, the knobs and values that change nothing from there; of trials that were asked for them alone."""
        if not (self.folder / "journal.jsonl").is_file():
            return {}
        return {trial: record.idle for trial, record in self._written.records.items() if record.idle}

    @cached_property
    def asked(self) -> pd.DataFrame:
        """The trials that put a case as it is: no ensemble of starts, no scene that departs from the case's."""
        trials = self.trials
        named = {text for text in trials["alteration"].unique() if "name" in json.loads(text)}
        return trials[(trials["members"] == 1) & ~trials["alteration"].isin(named)]

    @cached_property
    def tried(self) -> Mapping[str, Sequence[Mapping[str, Any]]]:
        """The rows of `trials` of each case."""
        rows: dict[str, list[Mapping[str, Any]]] = {}
        for row in records(self.trials):
            rows.setdefault(row["case"], []).append(row)
        return rows

    @property
    def measurements(self) -> pd.DataFrame:
        """One row a metric of a trial."""
        return self._read["measurements"]

    @cached_property
    def measured(self) -> Mapping[str, Sequence[Mapping[str, Any]]]:
        """The rows of `measurements` of each trial."""
        rows: dict[str, list[Mapping[str, Any]]] = {}
        for row in records(self.measurements):
            rows.setdefault(row["trial"], []).append(row)
        return rows

    @property
    def samples(self) -> pd.DataFrame:
        """One row a timing sample."""
        return self._read["samples"]

    @cached_property
    def catalogue(self) -> dict[str, Any]:
        """Cases and engines: what was asked, of whom."""
        return read_plain(self.folder / "catalogue.json")

    @property
    def titles(self) -> dict[str, str]:
        """What cases and engines are called, by name, where the catalogue says so."""
        kinds = (self.catalogue.get(kind, {}) for kind in ("cases", "engines"))
        return {name: str(about["title"]) for kind in kinds for name, about in kind.items() if about.get("title")}

    def described(self, kind: Literal["cases", "engines"], name: str) -> Mapping[str, Any]:
        """The entry of a case or an engine in the catalogue, for what cannot be worked out without. Raises: StoreError."""
        path, known = self.folder / "catalogue.json", self.catalogue.get(kind, {})
        if name not in known:
            why = f"{kind} lacks {name!r}" if path.is_file() else f"missing, and with it what {name!r} was asked"
            raise StoreError(f"{path}: {why}; restore the file, or run the study again with --resume, which writes it anew")
        entry: Mapping[str, Any] = known[name]
        return entry

    @cached_property
    def machine(self) -> dict[str, Any]:
        """The machine, the versions, the command and the dates."""
        return read_plain(self.folder / "machine.json")

    @cached_property
    def night(self) -> dict[str, Any]:
        """What a history says of this run, where it is one of its nights."""
        return read_plain(self.folder / "night.json")

    @cached_property
    def study(self) -> dict[str, Any]:
        """The study file of the run."""
        return read_plain(self.folder / "study.toml")

    @cached_property
    def _not_kept(self) -> Mapping[str, str]:
        """A trial of each trajectory of which the hash alone was kept, by that hash; '' of those that were kept."""
        table = self.trials
        first: dict[str, str] = {}
        for name, trial, kept in zip(table["trajectory_hash"], table["trial"], table["trajectory_kept"], strict=True):
            first[name] = "" if kept else first.get(name, str(trial))
        return first

    def trajectory(self, trajectory_hash: str, only: Sequence[str] = ()) -> dict[str, NDArray[Any]]:
        """The arrays of one trajectory: time, p_WB, ..., truth_p_WB, ..., contacts_..., stream:..., scene (JSON).

        only: the names of those that are wanted, which are read in less time than all.
        """
        path = self.folder / "trajectories" / f"{trajectory_hash}.npz"
        try:
            return read_arrays(path, only)
        except FileNotFoundError as error:
            if trial := self._not_kept.get(trajectory_hash):
                again = f"plumbline reproduce {self.folder} {trial} runs it again"
                raise NotKept(f"{path}: kept by its hash alone; {again}") from error
            raise StoreError(f"{path}: missing; --resume makes it anew") from error
        except (Damaged, OSError) as error:
            raise StoreError(f"{path}: not readable: {error}; --resume makes it anew") from error
