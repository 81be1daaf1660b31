"""Making the environment of an engine version: an interpreter of its own, laid over what is installed beside plumbline.

The engine itself is installed into it; everything else, NumPy above all, is read from where plumbline's own packages lie, so
that two versions of an engine are compared among the same libraries. It is made once and kept.
"""

import fcntl
import json
import os
import re
import shutil
import sys
import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from plumbline.harness.intake.bounded import bounded
from plumbline.harness.intake.safe_text import one_line
from plumbline.harness.study import plugins, sources
from plumbline.harness.study.engine_versions import EngineVersion
from plumbline.harness.study.environments import (
    Environment,
    environment_of,
    folder_of,
    installed_folders,
    keep,
    lock_of,
    project_folders,
    root,
)

_INSTALLS = 900.0
_TRIES = 300.0
"""Seconds that installing, and the checks of `harness.conformance.smoke`, may take, beside what the engine compiles."""
_LONGEST = 400
_ADDRESS = re.compile(r"\b[a-z+]+://\S+")
_FRAME = re.compile(r"[^\x00-\x7f]+")


class NotMade(Exception):
    """An environment could not be made; the text says why, in the words of who installs."""


def ensure(version: EngineVersion, distribution: str) -> Environment:
    """The environment of a version, made where it is not there, tried again where the adapter has changed or it failed.

    Args: distribution: the package that holds the engine. Raises: OSError.
    """
    digest = sources.digest_of(sources.closure([plugins.module_of("adapters", version.engine) or ""]))
    folder = folder_of(version.name)
    folder.parent.mkdir(parents=True, exist_ok=True)
    with (folder.parent / f"{folder.name}.lock").open("w") as lock:
        os.utime(lock.name)  # when it was last asked for, see `harness.run.make_environment`
        # Another run may be making it: whoever waited finds it made.
        fcntl.flock(lock, fcntl.LOCK_EX)
        known = environment_of(version.name)
        if known is not None and not known.reason and known.sources == digest:
            return known
        try:
            if known is None or not Path(known.executable).is_file():
                pins = lock_of(version.name)
                if pins is None:
                    _make(folder, str(version.wheel or f"{distribution}=={version.version}"))
                else:
                    _make_locked(folder, pins)
            tried = replace(_tried(version, digest), distribution=distribution)
        except NotMade as error:
            tried = Environment(reason=str(error), sources=digest, distribution=distribution)
        keep(version.name, tried)
        return tried


def _interpreter(folder: Path) -> Path:
    return folder / ("Scripts/python.exe" if os.name == "nt" else "bin/python")


def _bare(folder: Path) -> str | None:
    """Make a folder with an interpreter that has nothing; what was there is gone. Returns: uv, if there is. Raises: NotMade."""
    shutil.rmtree(folder, ignore_errors=True)
    uv = shutil.which("uv")
    bare = [uv, "venv", "--quiet", "--python", sys.executable] if uv else [sys.executable, "-m", "venv", "--without-pip"]
    _run([*bare, str(folder)])
    return uv


def _make_locked(folder: Path, lock: Path) -> None:
    """Make a folder with an interpreter that has what a lock file pins, by its hashes. Raises: NotMade, OSError."""
    _install(_bare(folder), folder, ["--require-hashes", "-r", str(lock)])
    _lay_over(folder)


def _make(folder: Path, what: str) -> None:
    """Make a folder with an interpreter that has this package. Raises: NotMade, OSError."""
    uv = _bare(folder)
    # First the engine alone, so that none of what it is laid over can stand for it; then what it needs beyond that.
    _install(uv, folder, [what, "--no-deps"])
    _lay_over(folder)
    pins = folder / "pins.txt"
    known = sources.library_versions().items()
    pins.write_text("".join(f"{name}=={pin}\n" for name, pin in known if pin), encoding="utf-8")
    _install(uv, folder, [what, "--constraint", str(pins)])


def _lay_over(folder: Path) -> None:
    """Let the interpreter find this one's packages behind its own. Raises: NotMade."""
    ask = "import sysconfig; print(sysconfig.get_path('purelib'))"
    own = Path(_run([str(_interpreter(folder)), "-c", ask]).strip())
    lines = [f"import site; site.addsitedir({place!r})" for place in installed_folders()]
    (own / "beneath.pth").write_text("\n".join(lines) + "\n", encoding="utf-8")


