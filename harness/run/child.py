"""Child processes: how they are confined, how what they started ends, and what one does with a trial."""

import ctypes
import os
import resource
import signal
import sys
import time
import traceback
from collections.abc import Callable, Iterator
from contextlib import suppress
from dataclasses import replace
from importlib import import_module
from pathlib import Path

from plumbline.harness.adapter import Adapter, SettingsError, Unavailable, Unsupported
from plumbline.harness.case import Case
from plumbline.harness.intake.bounded import limit_files
from plumbline.harness.run.interrupt import be_killed_first
from plumbline.harness.store.journal import StoreError
from plumbline.harness.store.record import Record, Status, StoredNotice
from plumbline.harness.study import plugins
from plumbline.harness.study.trial import Trial
from plumbline.harness.trial.accuracy import judged_anew, outcome, run_trial
from plumbline.harness.trial.bench import Bench, rough_cost_beside
from plumbline.harness.trial.beside_tuned import SHORT, idle_turns, is_surveyed, ratio_to_tuned
from plumbline.harness.trial.ensemble import endure

_PR_SET_CHILD_SUBREAPER = 36
"""From linux/prctl.h: what loses its parent becomes the child of this process."""
_GENERATIONS = 10
"""How deep the processes of processes are followed."""


def confine(log: Path) -> None:
    """Send the output of this process to `log`, and limit what it may write.

    An interrupt is the parent's affair. What is started in it is of its group, which ends with it. Its memory is watched from
    outside.
    """
    os.setpgid(0, 0)
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    if sys.platform == "linux":
        ctypes.CDLL(None).prctl(_PR_SET_CHILD_SUBREAPER, 1)
    be_killed_first()
    stream = os.open(log, os.O_WRONLY | os.O_CREAT | os.O_APPEND, 0o644)
    os.dup2(stream, 1)
    os.dup2(stream, 2)
    os.close(stream)
    limit_files()


def end_started() -> None:
    """End what was started in this process, into whatever session it went: what lost its parent is this one's child."""
    for _ in range(_GENERATIONS):
        children = {int(pid) for file in Path("/proc/self/task").glob("*/children") for pid in file.read_text().split()}
        if not children:
            return
        for pid in children:
            with suppress(OSError):
                os.kill(pid, signal.SIGKILL)
                os.waitpid(pid, 0)


def _load(trial: Trial, case: Case, adapter: Adapter) -> None:
    """Load an engine, and let it compile itself. What is wrong with it, the scene or the settings is for `build` to say."""
    _import(adapter)
    if adapter.compile_allowance > 0:
        with suppress(Unsupported, Unavailable, SettingsError):
            adapter.compile(trial.scene(case), trial.settings)


def _import(adapter: Adapter) -> None:
    for module in adapter.loads:
        with suppress(Exception):
            import_module(module)


def answers(
    trial: Trial, folder: Path, answered: Callable[[Record], object] | None = None, earlier: Record | None = None
) -> Iterator[Record | None]:
    """The accuracy run of a trial, whatever its Python code raises; the process may still die under it.

    Args: answered: is told what is known before the answer is judged, of a trial that is no ensemble. earlier: what came of
    a trial of the same motion, whose answer is judged and not simulated again, where its file is as it was written.

    None comes first, once the engine is ready for it. What a sweep goes on from comes once more, with its rough cost: if the
    clock fails, the answer is safe. Of a run of a ladder the rough cost is what the run itself took, all told; where knobs are
    turned to see whether one is better, what its steps took. Where a search will turn knobs, those that are idle come last.
    """
    allowed = _limits()
    try:
        case, adapter = plugins.case(trial.case), plugins.adapter(trial.engine)
        anew = None if earlier is None else _judged_anew(trial, case, adapter, earlier, folder, answered)
        if anew is not None:
            yield anew
            return
        _load(trial, case, adapter)
        yield None
        begun = time.process_time()
        if trial.members > 1:
            record = endure(trial, case, adapter, folder)
        else:
            record = run_trial(trial, case, adapter, folder, answered)
        if trial.experiment.refine is not None and record.measurements and record.sim_seconds:
            record = replace(record, rough_cost=(time.process_time() - begun) / record.sim_seconds)
    except StoreError as error:  # the machine's, unless the engine took from its process what writing needs
        changed = [name for name, limit in _limits().items() if limit != allowed[name]]
        reason = f"no answer could be written after the engine changed {', '.join(changed)}: {error.__cause__ or error}"
        record = outcome(trial, "crashed", reason) if changed else outcome(trial, "interrupted", str(error))
    except Exception as error:
        status: Status = "oom" if isinstance(error, MemoryError) else "crashed"
        record = outcome(trial, status, _in_words(error), traceback.format_exc()[-4000:])
    yield record
    if roughly_clocked(trial, record):
        record = _with_rough_cost(record, trial, case, adapter)
        yield record
    elif _beside_tuned(trial, record, case):
        record = _with_ratio(record, trial, case, adapter)
        yield record
    if is_surveyed(trial, record):
        yield replace(record, idle=idle_turns(trial, case, adapter))


