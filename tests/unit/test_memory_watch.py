"""The watch over memory: it kills what takes too much and says how much, leaves others alone, and reads the system's counts."""

import signal
import subprocess
import sys
from pathlib import Path

import pytest

from plumbline.harness.adapter import Settings
from plumbline.harness.run import interrupt, isolated
from plumbline.harness.run.interrupt import MemoryWatch, kills_for_memory
from plumbline.harness.study.experiment import Experiment
from plumbline.harness.study.trial import Trial

TRIAL = Trial(
    trial="t",
    study="s",
    experiment=Experiment(name="e", deadline=5.0),
    case="c",
    parameters={},
    engine="x",
    engine_version="1",
    track="tuned",
    settings=Settings(dt=0.01),
    seed=0,
)
WAITS = "import sys; sys.stdin.readline(); "


def watched(script: str, most: float) -> tuple[float, int]:
    """What a watch says of a process that begins once it is watched, and how that ended."""
    child = subprocess.Popen([sys.executable, "-c", WAITS + script], stdin=subprocess.PIPE)
    watch = MemoryWatch(child.pid, most)
    child.communicate(b"\n", timeout=60)
    watch.stop()
    return watch.taken, child.returncode


def test_what_takes_too_much_is_killed_and_the_watch_says_how_much() -> None:
    taken, code = watched("import mmap, time; m = mmap.mmap(-1, 2**28); time.sleep(60)", 200.0)
    assert 256.0 <= taken < 300.0
    assert code == -signal.SIGKILL


def test_what_takes_less_is_left_alone() -> None:
    assert watched("import mmap, time; m = mmap.mmap(-1, 2**27); time.sleep(0.3)", 200.0) == (0.0, 0)


def test_a_process_that_is_gone_needs_no_watch() -> None:
    child = subprocess.Popen([sys.executable, "-c", ""])
    child.wait()
    assert MemoryWatch(child.pid, 1.0).taken == 0.0


def test_the_systems_counts_are_added_and_one_that_is_not_there_is_none(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "vmstat").write_text("pgfault 17\noom_kill 3\nswap_ra 0\n")
    (tmp_path / "events").write_text("low 0\nmax 9\noom 2\noom_kill 1\noom_group_kill 0\n")
    monkeypatch.setattr(interrupt, "_COUNTS", [str(tmp_path / name) for name in ("vmstat", "events", "nowhere")])
    assert kills_for_memory() == 4


@pytest.mark.parametrize(
    ("code", "kills", "status", "reason"),
    [
        (-signal.SIGKILL, 1, "oom", "killed by the system, which killed 1 times for want of memory"),
        (-signal.SIGKILL, 0, "crashed", "killed by SIGKILL"),
        (-signal.SIGSEGV, 1, "crashed", "killed by SIGSEGV"),
        (-signal.SIGALRM, 0, "crashed", "killed by SIGALRM"),
        (1, 1, "crashed", "exit code 1"),
    ],
)
def test_an_end_is_told_by_what_happened_and_not_by_the_log(
    code: int, kills: int, status: str, reason: str, tmp_path: Path
) -> None:
    log = tmp_path / "log"
    log.write_text("MemoryError: std::bad_alloc\n")
    record = isolated._expired(TRIAL, code, log, kills)
    assert record.status == status
    assert reason in record.reason