def _install(uv: str | None, folder: Path, what: Sequence[str]) -> None:
    """Raises: NotMade."""
    if uv:
        _run([uv, "pip", "install", "--quiet", "--python", str(_interpreter(folder)), *what])
        return
    pip = [sys.executable, "-m", "pip", "--python", str(_interpreter(folder))]
    _run([*pip, "install", "--quiet", "--no-input", "--disable-pip-version-check", *what])


def _run(command: Sequence[str]) -> str:
    """What a command prints. Raises: NotMade, with the last that it said where it fails."""
    ended = bounded(command, _INSTALLS)
    if ended.code is None:
        raise NotMade(f"its environment was not made within {_INSTALLS:g} s")
    if ended.code != 0:
        raise NotMade(last_error(ended.err.decode("utf-8", "replace")) or f"{command[0]} {ended.how}")
    return ended.out.decode("utf-8", "replace")


def last_error(said: str) -> str:
    """The last error that was told, on one line, without addresses: they may hold what is nobody's business."""
    lines = [_FRAME.sub(" ", line).strip() for line in said.splitlines()]
    errors = [line for line in lines if line.startswith(("ERROR", "error"))] or [line for line in lines if line]
    return one_line(_ADDRESS.sub("<address>", errors[-1]), _LONGEST) if errors else ""


def _tried(version: EngineVersion, digest: str) -> Environment:
    """The environment as the smoke checks find it. Raises: NotMade, OSError."""
    interpreter, ours = str(_interpreter(folder_of(version.name))), project_folders()
    command = [interpreter, "-P", "-m", "plumbline.harness.conformance.smoke", version.engine]
    allowed = _TRIES + plugins.adapter(version.engine).compile_allowance
    ended = bounded(command, allowed, answers=True, env={**os.environ, "PYTHONPATH": os.pathsep.join(ours)})
    if ended.code is None or not ended.answer:
        words = last_error(ended.err.decode("utf-8", "replace"))
        return Environment(interpreter, reason=f"its smoke checks {ended.how}{': ' * bool(words)}{words}", sources=digest)
    found = json.loads(ended.answer)
    path = tuple(place for place in found["path"] if place not in ours)
    return Environment(interpreter, path, found["version"], one_line(found["reason"], _LONGEST), digest)


@dataclass(frozen=True, slots=True)
class OldEnvironment:
    """Terms: folder. unasked [s]: since a run last asked for it. bytes: on the disk."""

    folder: Path
    unasked: float
    bytes: int


def old_environments(older: float) -> Iterator[OldEnvironment]:
    """Those that the lock, the numeric libraries and Python of this installation do not lead to, unasked for so long [s].

    Another installation of the same user may have others: what it asked for within that time is not among them.
    """
    for folder in sorted(path for path in root().glob("*") if path.is_dir()):
        unasked = time.time() - _asked(folder)
        if unasked >= older and folder not in map(folder_of, _names(folder)):
            size = sum(path.lstat().st_size for path in folder.rglob("*") if path.is_file())
            yield OldEnvironment(folder, unasked, size)


def remove(old: OldEnvironment) -> bool:
    """Take it away, unless a run is making or trying it: was it taken? Raises: OSError."""
    with _lock_of(old.folder).open("w") as lock:
        try:
            fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            return False
        shutil.rmtree(old.folder)
        _lock_of(old.folder).unlink()
    return True


def _lock_of(folder: Path) -> Path:
    return folder.with_name(f"{folder.name}.lock")


def _asked(folder: Path) -> float:
    """When a run last asked for it: whoever does opens its lock anew."""
    lock = _lock_of(folder)
    return (lock if lock.is_file() else folder).stat().st_mtime


def _names(folder: Path) -> Iterator[str]:
    """What the engine in a folder may be called: one of the hyphens stands for the blank, if it has a version."""
    words = folder.name.rpartition("-")[0].split("-")
    yield "-".join(words)
    yield from ("-".join(words[:k]) + " " + "-".join(words[k:]) for k in range(1, len(words)))
