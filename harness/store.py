"""A run folder read back as tables, trajectories and catalogue; and its Parquet tables made from the journal."""

import dataclasses
import json
import math
import os
import tomllib
import zipfile
from collections.abc import Sequence
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from harness.journal import NoRun, StoreError, read_journal
from harness.record import Measurement, Record, Sample
from harness.stored_tables import read_tables

__all__ = ["TRIAL_COLUMNS", "NoRun", "Store", "StoreError", "write_atomically", "write_tables"]

_JSON_COLUMNS = ("parameters", "settings", "resolved", "warnings", "alteration")
TRIAL_COLUMNS = tuple(f.name for f in dataclasses.fields(Record) if f.name not in {"measurements", "samples"})
_MEASUREMENT_COLUMNS = ("trial", *(f.name for f in dataclasses.fields(Measurement)))
_SAMPLE_COLUMNS = ("trial", *(f.name for f in dataclasses.fields(Sample)))
_SINCE = {"round": 0, "alteration": "{}", "members": 1, "remedy": "", "remedied": "", "substep": math.nan, "parts": 0}
"""What the trials of a store from before there were these columns mean by their absence."""
_NUMBERS = ("dt", "sim_seconds", "cpu_per_sim_s", "cpu_low", "cpu_high", "wall_per_sim_s", "realtime_factor")
_PRICES = ("cpu_per_unit", "cpu_per_unit_low", "cpu_per_unit_high", "rough_cost", "substep")


def write_atomically(path: Path, content: bytes) -> None:
    """Write a file so that a kill leaves the old one or the new one, never a part."""
    draft = path.with_name(f".{path.name}.{os.getpid()}")
    draft.write_bytes(content)
    draft.replace(path)


def _tables(records: dict[str, Record]) -> dict[str, pd.DataFrame]:
    trials, measurements, samples = [], [], []
    for record in sorted(
        records.values(), key=lambda r: (r.study, r.experiment, r.case, -r.dt, r.seed, r.track, r.engine, r.trial)
    ):
        row = {name: getattr(record, name) for name in TRIAL_COLUMNS}
        row |= {name: json.dumps(row[name], sort_keys=True) for name in _JSON_COLUMNS}
        trials.append(row)
        measurements += [{"trial": record.trial, **dataclasses.asdict(m)} for m in record.measurements]
        samples += [{"trial": record.trial, **dataclasses.asdict(s)} for s in record.samples]
    frame = pd.DataFrame(trials, columns=list(TRIAL_COLUMNS))
    numbers = dict.fromkeys((*_NUMBERS, *_PRICES), "float64")
    frame = frame.astype(numbers | {"unstable_timing": "boolean", "seed": "int64", "steps": "int64"})
    table = pd.DataFrame(measurements, columns=list(_MEASUREMENT_COLUMNS))
    table = table.astype({"value": "float64", "at_most": "float64", "passed": "boolean"})
    return {"trials": frame, "measurements": table, "samples": pd.DataFrame(samples, columns=list(_SAMPLE_COLUMNS))}


def write_tables(folder: Path) -> None:
    """Make the Parquet tables from the journal. Raises: StoreError."""
    for name, frame in _tables(read_journal(folder / "journal.jsonl")).items():
        write_atomically(folder / f"{name}.parquet", frame.to_parquet(index=False))


class Store:
    """A run folder, read only. Tables come from the journal where there is one, so a killed run reads as well as a whole one.

    Terms:
        trials, measurements, samples: tables with the columns of `harness.record`; parameters, settings, resolved and warnings
        hold JSON. catalogue: the questions and engines as they stood when the run was made. machine, study: provenance.
    """

    def __init__(self, folder: Path) -> None:
        self.folder = Path(folder)
        if not (self.folder / "journal.jsonl").is_file() and not (self.folder / "trials.parquet").is_file():
            raise NoRun(f"{self.folder}: no run folder (neither journal.jsonl nor trials.parquet); give the --out of a run")

    @cached_property
    def _read(self) -> dict[str, pd.DataFrame]:
        journal = self.folder / "journal.jsonl"
        if journal.is_file():
            return _tables(read_journal(journal))
        trials = TRIAL_COLUMNS[: TRIAL_COLUMNS.index("trajectory_hash") + 1]
        needed = {"trials": trials, "measurements": ("trial", "metric", "value"), "samples": ("trial",)}
        return read_tables(self.folder, needed, _JSON_COLUMNS)

    @property
    def trials(self) -> pd.DataFrame:
        """One row a trial."""
        trials = self._read["trials"]
        for name, value in _SINCE.items():
            if name not in trials:
                trials[name] = value
        return trials

    @cached_property
    def asked(self) -> pd.DataFrame:
        """The trials that put a case as it is: no ensemble of starts, no scene that departs from the case's."""
        trials = self.trials
        return trials[(trials["members"] == 1) & ~trials["alteration"].str.contains('"name"', regex=False)]

    @property
    def measurements(self) -> pd.DataFrame:
        """One row a metric of a trial."""
        return self._read["measurements"]

    @property
    def samples(self) -> pd.DataFrame:
        """One row a timing sample."""
        return self._read["samples"]

    def _json(self, name: str) -> dict[str, Any]:
        path = self.folder / name
        if not path.is_file():
            return {}
        content: dict[str, Any] = json.loads(path.read_text(encoding="utf-8"))
        return content

    @cached_property
    def catalogue(self) -> dict[str, Any]:
        """Cases and engines: what was asked, of whom."""
        return self._json("catalogue.json")

    @cached_property
    def machine(self) -> dict[str, Any]:
        """The machine, the versions, the command and the dates."""
        return self._json("machine.json")

    @cached_property
    def study(self) -> dict[str, Any]:
        """The study file of the run."""
        path = self.folder / "study.toml"
        return tomllib.loads(path.read_text(encoding="utf-8")) if path.is_file() else {}

    def trajectory(self, trajectory_hash: str, only: Sequence[str] = ()) -> dict[str, NDArray[Any]]:
        """The arrays of one trajectory: time, p_WB, ..., truth_p_WB, ..., contacts_..., stream:..., scene (JSON).

        only: the names of those that are wanted, which are read in less time than all.
        """
        path = self.folder / "trajectories" / f"{trajectory_hash}.npz"
        try:
            with np.load(path, allow_pickle=False) as arrays:
                return {name: arrays[name] for name in only or arrays.files}
        except (OSError, KeyError, ValueError, zipfile.BadZipFile) as error:
            raise StoreError(f"{path}: not readable: {error}") from error
