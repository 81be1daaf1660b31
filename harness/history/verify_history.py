"""Is a history still what was written? Its nights as run folders, their own files, and every answer of the pool."""

import json
from collections.abc import Iterator
from pathlib import Path

from plumbline.harness.history.answer_store import Pool
from plumbline.harness.history.folder import NIGHT, History
from plumbline.harness.history.identity import acknowledged
from plumbline.harness.history.readings import FOLDER
from plumbline.harness.run.verify import Problem, problems
from plumbline.harness.store import disk
from plumbline.harness.store.arrays import kept_hash, read_arrays
from plumbline.harness.store.journal import StoreError
from plumbline.harness.store.seal import Damaged, require_seal

_AGAIN = "delete it; the next night computes it again"
_KNOWN = ("history.json", "lock", "nights", "pool", "acknowledged.jsonl", FOLDER, "report")


def problems_of(history: History) -> Iterator[Problem]:
    """All that is wrong with a history, file by file; it is only read. Raises: StoreError."""
    yield from _sealed(history.root / "history.json", "restore it")
    for error in (*acknowledged(history)[1], *history.unread()):
        yield Problem(error.path, error.what, error.cure)
    sound = set[tuple[int, int]]()
    yield from _pool(Pool(history.pool), sound)
    for night in history.nights():
        path = night.folder / NIGHT
        yield from _sealed(path, "restore it, or delete the night")
        if not night.whole:
            yield Problem(path, "the night did not come to its end", "the next call goes on with it where it asks the same")
        yield from problems(night.folder, sound, night.plan.get("summaries", {}))
    for path in sorted(history.root.glob("*")):
        if path.name not in _KNOWN:
            yield Problem(path, "is not of this history", "nothing needs it; delete it")


def _sealed(path: Path, cure: str) -> Iterator[Problem]:
    try:
        if not path.is_file():
            yield Problem(path, "missing", cure)
        else:
            require_seal(path, disk.read(path))
    except Damaged as error:
        yield Problem(path, str(error), cure)


def _pool(pool: Pool, sound: set[tuple[int, int]]) -> Iterator[Problem]:
    """Args: sound: takes in the trajectories that are; a night's own are mostly the same files under other names."""
    for path in pool.answers():
        yield from _sealed(path, _AGAIN)
        try:
            answer = pool.answer(path.stem)
        except (StoreError, ValueError, KeyError, TypeError, json.JSONDecodeError):
            continue  # its seal said so
        if answer is None or answer.trial != path.stem:
            yield Problem(path, "is the answer to another trial than its name says", _AGAIN)
    for path in pool.trajectories():
        try:
            require_seal(path, disk.read(path))
            if kept_hash(read_arrays(path)) != path.stem:
                raise Damaged("its answer is not the one that its name says")
            sound.add((path.stat().st_dev, path.stat().st_ino))
        except (Damaged, KeyError) as error:
            yield Problem(path, str(error), "delete it; its hash is kept in the journals")
