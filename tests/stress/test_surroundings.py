"""What is around a run: a full disk, a folder that is none, a run beside it, a clock that steps back, ten thousand cells."""

import os
import resource
import subprocess
import sys
from collections.abc import Mapping
from pathlib import Path

import psutil
import pytest

from plumbline.harness.store.store import Store
from tests.conftest import PLUGINS, Command
from tests.in_process import in_this_process
from tests.stress.ledger import Page
from tests.stress.test_interruption import CELLS, answers, start, write_study
from tests.stress.unreported import summarised


@pytest.mark.slow
@pytest.mark.parametrize("number", [2, 8])
def test_of_runs_that_start_in_one_folder_together_one_runs(
    number: int, tmp_path: Path, with_plugins: Mapping[str, str], ledger: Page
) -> None:
    """The others refuse, and what the one finds is whole."""
    study = write_study(tmp_path)
    started = [start(study, tmp_path / "out", with_plugins) for _ in range(number)]
    ended = [(process.communicate(timeout=250)[1], process.returncode) for process in started]
    assert sorted(code for _, code in ended)[0] == 0
    refused = [(said, code) for said, code in ended if code]
    assert len(refused) == number - 1
    for said, code in refused:
        assert code in (2, 3)
        assert "another run writes to this folder" in said or "holds a run already" in said
    assert len(answers(tmp_path / "out")) == CELLS
    ledger.survived("surroundings", f"{number} runs in one folder", f"cells lost 0, doubled 0 of {CELLS}")


@pytest.mark.slow
def test_a_lock_of_a_dead_holder_does_not_hold(tmp_path: Path, with_plugins: Mapping[str, str], ledger: Page) -> None:
    study, out = write_study(tmp_path), tmp_path / "out"
    out.mkdir()
    script = f"import fcntl, os; f = open({str(out / 'journal.jsonl')!r}, 'ab'); fcntl.flock(f, fcntl.LOCK_EX); os.abort()"
    subprocess.run([sys.executable, "-c", script], check=False, capture_output=True)
    process = start(study, out, with_plugins, "--resume")
    _, errors = process.communicate(timeout=250)
    assert process.returncode == 0, errors
    assert len(answers(out)) == CELLS
    ledger.survived("surroundings", "the lock of a dead run", "cells lost 0")


@pytest.mark.parametrize(
    "room", [pytest.param(300, marks=pytest.mark.slow), 3000, pytest.param(30_000, marks=pytest.mark.slow)]
)
def test_a_full_disk_ends_the_run_with_path_and_reason_and_what_was_there_stays(
    room: int, tmp_path: Path, with_plugins: Mapping[str, str], printed: Command, monkeypatch: pytest.MonkeyPatch, ledger: Page
) -> None:
    """No file may grow beyond so many bytes, which a full disk looks like to the one that writes. This process resumes it."""
    study, out = write_study(tmp_path), tmp_path / "out"
    command = [sys.executable, "-m", "plumbline", "run", str(study), "--engine", "sound", "--out", str(out)]
    done = subprocess.run(
        command,
        env=dict(with_plugins),
        capture_output=True,
        text=True,
        timeout=250,
        check=False,
        preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (room, resource.RLIM_INFINITY)),
    )
    assert done.returncode == 3, done.stderr
    assert str(out) in done.stderr or "File too large" in done.stderr
    assert "Traceback" not in done.stderr
    monkeypatch.syspath_prepend(str(PLUGINS))
    in_this_process(monkeypatch)
    monkeypatch.setattr("plumbline.harness.cli.run_study.present", summarised)
    again = printed("run", study, "--engine", "sound", "--out", out, "--resume")
    assert again.returncode == 0, again.stderr
    assert len(answers(out)) == CELLS
    ledger.survived("surroundings", f"no file beyond {room} bytes", "exit 3; cells lost 0 after --resume")


