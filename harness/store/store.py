"""A run folder read back as tables, trajectories and catalogue."""

import json
import tomllib
from collections.abc import Collection, Mapping, Sequence
from functools import cached_property
from pathlib import Path
from typing import Any, Literal

import pandas as pd
from numpy.typing import NDArray

from plumbline.harness.store import disk
from plumbline.harness.store.arrays import read_arrays
from plumbline.harness.store.forms import FORMS
from plumbline.harness.store.journal import DamagedFile, LineChain, NoRun, NotKept, StoreError, Written, read_written
from plumbline.harness.store.record import StoredNotice, checked, notice_of
from plumbline.harness.store.rows import records
from plumbline.harness.store.seal import Damaged, check_seal, sealed_json
from plumbline.harness.store.stored_tables import BESIDE, COLUMNS, read_tables, tables_of


class _Entry(dict[str, Any]):
    """An entry of the catalogue, which says what it lacks: folders of older versions have fewer fields."""

    def __init__(self, fields: Mapping[str, Any], where: str) -> None:
        super().__init__(fields)
        self._where = where

    def __missing__(self, field: str) -> Any:
        raise StoreError(f"{self._where} lacks {field!r}; run the study again with --resume, which writes the catalogue anew")


def write_json(path: Path, content: Mapping[str, Any]) -> None:
    """Write a JSON object with its seal. Raises: OSError."""
    disk.write_atomically(path, disk.calls.filled(lambda: sealed_json(path.name, content)))


def read_plain(path: Path) -> dict[str, Any]:
    """What a JSON or TOML file of the store says, without its seal; nothing of one that is not there.

    Raises: DamagedFile, for what is no regular file, has another seal or none, or other content than its kind has. A folder of
    tables alone, which another program may have written, needs no seals.
    """
    try:
        content = disk.read(path)
    except FileNotFoundError:
        return {}
    try:
        if not check_seal(path, content) and (path.name not in FORMS or (path.parent / "journal.jsonl").exists()):
            raise Damaged("it has no checksum")
        text = content.decode()
        table: dict[str, Any] = tomllib.loads(text) if path.suffix == ".toml" else json.loads(text)
        checked(FORMS.get(path.name, dict), table, path.stem)
    except (Damaged, ValueError, RecursionError) as error:
        raise DamagedFile(path, str(error), "restore it, or --resume writes it anew") from error
    table.pop("checksum", None)
    return table


def ends_early(written: LineChain[Any], machine: Mapping[str, Any]) -> str:
    """How a journal ends before the line that it had when its folder's machine.json was written; '' where it does not."""
    known = machine.get("journal") or {"lines": 0, "checksum": ""}
    lines, checksum = known["lines"], known["checksum"]
    if lines == 0 or (lines <= len(written.checksums) and written.checksums[lines - 1] == checksum):
        return ""
    if lines > len(written.checksums):
        return f"ends at line {len(written.checksums)}, and had {lines}: what the others held is missing"
    return f"line {lines} is another than was there when a run last ended: the file was exchanged"


