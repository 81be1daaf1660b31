"""Third parties' plug-ins: each is loaded in a process of its own before this one loads it, so that none takes others along.

A plug-in that loads is not tried again until a file of its package changes; one that does not is tried each time.
"""

import hashlib
import os
import signal
import subprocess
import sys
from contextlib import suppress
from functools import cache
from importlib.machinery import PathFinder
from importlib.metadata import EntryPoint, EntryPoints, entry_points
from pathlib import Path

PATIENCE = 20.0
"""Seconds that a plug-in may take to load."""
_LONGEST = 2000
_FINE = b"loaded"
_SCRIPT = """
import os, sys
from importlib.metadata import EntryPoint
pipe, name, value, group = int(sys.argv[1]), *sys.argv[2:]
try:
    found = EntryPoint(name, value, group).load()
    try:
        found.version()
    except Exception:
        pass
    said = b"loaded"
except BaseException as error:
    room = (getattr(error, "name", None) or "").partition(".")[0] if isinstance(error, ImportError) else ""
    hint = f"; import plumbline.{room} instead" if room in ("adapters", "cases", "engine", "harness", "reports") else ""
    said = f"{type(error).__name__}: {error}{hint}".encode("utf-8", "backslashreplace")
os.write(pipe, said[:2000])
os._exit(0)
"""


def points(group: str) -> dict[str, EntryPoint]:
    """The entry points of a group by name."""
    return {point.name: point for point in _all(tuple(sys.path)).select(group=group)}


@cache
def _all(path: tuple[str, ...]) -> EntryPoints:  # noqa: ARG001  # what is found depends on it
    """Those of all packages, which takes a tenth of a second to read, once for each `path` of the interpreter."""
    return entry_points()  # type: ignore[return-value]  # the stub knows what they are from Python 3.12 on


def trouble(point: EntryPoint) -> str:
    """Why a plug-in cannot be loaded; '' where it can."""
    return _trouble(point.name, point.value, point.group)


@cache
def _trouble(name: str, value: str, group: str) -> str:
    seen = _place(f"{sys.version} {group} {name} {value}", value)
    if seen is not None and seen.exists():
        return ""
    failure = _tried(name, value, group)
    if not failure and seen is not None:
        with suppress(OSError):
            seen.parent.mkdir(parents=True, exist_ok=True)
            seen.touch()
    return failure


def _place(what: str, value: str) -> Path | None:
    """The file that says that a plug-in has loaded, by all that it depends on; None where its files are not found."""
    import platformdirs  # late: only third parties' plug-ins need it

    spec = PathFinder.find_spec(value.partition(":")[0].partition(".")[0])
    if spec is None:
        return None
    folders = [Path(folder) for folder in spec.submodule_search_locations or ()]
    files = sorted(file for folder in folders for file in folder.rglob("*.py")) or [Path(spec.origin or "")]
    digest = hashlib.sha256(what.encode())
    try:
        for file in files:
            digest.update(f"{file}\0".encode() + file.read_bytes())
    except OSError:
        return None
    return Path(platformdirs.user_cache_dir("plumbline")) / "plugins" / digest.hexdigest()


def _tried(name: str, value: str, group: str) -> str:
    """Load it in a new process: '' if that goes well, else what became of it."""
    ours, theirs = os.pipe()
    command = [sys.executable, "-c", _SCRIPT, str(theirs), name, value, group]
    none = subprocess.DEVNULL
    # It is to find what this process finds, wherever that has been told to look.
    environment = os.environ | {"PYTHONPATH": os.pathsep.join(sys.path)}
    child = subprocess.Popen(
        command, pass_fds=[theirs], start_new_session=True, stdin=none, stdout=none, stderr=none, env=environment
    )
    os.close(theirs)
    try:
        code = child.wait(PATIENCE)
        ended = f"ends the process that loads it (exit code {code})"
    except subprocess.TimeoutExpired:
        ended = f"does not load within {PATIENCE:g} s"
    with suppress(ProcessLookupError, PermissionError):
        os.killpg(child.pid, signal.SIGKILL)
    child.wait()
    os.set_blocking(ours, False)
    answer = b""
    with suppress(BlockingIOError):
        answer = os.read(ours, _LONGEST)
    os.close(ours)
    if answer == _FINE:
        return ""
    return f"{value}: {answer.decode('utf-8', 'replace') or ended}"