@pytest.mark.parametrize("what", ["a file", "below a file", "below what is no folder"])
def test_a_folder_that_is_none_is_refused_before_work(
    what: str, tmp_path: Path, printed: Command, monkeypatch: pytest.MonkeyPatch, ledger: Page
) -> None:
    monkeypatch.syspath_prepend(str(PLUGINS))
    (tmp_path / "file").write_text("mine")
    out = {
        "a file": tmp_path / "file",
        "below a file": tmp_path / "file" / "out",
        "below what is no folder": Path("/dev/null/out"),
    }
    done = printed("run", write_study(tmp_path), "--engine", "sound", "--out", out[what])
    assert done.returncode in (2, 3)
    assert "file" in done.stderr.lower() or "director" in done.stderr.lower()
    assert "Traceback" not in done.stderr
    assert (tmp_path / "file").read_text() == "mine"
    ledger.survived("surroundings", f"--out is {what}", f"exit {done.returncode}, nothing written")


@pytest.mark.slow
def test_a_clock_that_steps_back_makes_no_time_negative(tmp_path: Path, with_plugins: Mapping[str, str], ledger: Page) -> None:
    """The wall clock of every process loses an hour at each look."""
    (tmp_path / "sitecustomize.py").write_text(
        "import time\n_now = time.time\n_looks = [0]\n"
        "def back():\n    _looks[0] += 1\n    return _now() - 3600.0 * _looks[0]\ntime.time = back\n"
    )
    (tmp_path / "clock.toml").write_text(
        'name = "clock"\nrecordings = false\n[[experiments]]\nname = "clock"\ncases = ["stress_fall"]\nsamples = 3\n'
        "sample_seconds = 0.005\n"
    )
    path = os.pathsep.join((str(tmp_path), with_plugins["PYTHONPATH"]))
    process = start(tmp_path / "clock.toml", tmp_path / "out", {**with_plugins, "PYTHONPATH": path})
    _, errors = process.communicate(timeout=250)
    assert process.returncode == 0, errors
    store = Store(tmp_path / "out")
    assert set(store.trials["status"]) == {"passed"}
    assert len(store.samples) == 6
    assert (store.samples[["cpu", "wall", "canary"]] > 0).all(axis=None)
    assert (store.trials["cpu_per_sim_s"] > 0).all()
    ledger.survived("surroundings", "a wall clock that steps back", f"negative times 0 of {3 * len(store.samples)}")


SOAK = """
name = "soak"
recordings = false
[[experiments]]
name = "soak"
cases = ["stress_fall"]
dt = [{steps}]
timing = false
"""


@pytest.mark.slow
@pytest.mark.timeout(7200)
def test_ten_thousand_cells_leave_memory_files_and_processes_as_they_were(
    tmp_path: Path, with_plugins: Mapping[str, str], ledger: Page
) -> None:
    """Between the first thousand cells and the last: what is held for each cell is its name."""
    steps = ", ".join(f"{0.5 / n:.17g}" for n in range(30, 5030))
    (tmp_path / "soak.toml").write_text(SOAK.format(steps=steps))
    process = start(tmp_path / "soak.toml", tmp_path / "out", with_plugins)
    journal, seen = tmp_path / "out" / "journal.jsonl", []
    looked = psutil.Process(process.pid)
    while process.poll() is None:
        lines = journal.read_bytes().count(b"\n") if journal.is_file() else 0
        if lines >= 1000 * (len(seen) + 1):
            try:
                seen.append((looked.memory_info().rss / 2**20, looked.num_fds(), len(looked.children())))
            except psutil.Error:
                break
        try:
            process.communicate(timeout=1.0)
        except subprocess.TimeoutExpired:
            continue
    assert process.returncode == 0
    assert len(answers(tmp_path / "out")) == 10_000
    assert len(seen) >= 9
    grown = [last - first for first, last in zip(seen[0], seen[8], strict=True)]
    assert grown[0] < 80.0
    assert grown[1] <= 4
    assert grown[2] <= 0
    assert not list((tmp_path / "out").glob(".*"))
    ledger.survived("soak", "10000 cells", f"{grown[0]:.0f} MB, {grown[1]} open files, {grown[2]} processes more")
