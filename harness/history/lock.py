"""Two nights never meet: whoever holds a history's lock writes to it, and lets it go by ending, however that happens."""

import fcntl
import json
import os
import socket
from collections.abc import Iterator
from contextlib import contextmanager
from datetime import UTC, datetime
from typing import Any

from plumbline.harness.history.folder import SCHEMA, History
from plumbline.harness.store import disk
from plumbline.harness.store.journal import StoreError


def holder() -> dict[str, Any]:
    """Who this process is, for others to read."""
    moment = datetime.now(UTC).isoformat(timespec="seconds")
    return {"schema": SCHEMA, "host": socket.gethostname(), "process": os.getpid(), "since": moment}


@contextmanager
def locked(history: History) -> Iterator[None]:
    """Hold a history; the file says who does, the system lets it go when the process ends.

    Raises: StoreError, where another process holds it. OSError.
    """
    path = history.root / "lock"
    if os.path.lexists(path) and not path.is_file():
        raise StoreError(f"{path}: is no file; delete it")
    descriptor = disk.calls.open(path, os.O_RDWR | os.O_CREAT)
    try:
        try:
            fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError as error:
            content = os.pread(descriptor, 1000, 0).decode(errors="replace")
            raise StoreError(f"{history.root}: another night holds it ({_words(content)}); wait for its end") from error
        disk.calls.truncate(descriptor, 0)
        os.pwrite(descriptor, json.dumps(holder()).encode(), 0)
        yield
        disk.calls.truncate(descriptor, 0)
    finally:
        os.close(descriptor)


def _words(content: str) -> str:
    try:
        known = json.loads(content)
        return f"process {known['process']} on {known['host']} since {known['since']}"
    except (ValueError, KeyError, TypeError):
        return "it does not say who"
