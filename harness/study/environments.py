"""Environments of engine versions: where each lies, what was found in it, and which interpreter an engine's processes run on.

An environment lies in the user's cache folder, by a digest of the engine's version or wheel, of the lock file, the numeric
libraries and Python's version, so that a name finds it again in any process; `harness.run.make_environment` makes it.
"""

import dataclasses
import hashlib
import json
import os
import sys
import sysconfig
from dataclasses import dataclass
from functools import cache
from importlib.metadata import PackageNotFoundError, distribution, version
from pathlib import Path

import platformdirs

from plumbline.harness.store import disk
from plumbline.harness.study.engine_versions import engine_of, version_asked
from plumbline.harness.study.sources import libraries

_FILE = "environment.json"


@dataclass(frozen=True, slots=True)
class Environment:
    """What was found in an environment.

    Terms: executable: its interpreter; '' where none could be made. path: where that looks for modules, but for plumbline's.
    version: that the engine's adapter reads there. reason: why the engine is unavailable; '' where it is not.
    sources: the digest of the adapter's texts that this was found with. distribution: the package that was asked for.
    """

    executable: str = ""
    path: tuple[str, ...] = ()
    version: str = ""
    reason: str = ""
    sources: str = ""
    distribution: str = ""


def root() -> Path:
    """The folder of all environments."""
    return Path(os.environ.get("PLUMBLINE_ENVIRONMENTS") or Path(platformdirs.user_cache_dir("plumbline")) / "environments")


def installed_folders() -> tuple[str, ...]:
    """Where this interpreter's packages are installed."""
    return tuple(dict.fromkeys(sysconfig.get_path(kind) for kind in ("purelib", "platlib")))


def project_folders() -> tuple[str, ...]:
    """Where plumbline itself lies, unless it is installed among the others."""
    root = str(Path(__file__).parents[3])
    return () if root in installed_folders() else (root,)


@cache
def _beneath() -> str:
    """A digest of what an environment is laid over: the lock file, the numeric libraries, Python, and where it all lies."""
    lock = Path(__file__).resolve().parents[2] / "requirements.lock"
    pinned = hashlib.sha256(lock.read_bytes()).hexdigest() if lock.is_file() else version("plumbline")
    said = [pinned, libraries(), sys.version, *installed_folders()]
    return hashlib.sha256("\n".join(said).encode()).hexdigest()


def installed(distribution_name: str) -> bool:
    """Is this package installed beside plumbline?"""
    try:
        distribution(distribution_name)
    except (PackageNotFoundError, ValueError):
        return False
    return True


def lock_of(name: str) -> Path | None:
    """The lock file of an engine that plumbline does not bring along; None of others, and of a version by number."""
    lock = Path(__file__).resolve().parents[2] / "adapters" / engine_of(name) / "requirements.lock"
    return lock if not version_asked(name) and lock.is_file() else None


def folder_of(name: str) -> Path:
    """The folder of an engine of this name, whether it is there or not."""
    lock = lock_of(name)
    pinned = "" if lock is None else hashlib.sha256(lock.read_bytes()).hexdigest()
    digest = hashlib.sha256(f"{name}\n{_beneath()}{pinned}".encode()).hexdigest()[:16]
    return root() / f"{name.replace(' ', '-')}-{digest}"


def inside() -> bool:
    """Does this process run on the interpreter of such an environment? Then its engine is the one that is imported."""
    return Path(sys.prefix).parent == root()


def keep(name: str, environment: Environment) -> None:
    """Write down what was found. Raises: OSError."""
    folder = folder_of(name)
    folder.mkdir(parents=True, exist_ok=True)
    disk.write_atomically(folder / _FILE, json.dumps(dataclasses.asdict(environment), indent=1).encode())


def environment_of(name: str) -> Environment | None:
    """What was found in the environment of an engine of this name; None where none was tried, or what is written is torn."""
    path = folder_of(name) / _FILE
    try:
        return _read(path, path.stat().st_mtime_ns)
    except (OSError, ValueError, TypeError):
        return None


@cache
def _read(path: Path, changed: int) -> Environment:  # noqa: ARG001  # another time, another content
    fields = json.loads(path.read_text(encoding="utf-8"))
    return Environment(**{**fields, "path": tuple(fields["path"])})


def home_of(engine: str) -> Environment | None:
    """What was found in the environment that an engine lives in; None where it lives beside plumbline, or nowhere."""
    environment = None if inside() else environment_of(engine)
    beside = environment is not None and not version_asked(engine) and installed(environment.distribution)
    return None if beside else environment


def elsewhere(engine: str) -> Environment | None:
    """The environment that an engine's processes run in; None for this one's. Raises: LookupError, where it is not there."""
    environment = home_of(engine)
    there = environment is not None and bool(environment.executable)
    if not there and version_asked(engine) and not inside():
        raise LookupError(f"{engine} has no environment here")
    return environment if there else None