class Store:
    """A run folder, read only. Tables older than the journal are made of it: a killed run reads as well as a whole one.

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
        """The same folder with these experiments and cases alone; its tables are not read again."""
        other = Store(self.folder, only)
        other.__dict__["_whole"] = self._whole
        return other

    @cached_property
    def _written(self) -> Written:
        return read_written(self.folder / "journal.jsonl")

    @property
    def notes(self) -> tuple[str, ...]:
        """What a reader has to know of how the folder came down: what was dropped, what is missing. Raises: StoreError."""
        if self.up_to_date:
            return ()
        written = self._written
        early = ends_early(written, self.machine)
        return (*written.notes, *([f"{written.path}: {early}"] if early else []))

    @cached_property
    def up_to_date(self) -> bool:
        """Were the tables written of the journal that is there, and are they as they were written?"""
        try:
            ended, tables = (self.machine.get("journal") or {}).get("content"), self.machine.get("tables", {})
        except StoreError:  # told by whoever needs the machine
            return False
        files = {self.folder / "journal.jsonl": ended} | {self.folder / f"{name}.parquet": tables.get(name) for name in COLUMNS}
        return bool(ended) and all(path.is_file() and disk.digest(path) == due for path, due in files.items())

    @cached_property
    def _whole(self) -> dict[str, pd.DataFrame]:
        """The tables with all their rows, those of a journal without reading it where they are up to date."""
        journal = self.folder / "journal.jsonl"
        made_anew = journal.is_file() and not self.up_to_date
        return tables_of(self._written.records.values()) if made_anew else read_tables(self.folder)

    @cached_property
    def _read(self) -> dict[str, pd.DataFrame]:
        tables, only = self._whole, self._only
        if only is not None:
            trials = tables["trials"]
            chosen = [pair in only for pair in zip(trials["experiment"], trials["case"], strict=True)]
            names = frozenset(trials["trial"][chosen])
            tables = {name: table[table["trial"].isin(names)].reset_index(drop=True) for name, table in tables.items()}
        trials = tables["trials"]
        beside = trials[[name for name in BESIDE if name in trials]]
        return tables | {"trials": trials.drop(columns=list(beside)), "beside": beside}

    @property
    def trials(self) -> pd.DataFrame:
        """One row a trial."""
        return self._read["trials"]

    def _beside(self, column: str) -> Mapping[str, str]:
        """By trial, what its table holds beside what is shown; nothing where another program wrote it."""
        beside = self._read.get("beside", {})
        return dict(zip(self.trials["trial"], beside[column], strict=True)) if column in beside else {}

    @cached_property
    def notices(self) -> Mapping[str, tuple[StoredNotice, ...]]:
        """What the engine of each trial, its adapter or the harness said, by trial."""
        if texts := self._beside("notices"):
            read = {text: tuple(StoredNotice(**each) for each in json.loads(text)) for text in set(texts.values())}
            return {trial: read[text] for trial, text in texts.items()}
        sentences = zip(self.trials["trial"], self.trials["warnings"], strict=True)
        return {str(trial): tuple(map(notice_of, json.loads(text))) for trial, text in sentences}

    @cached_property
    def bases(self) -> Mapping[str, str]:
        """The track that the settings of each trial descend from, by trial."""
        tracks = zip(self.trials["trial"], self.trials["track"], strict=True)
        turned = {str(trial): str(track).partition(",")[0] for trial, track in tracks}  # what was turned stands behind a comma
        return self._beside("base") or turned

    @cached_property
    def idle(self) -> Mapping[str, tuple[tuple[str, Any], ...]]:
        """By trial, the knobs and values that change nothing from there; of trials that were asked for them alone."""
        stored = ((trial, json.loads(text)) for trial, text in self._beside("idle").items() if text != "[]")
        return {trial: tuple((knob, value) for knob, value in turns) for trial, turns in stored}

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

    def values(self, trial: str) -> dict[str, float]:
        """What each metric says of a trial; of one that is checked twice, once."""
        return {row["metric"]: row["value"] for row in reversed(self.measured.get(trial, ()))}

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
        """The entry of a case or an engine in the catalogue, for what cannot be worked out without.

        Raises: StoreError, for an entry that is not there, and by the entry itself for a field that it has not.
        """
        path, known = self.folder / "catalogue.json", self.catalogue.get(kind, {})
        if name not in known:
            why = f"{kind} lacks {name!r}" if path.is_file() else f"missing, and with it what {name!r} was asked"
            raise StoreError(f"{path}: {why}; restore the file, or run the study again with --resume, which writes it anew")
        return _Entry(known[name], f"{path}: {kind}: {name!r}")

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
            return read_arrays(path, only, sealed=(self.folder / "journal.jsonl").is_file())
        except FileNotFoundError as error:
            if trial := self._not_kept.get(trajectory_hash):
                again = f"plumbline reproduce {self.folder} {trial} runs it again"
                raise NotKept(f"{path}: kept by its hash alone; {again}") from error
            raise StoreError(f"{path}: missing; --resume makes it anew") from error
        except (Damaged, OSError) as error:
            raise StoreError(f"{path}: not readable: {error}; --resume makes it anew") from error
