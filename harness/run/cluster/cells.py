"""What a worker of a cluster does: one accuracy run in a process of its own, or one group of trials under the clock.

What comes of it is handed back by value, files and all, so that worker and coordinator share no folder. Each thread of a worker
answers a cell, all off one set of fork servers; what is clocked is clocked alone.
"""

import random
import shutil
import tempfile
import threading
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path
from typing import Any

from plumbline.harness.intake.error import PlumblineError
from plumbline.harness.run.fork_servers import expect
from plumbline.harness.run.isolated import run_isolated
from plumbline.harness.run.timing_protocol import clock_group
from plumbline.harness.store.machine_fingerprint import fingerprint, machine_digest
from plumbline.harness.store.record import plain
from plumbline.harness.study import plugins
from plumbline.harness.study.provenance import sources_of
from plumbline.harness.study.trial import Trial

KEPT = ("trajectories", "truths", "logs")
"""Folders of a run folder that a worker's own may have something for."""


class OtherPlumbline(PlumblineError):
    """A worker that would answer by other sources or another engine than the coordinator asks about; the text says which."""


@dataclass(frozen=True, slots=True)
class Answered:
    """A finished cell. Terms: record: in plain values. files: those that it left, by their place in a run folder."""

    record: Mapping[str, Any]
    files: Mapping[str, bytes]


_asked_first = threading.Lock()
"""Held while a cell is looked at, so that threads do not all make what is made once."""
_clock = threading.Lock()
_sent: set[tuple[str, str]] = set()
"""Truths that each run has from here."""


@cache
def _scratch() -> Path:
    """Where the worker's cells have their folders."""
    return Path(tempfile.mkdtemp(prefix="plumbline-worker-"))


@cache
def _truths() -> Path:
    """Truths that the worker has made stay here for the next cells."""
    (folder := _scratch() / "truths").mkdir()
    return folder


@cache
def here() -> dict[str, Any]:
    """The fingerprint of this worker's machine."""
    return fingerprint()


@cache
def _version(engine: str) -> str:
    version, reason = plugins.version_of(plugins.adapter(engine))
    return version if reason is None else f"none ({reason})"


def _agree(trial: Trial) -> None:
    """Is this worker's plumbline the one that the trial is named after? Raises: OtherPlumbline."""
    ours = sources_of(trial.case, trial.engine)
    parts = [name for name in ours if trial.sources and ours[name] != trial.sources.get(name)]
    if parts:
        raise OtherPlumbline(f"a worker on {_host()} has other sources ({', '.join(parts)}); give it the same plumbline")
    if (version := _version(trial.engine)) != trial.engine_version:
        raise OtherPlumbline(f"a worker on {_host()} has {trial.engine} {version}, the coordinator {trial.engine_version}")


def _host() -> str:
    import socket

    return socket.gethostname()


def answer_cell(trial: Trial, foreseen: int = 0, modules: Sequence[str] = (), run: str = "") -> Answered:
    """The accuracy run of a trial.

    Args: foreseen: trials of this engine that a worker of the run will have. modules: that all processes of the run need. run:
    which it is, of those that a worker lives through.
    Raises: OtherPlumbline.
    """
    with _asked_first:
        _agree(trial)
        expect(modules)
        machine = machine_digest(here())
        folder = Path(tempfile.mkdtemp(prefix="cell-", dir=_scratch()))
        (folder / "truths").symlink_to(_truths())
    try:
        (record,) = run_isolated([trial], folder, 1, foreseen)
        return Answered(plain(replace(record, answered_on=machine)), _taken(folder, run))
    finally:
        shutil.rmtree(folder)


def clock_together(trials: tuple[Trial, ...], seed: int, modules: Sequence[str] = ()) -> list[dict[str, Any]]:
    """The timing runs of one group of trials, side by side on this machine, in plain values, each with the machine.

    Args: modules: as above. Raises: OtherPlumbline.
    """
    with _clock:
        for trial in trials:
            _agree(trial)
        expect(modules)
        timings = [replace(t, clocked_on=machine_digest(here())) for t in clock_group(trials, _scratch(), random.Random(seed))]
        return [*map(plain, timings)]


def _taken(folder: Path, run: str) -> dict[str, bytes]:
    """The files of a cell's folder by their place; of truths, which stay here, those that are new to the run."""
    paths = [path for name in KEPT for path in sorted((folder / name).glob("[!.]*"))]
    files = {name: path.read_bytes() for path in paths if (run, name := path.relative_to(folder).as_posix()) not in _sent}
    _sent.update((run, name) for name in files if name.startswith("truths/"))
    return files
