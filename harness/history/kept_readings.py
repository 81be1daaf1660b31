"""What nights were read to say, kept beside them: a night that is over does not change, and is read once.

A file names all that it rests on: the night's own files, and the texts of the rooms that read them. Where one is another, or
the file is damaged, the night is read anew.
"""

import hashlib
import json
from collections.abc import Collection, Mapping
from contextlib import suppress
from dataclasses import asdict
from functools import cache
from pathlib import Path
from typing import Any

import pandas as pd
from pydantic import TypeAdapter

from plumbline.harness.findings.limits_found import Search
from plumbline.harness.findings.tables.determinism import Agreement
from plumbline.harness.history.folder import History, Night
from plumbline.harness.history.night_readings import NightOf, Readings, readings_of
from plumbline.harness.store import disk
from plumbline.harness.store.journal import StoreError
from plumbline.harness.store.seal import sealed_json
from plumbline.harness.store.store import Store, read_plain
from plumbline.harness.store.stored_tables import TABLES

FOLDER = "readings"
"""Of a history; what it holds may be deleted at any time."""
_FILES = ("journal.jsonl", *(f"{name}.parquet" for name in TABLES))
"""What a night's records are read from: its journal or, where a run folder was put there without one, its tables."""
_BESIDE = ("catalogue.json", "machine.json", "study.toml")
_ROOMS = ("findings", "history", "search", "statistics", "store")


def kept_readings(history: History, night: Night, store: Store) -> Readings:
    """The readings of a night, made where they are not there. Args: store: of the night, read where it has to be.

    Raises: StoreError, OSError.
    """
    path = path_of(history, night.stamp)
    files = _files(night)
    dates = [_text_digest(), str(night.folder), *(f"{file.name} {_size_and_date(file)}" for file in files)]
    try:
        stored = read_plain(path)
        if stored["dates"] == dates or stored["rests_on"] == _rests_on(night, files):
            return _restored(json.loads(stored["said"]))
    except (StoreError, KeyError, TypeError, ValueError):
        pass  # it is made of what is there still
    reading = readings_of(night, store)
    content = {"dates": dates, "rests_on": _rests_on(night, files), "said": json.dumps(_plain(reading))}
    with suppress(OSError):  # of a history that can only be read, each reader reads the nights anew
        disk.make_folder(path.parent)
        disk.write_atomically(path, sealed_json(path.name, content))
    return reading


def of_others(history: History, stamps: Collection[str]) -> tuple[Path, ...]:
    """The files that are of none of these nights."""
    mine = {path_of(history, stamp) for stamp in stamps}
    return tuple(path for path in sorted((history.root / FOLDER).glob("*.json")) if path not in mine)


def path_of(history: History, stamp: str) -> Path:
    """Where the readings of the night of that name lie, or would."""
    return history.root / FOLDER / f"{stamp}.json"


def _plain(reading: Readings) -> dict[str, Any]:
    return {  # numbers that are not finite among them
        "night": asdict(reading.night),
        "columns": {name: reading.table[name].tolist() for name in reading.table.columns},
        "searches": [asdict(search) for search in reading.searches],
        "repetitions": {name: asdict(agreement) for name, agreement in reading.repetitions.items()},
    }


def _restored(plain: Mapping[str, Any]) -> Readings:
    """Raises: ValueError, KeyError, TypeError."""
    return Readings(
        night=NightOf(**plain["night"]),
        table=pd.DataFrame(plain["columns"]),
        searches=_form(tuple[Search, ...]).validate_python(plain["searches"]) if plain["searches"] else (),
        repetitions=_form(dict[str, Agreement]).validate_python(plain["repetitions"]) if plain["repetitions"] else {},
    )


_form: Any = cache(TypeAdapter)


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