def _judged_anew(
    trial: Trial, case: Case, adapter: Adapter, earlier: Record, folder: Path, answered: Callable[[Record], object] | None
) -> Record | None:
    """As `judged_anew`, with the modules of the engine loaded: they may set the mode of floating-point arithmetic."""
    _import(adapter)
    record = judged_anew(trial, case, earlier, folder, answered)
    return None if record is None else replace(record, simulated_as=earlier.simulated_as or earlier.trial)


def _limits() -> dict[str, tuple[int, int]]:
    """What this process may use of each resource, by the names of the operating system: the soft limit and the hard one."""
    names = [name for name in dir(resource) if name.startswith("RLIMIT_")]
    return {name: resource.getrlimit(getattr(resource, name)) for name in names}


def _in_words(error: Exception) -> str:
    """An engine's exception, which may not even have words."""
    try:
        return f"{type(error).__name__}: {error}"[:2000]
    except Exception as another:
        return f"{type(error).__name__}, whose words raise {type(another).__name__}"


def roughly_clocked(trial: Trial, record: Record) -> bool:
    """Is a rough cost wanted of what came of a trial?"""
    return bool(trial.experiment.sweep) and trial.members == 1 and bool(record.measurements)


def _beside_tuned(trial: Trial, record: Record, case: Case) -> bool:
    """Are runs so short, or no runs at all, that what they cost beside 'tuned' has to be clocked in turns?"""
    if not trial.experiment.dominance or trial.track == "tuned" or not record.measurements:
        return False
    return case.rays is not None or (record.rough_cost or 0.0) * record.sim_seconds <= SHORT


def _with_ratio(record: Record, trial: Trial, case: Case, adapter: Adapter) -> Record:
    try:
        return replace(record, rough_ratio=ratio_to_tuned(trial, case, adapter))
    except Exception as error:
        return replace(
            record, warnings=(*record.warnings, StoredNotice(f"cost beside tuned: none: {_in_words(error)}", by="rough clock"))
        )


def _with_rough_cost(record: Record, trial: Trial, case: Case, adapter: Adapter) -> Record:
    """The record with its rough cost, and with that over the cost of the first track that runs at the case's own step."""
    failures: list[str] = []
    for track, settings in adapter.tracks.items():
        yardstick = trial.probing(case, track=track, settings=settings.with_dt(case.dt))
        own, beside = (Bench(case, adapter, side, settled=False) for side in (trial, yardstick))
        try:
            cost, ratio = rough_cost_beside(own, beside)
            return replace(record, rough_cost=cost, rough_ratio=ratio)
        except Exception as error:
            failures.append(f"{track}: {type(error).__name__}: {error}")
    return replace(
        record, warnings=(*record.warnings, StoredNotice(f"rough cost: none, beside {'; '.join(failures)}", by="rough clock"))
    )
