"""Interruptions: after a kill or Ctrl-C the folder is valid, and resuming gives every cell exactly once."""

import os
import signal
import subprocess
import sys
import time
from collections.abc import Mapping
from pathlib import Path

import pandas as pd
import psutil
import pytest

from plumbline.harness.store.store import Store
from tests.conftest import Command
from tests.stress.ledger import Page

STUDY = """
name = "kill"
recordings = false
[[experiments]]
name = "kill"
cases = ["stress_fall"]
dt = [{steps}]
timing = {timing}
samples = 1
sample_seconds = 0.001
"""
STEPS = ", ".join(f"{0.5 / n:.17g}" for n in range(30, 60, 3))
ROOT = Path(__file__).parents[2]
CELLS = 20
"""Ten steps on two tracks."""


def write_study(folder: Path, timing: str = "false") -> Path:
    path = folder / "kill.toml"
    path.write_text(STUDY.format(steps=STEPS, timing=timing))
    return path


def start(study: Path, out: Path, environment: Mapping[str, str], *more: str, engine: str = "sound") -> subprocess.Popen[str]:
    """Carry a study out in a process of its own, as a person does, but for the report at the end."""
    command = [sys.executable, "-m", "tests.stress.unreported", "run", study, "--engine", engine, "--out", out, *more]
    return subprocess.Popen(
        list(map(str, command)),
        env=dict(environment),
        cwd=ROOT,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
    )


def answers(out: Path) -> dict[str, str]:
    trials = Store(out).trials
    assert trials["trial"].is_unique
    return dict(zip(trials["trial"], trials["trajectory_hash"], strict=True))


@pytest.fixture(scope="module")
def undisturbed(tmp_path_factory: pytest.TempPathFactory, with_plugins: Mapping[str, str]) -> dict[str, str]:
    folder = tmp_path_factory.mktemp("undisturbed")
    process = start(write_study(folder), folder / "out", with_plugins)
    _, errors = process.communicate(timeout=120)
    assert process.returncode == 0, errors
    found = answers(folder / "out")
    assert len(found) == CELLS
    return found


def kill_and_resume(folder: Path, instant: float, environment: Mapping[str, str]) -> dict[str, str]:
    study, out = write_study(folder), folder / "out"
    process = start(study, out, environment)
    time.sleep(instant)
    os.kill(process.pid, signal.SIGKILL)
    process.communicate()
    process = start(study, out, environment, "--resume")
    _, errors = process.communicate(timeout=120)
    assert process.returncode == 0, errors
    return answers(out)


@pytest.mark.slow
@pytest.mark.parametrize("instant", [0.4, 0.9, 1.3, 1.7])
def test_a_killed_run_that_is_resumed_has_every_cell_exactly_once(
    instant: float, tmp_path: Path, with_plugins: Mapping[str, str], undisturbed: dict[str, str], ledger: Page
) -> None:
    assert kill_and_resume(tmp_path, instant, with_plugins) == undisturbed
    ledger.survived("interruption", f"SIGKILL of the run after {instant:g} s", "cells lost 0, doubled 0")


def test_a_run_that_is_killed_takes_an_engine_along_that_hangs(
    tmp_path: Path, with_plugins: Mapping[str, str], ledger: Page
) -> None:
    out = tmp_path / "out"
    process = start(write_study(tmp_path), out, with_plugins, engine="hang")
    until = time.monotonic() + 60.0
    while not [*out.glob("logs/*.log")]:
        assert process.poll() is None
        assert time.monotonic() < until
        time.sleep(0.01)
    time.sleep(1.0)  # it has begun, and sleeps from its twentieth step on
    started = psutil.Process(process.pid).children(recursive=True)
    assert len(started) > 1
    process.kill()
    # As long as one of them lives, it holds the pipes that this reads.
    process.communicate(timeout=60)
    _, alive = psutil.wait_procs(started, timeout=10.0)
    assert alive == []
    ledger.survived("interruption", "SIGKILL of a run whose engine hangs", f"{len(started)} processes, all gone")


@pytest.mark.parametrize(
    ("by", "ignored"),
    [
        pytest.param(signal.SIGINT, False, marks=pytest.mark.slow),
        (signal.SIGINT, True),
        pytest.param(signal.SIGTERM, False, marks=pytest.mark.slow),
        pytest.param(signal.SIGTERM, True, marks=pytest.mark.slow),
    ],
)
def test_a_request_to_stop_leaves_a_valid_store_a_hint_and_no_child(
    tmp_path: Path, with_plugins: Mapping[str, str], ignored: bool, by: signal.Signals, ledger: Page
) -> None:
    study, out = write_study(tmp_path), tmp_path / "out"
    # What a shell without job control starts in the background ignores an interrupt, and so does every child of such a process.
    before = signal.signal(signal.SIGINT, signal.SIG_IGN) if ignored else None
    process = start(study, out, with_plugins)
    if before is not None:
        signal.signal(signal.SIGINT, before)
    deadline = time.monotonic() + 200.0
    journal = out / "journal.jsonl"
    # At the second answer the first is written through; one that is being written when the request comes is taken back.
    while time.monotonic() < deadline and not (journal.is_file() and journal.read_bytes().count(b'"kind": "accuracy"') > 1):
        time.sleep(0.02)
    children = psutil.Process(process.pid).children(recursive=True)
    process.send_signal(by)
    _, errors = process.communicate(timeout=30)
    assert process.returncode == 130, errors
    assert "--resume" in errors
    _, alive = psutil.wait_procs(children, timeout=10.0)
    assert alive == []
    assert (out / "trials.parquet").is_file()
    assert len(pd.read_parquet(out / "trials.parquet")) == len(Store(out).trials) >= 1
    where = "in the background" if ignored else "in front"
    ledger.survived("interruption", f"{by.name} {where}", f"orphans 0 of {len(children)}")


@pytest.mark.slow
def test_resuming_a_finished_run_does_nothing(tmp_path: Path, with_plugins: Mapping[str, str]) -> None:
    study, out = write_study(tmp_path, timing="true"), tmp_path / "out"
    process = start(study, out, with_plugins)
    _, errors = process.communicate(timeout=120)
    assert process.returncode == 0, errors
    before = (out / "journal.jsonl").read_bytes()
    process = start(study, out, with_plugins, "--resume")
    _, errors = process.communicate(timeout=120)
    assert process.returncode == 0, errors
    assert (out / "journal.jsonl").read_bytes() == before


@pytest.mark.slow
def test_a_second_run_in_the_same_folder_is_refused(tmp_path: Path, plumbline: Command) -> None:
    study = write_study(tmp_path)
    assert plumbline("run", study, "--engine", "sound", "--out", tmp_path / "out", plugins=True).returncode == 0
    again = plumbline("run", study, "--engine", "sound", "--out", tmp_path / "out", plugins=True)
    assert again.returncode == 2
    assert "--resume" in again.stderr
