"""What nights were read to say, kept beside them: a night that is over does not change, and is read once.

A file names all that it rests on: the night's own files, and the texts of the rooms that read them. Where one is another, or
the file is damaged, the night is read anew.
"""

import hashlib
import json
from collections.abc import Callable, Collection
from dataclasses import asdict
from functools import cache
from pathlib import Path
from typing import Any, TypeVar

from pydantic import TypeAdapter

from plumbline.harness.history.folder import History, Night
from plumbline.harness.history.night_readings import Answers, Numbers, answers_of, numbers_of
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
_Said = TypeVar("_Said", Numbers, Answers)


class KeptReadings:
    """The readings of a history's nights. Each is made when it is wanted and not there."""

    def __init__(self, history: History) -> None:
        self._history = history

    def numbers(self, night: Night, store: Store) -> Numbers:
        """Its prices, errors and limits. Args: store: of the night, read where it has to be. Raises: StoreError, OSError."""
        return self._kept(night, "numbers", Numbers, lambda: numbers_of(night, store))

    def answers(self, night: Night, store: Store) -> Answers:
        """Its answers, searches and repetitions; likewise. Raises: StoreError, OSError."""
        return self._kept(night, "answers", Answers, lambda: answers_of(store))

    def _kept(self, night: Night, kind: str, kept_as: type[_Said], read: Callable[[], _Said]) -> _Said:
        path = self.path_of(night.stamp, kind)
        rests_on = f"{_text_digest()} {_night_digest(night)}"
        try:
            kept = read_plain(path)
            if kept.get("rests_on") == rests_on:
                reading: _Said = _form(kept_as).validate_json(kept["said"])
                return reading
        except (StoreError, KeyError, ValueError):
            pass  # it is made of what is there still
        said = read()
        content: dict[str, Any] = {"rests_on": rests_on, "said": json.dumps(asdict(said))}
        disk.make_folder(path.parent)
        disk.write_atomically(path, sealed_json(path.name, content))
        return said

    def of_others(self, stamps: Collection[str]) -> tuple[Path, ...]:
        """The files that are of none of these nights."""
        paths = sorted((self._history.root / FOLDER).glob("*.json"))
        return tuple(path for path in paths if path.name.partition(".")[0] not in stamps)

    def path_of(self, stamp: str, kind: str) -> Path:
        """Where a reading of the night of that name lies, or would."""
        return self._history.root / FOLDER / f"{stamp}.{kind}.json"


_form: Any = cache(TypeAdapter)


def _night_digest(night: Night) -> str:
    """Of its files: the journal decides alone where there is one."""
    files = _FILES[:1] if (night.folder / _FILES[0]).is_file() else _FILES[1:]
    whole = hashlib.sha256(str(night.folder).encode())
    for path in (night.folder / name for name in (*files, *_BESIDE)):
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
