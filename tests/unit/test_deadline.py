"""A deadline counts what a process did: a crowded machine makes nobody late, idleness and endless work do."""

import os
import subprocess
import sys
import time
from collections.abc import Callable, Iterator

import pytest

from plumbline.harness.intake import deadline
from plumbline.harness.intake.deadline import Deadline

WORKS = "while True: pass"
SLEEPS = "import time; time.sleep(60)"

Start = Callable[..., int]


@pytest.fixture(autouse=True)
def patient(monkeypatch: pytest.MonkeyPatch) -> None:
    """However crowded this machine is, a fifth of a second of CPU time comes before a thousand times that on the wall."""
    monkeypatch.setattr(deadline, "CROWDED", 1000.0)


@pytest.fixture
def start() -> Iterator[Start]:
    """Starts a script in a process, on one core if asked; all are ended with the test."""
    started: list[subprocess.Popen[bytes]] = []

    def begin(script: str, core: int | None = None) -> int:
        started.append(subprocess.Popen([sys.executable, "-c", script]))
        if core is not None:
            os.sched_setaffinity(started[-1].pid, {core})
        return started[-1].pid

    yield begin
    for process in started:
        process.kill()
        process.wait()


def verdict(watched: Deadline) -> str:
    """What it says once it says something."""
    while not (why := watched.passed()):
        time.sleep(max(0.0, watched.until - time.monotonic()) + 1e-3)
    return why


def test_a_process_that_works_without_end_has_its_cpu_time_and_no_more(start: Start) -> None:
    assert verdict(Deadline(start(WORKS), 0.2)) == "all of it CPU time"


def test_a_process_that_waits_for_nothing_is_late_though_it_took_no_cpu_time(start: Start) -> None:
    pid = start(SLEEPS)
    time.sleep(0.5)  # the interpreter has started
    assert verdict(Deadline(pid, 0.3)) == "and it did nothing"


@pytest.mark.skipif(not hasattr(os, "sched_setaffinity"), reason="no core can be chosen")
def test_a_process_that_shares_its_core_has_its_time_all_the_same(start: Start) -> None:
    core = min(os.sched_getaffinity(0))
    for _ in range(3):
        start(WORKS, core)
    watched = Deadline(start(WORKS, core), 0.2)
    time.sleep(0.2)
    # A quarter of a core: of the time on the wall it has had a quarter, or somewhat more if it came first.
    assert watched.passed() == ""
    assert verdict(watched) == "all of it CPU time"


def test_a_process_that_hardly_gets_anything_is_given_up_in_the_end(start: Start, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(deadline, "CROWDED", 1.0)
    monkeypatch.setattr(deadline, "IDLE", 0.0)
    assert verdict(Deadline(start(SLEEPS), 0.3)).startswith("1 times over")
