"""What runs inside the clock of a timing run: every function that Python calls between the two readings, counted.

    python -m tests.conformance.clocked_loop

prints the table of docs/method.md.
"""

import sys
import time
import tracemalloc
from collections import Counter
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from types import FrameType
from typing import Any

from plumbline.harness.adapter import Adapter
from plumbline.harness.case import Case
from plumbline.harness.study import plugins
from plumbline.harness.study.experiment import Experiment
from plumbline.harness.study.trial import Trial
from plumbline.harness.trial import bench
from plumbline.harness.trial.bench import Bench

__all__ = ["Called", "clocked_calls", "growth", "made", "table"]

ROOT = Path(__file__).parents[2]
OURS = ROOT / "src" / "plumbline"
CLOCKING = frozenset(function.__code__ for function in (bench.clock_steps, bench.clock_calls))
"""The two functions that read the clock."""
STEPS = 100
SHOWN: tuple[tuple[str, str, dict[str, int]], ...] = (
    ("a step", "stack_tower", {}),
    ("a cast of 128 rays", "system_rays", {"thin": 256}),
    ("a step of 3 worlds", "stack_pile", {"n": 4, "worlds": 3}),
)
"""What is clocked, the case, and its parameters."""


@dataclass(frozen=True, slots=True)
class Called:
    """A function that Python called. Terms: by: the caller's file; file: its own, '' for a compiled one; name."""

    by: str
    file: str
    name: str


def _short(path: str) -> str:
    """A file's path, from the folder of our packages or the root of the repository where it lies there."""
    return next((str(Path(path).relative_to(folder)) for folder in (OURS, ROOT) if Path(path).is_relative_to(folder)), path)


def _compiled(function: Any) -> str:
    owner = getattr(function, "__self__", None)
    place = function.__module__ or (type(owner).__name__ if owner is not None else "")
    return f"{place}.{function.__name__}".lstrip(".")


def made(case: Case, adapter: Adapter, **parameters: object) -> Bench:
    """A bench of a case on an engine's tuned track, as a timing run has one."""
    trial = Trial(
        trial="t",
        study="s",
        experiment=Experiment(name="e"),
        case=case.name,
        parameters=dict(case.parameters) | parameters,
        engine=adapter.name,
        engine_version="",
        track="tuned",
        settings=adapter.tracks["tuned"].with_dt(case.dt),
        seed=0,
    )
    return Bench(case, adapter, trial)


def clocked_calls(one: Bench, count: int) -> Counter[Called]:
    """Calls between a reading of the CPU clock and the next, over `count` steps or casts of a warm bench."""
    found: Counter[Called] = Counter()
    running = False

    def watch(frame: FrameType, event: str, function: Any) -> None:
        nonlocal running
        if event == "c_call" and function is time.process_time and frame.f_code in CLOCKING:
            running = not running
        elif running and event == "call":
            caller = frame.f_back
            by = "" if caller is None else _short(caller.f_code.co_filename)
            found[Called(by, _short(frame.f_code.co_filename), frame.f_code.co_qualname)] += 1
        elif running and event == "c_call":
            found[Called(_short(frame.f_code.co_filename), "", _compiled(function))] += 1

    before = sys.getprofile()
    sys.setprofile(watch)
    try:
        one.clock(count)
    finally:
        sys.setprofile(before)
    return found


def growth(run: Callable[[], object]) -> int:
    """Bytes that files of the harness and of the adapters hold more after a run than before it."""
    tracemalloc.start()
    try:
        before = tracemalloc.take_snapshot()
        run()
        after = tracemalloc.take_snapshot()
    finally:
        tracemalloc.stop()
    ours = (str(OURS / "harness"), str(OURS / "adapters"))
    changes = after.compare_to(before, "filename")
    return sum(change.size_diff for change in changes if change.traceback[0].filename.startswith(ours))


def _listed(calls: Counter[str]) -> str:
    return ", ".join(f"{times} `{name}`" for name, times in calls.items()) or "none"


def table(count: int = STEPS) -> Iterator[str]:
    """The lines of the table: a row for each kind of work and each engine that is installed."""
    yield f"| {count} times | engine | functions in Python of ours | functions of the vendor | of Python and NumPy |"
    yield "|---|---|---|---|---|"
    for what, name, parameters in SHOWN:
        case = plugins.case(name)
        for adapter in plugins.adapters().values():
            if plugins.version_of(adapter)[1] is not None:
                continue
            one = made(case, adapter, **parameters)
            one.clock(count)
            ours, vendors, others = Counter[str](), Counter[str](), 0
            for called, times in clocked_calls(one, count).items():
                if called.file.startswith(("harness/", "adapters/", "engine/")):
                    ours[called.name.replace(".<locals>", "")] += times
                elif called.name.startswith(f"{adapter.distribution}."):
                    vendors[called.name.rpartition(".")[2]] += times
                else:
                    others += times
            one.stop()
            yield f"| {what} | {adapter.name} | {_listed(ours)} | {_listed(vendors)} | {others} |"


if __name__ == "__main__":
    for line in table():
        print(line, flush=True)
