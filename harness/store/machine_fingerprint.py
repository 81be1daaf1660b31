"""The machine's fingerprint: what a number has to be read with."""

import hashlib
import json
import os
import platform
import subprocess
import sys
from collections.abc import Mapping
from datetime import UTC, datetime
from functools import cache
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

import psutil

_PACKAGES = ("plumbline", "numpy", "scipy", "numba", "pandas", "pyarrow", "rerun-sdk", "vl-convert-python")


def _processor() -> str:
    path = Path("/proc/cpuinfo")
    if path.is_file():
        for line in path.read_text(encoding="utf-8", errors="replace").splitlines():
            if line.startswith("model name"):
                return line.partition(":")[2].strip()
    return platform.processor() or platform.machine()


@cache
def _version(package: str) -> str:
    try:
        return version(package)
    except PackageNotFoundError:
        return "none"


@cache
def _commit() -> str:
    """Of the working copy that this is run from, with '+' where files differ from it; '' where it is none.

    Once in a process, which runs what it has loaded, whatever becomes of the files.
    """
    root = Path(__file__).resolve().parents[2]
    if not (root / ".git").exists():
        return ""

    def git(*words: str) -> str:
        command = ["git", "-C", str(root), *words]
        return subprocess.run(command, capture_output=True, text=True, timeout=10, check=True).stdout.strip()

    try:
        changed = git("status", "--porcelain", "--untracked-files=no")
        return git("rev-parse", "--short=12", "HEAD") + ("+" if changed else "")
    except (OSError, subprocess.SubprocessError):
        return ""


def circumstances(machine: Mapping[str, Any]) -> dict[str, Any]:
    """What of a fingerprint a timing depends on; nothing that changes from run to run."""
    kept = {name: machine.get(name) for name in ("processor", "cores", "system", "python", "memory_mb")}
    # Some of a machine's memory is the system's, a little more or less from start to start.
    return kept | {"memory_mb": None if kept["memory_mb"] is None else round(kept["memory_mb"], -3)}


def machine_digest(machine: Mapping[str, Any]) -> str:
    """Sixteen hexadecimal digits that name the machine of a fingerprint; '' for none."""
    if not machine:
        return ""
    return hashlib.sha256(json.dumps(circumstances(machine), sort_keys=True).encode()).hexdigest()[:16]


def fingerprint() -> dict[str, Any]:
    """Processor, cores, memory [MB], system, versions, commit, load and the command that was given; JSON-ready."""
    return {
        "processor": _processor(),
        "cores": len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count(),
        "memory_mb": psutil.virtual_memory().total // 2**20,
        "system": platform.platform(),
        "python": platform.python_version(),
        "packages": {package: _version(package) for package in _PACKAGES},
        "commit": _commit(),
        "load": list(os.getloadavg()),
        "started": datetime.now(UTC).isoformat(timespec="seconds"),
        "command": ["plumbline", *sys.argv[1:]],
    }
