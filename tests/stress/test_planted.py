"""Faults planted in one engine, each in a cell of its own: every one has the outcome that it should, and costs nobody else."""

import multiprocessing
import subprocess
import sys
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import pandas as pd
import psutil
import pytest
import tomli_w

from plumbline.harness.run.isolated import tell
from plumbline.harness.run.message import BrokenMessage, Inbox, read_record
from plumbline.harness.store.store import Store
from plumbline.harness.study.study import load_study
from plumbline.harness.trial.accuracy import run_trial
from tests.conftest import PLUGINS
from tests.stress.ledger import Page

sys.path.insert(0, str(PLUGINS))
from planted import CASE, PLANTED  # the plug-in's own table
from planted_deeds import SLEEP, Fault
from planted_faults import FAULTS

sys.path.remove(str(PLUGINS))

ROOT = Path(__file__).parents[2]
IN_PROCESSES = ("signals", "exits", "surroundings", "processes", "hangs", "memory")
HEAVY = tuple(fault for fault in FAULTS if fault.family in IN_PROCESSES)
LIGHT = tuple(fault for fault in FAULTS if fault.family not in IN_PROCESSES)
ROUGH = {"hangs": {"deadline": 2.0}, "memory": {"memory": 400.0}}
"""What the experiments of some families are given less of."""


def experiment(family: str) -> dict[str, Any]:
    given = {"name": family, "cases": ["stress_channels"], "tracks": ["tuned"], "timing": False}
    return given | {"variants": [f"planted/{family}_*"]} | ROUGH.get(family, {})


def study(faults: tuple[Fault, ...]) -> str:
    variants = {fault.variant: {"options": {"fault": fault.variant}} for fault in faults}
    families = dict.fromkeys(fault.family for fault in faults)
    alone = {"name": "sound", "cases": ["stress_channels"], "tracks": ["tuned"], "timing": False}
    experiments = [experiment(family) for family in families] or [alone]
    return tomli_w.dumps(
        {"name": "planted", "recordings": False, "variants": {"planted": variants}, "experiments": experiments}
    )


def carried_out(folder: Path, environment: Mapping[str, str], *faults: Fault) -> pd.DataFrame:
    (folder / "planted.toml").write_text(study(faults))
    chosen = ("--engine", "planted", "--workers", "6", "--out", folder / "out")  # most of them sleep
    command = [sys.executable, "-m", "tests.stress.unreported", "run", folder / "planted.toml", *chosen]
    done = subprocess.run(command, env=dict(environment), cwd=ROOT, capture_output=True, text=True, timeout=280, check=False)
    assert done.returncode == 0, done.stderr
    return Store(folder / "out").trials


@pytest.fixture(scope="module")
def trials(tmp_path_factory: pytest.TempPathFactory, with_plugins: Mapping[str, str]) -> pd.DataFrame:
    """What became of the faults that need a process of their own."""
    return carried_out(tmp_path_factory.mktemp("planted"), with_plugins, *HEAVY)


@pytest.fixture
def sound(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> str | None:
    """The hash of the sound engine's answer, alone and in this process."""
    monkeypatch.syspath_prepend(str(PLUGINS))
    (tmp_path / "planted.toml").write_text(study(()))
    (trial,) = load_study(str(tmp_path / "planted.toml")).trials({CASE.name: CASE}, {"planted": PLANTED}, {"planted": "1.0"})
    record = run_trial(trial, CASE, PLANTED, tmp_path)
    assert record.status == "passed"
    return record.trajectory_hash


def judged(fault: Fault, status: str, reason: str, ledger: Page) -> None:
    assert (status, reason) == (fault.status, reason)
    assert fault.reason in reason
    assert reason.isprintable()
    ledger.survived(f"engine: {fault.family}", fault.name.replace("_", " "), f"{fault.status}, other cells lost 0")


@pytest.mark.parametrize("fault", HEAVY, ids=lambda fault: fault.variant)
def test_a_fault_of_a_process_has_its_outcome_and_its_reason(trials: pd.DataFrame, fault: Fault, ledger: Page) -> None:
    (row,) = trials[trials["track"] == fault.variant].to_dict("records")
    judged(fault, row["status"], row["reason"], ledger)


@pytest.mark.parametrize("fault", LIGHT, ids=lambda fault: fault.variant)
def test_a_fault_of_an_answer_has_its_outcome_and_its_reason(
    fault: Fault, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, ledger: Page
) -> None:
    """Told through the pipe that a child has, in this process."""
    monkeypatch.syspath_prepend(str(PLUGINS))
    (tmp_path / "planted.toml").write_text(study((fault,)))
    found = load_study(str(tmp_path / "planted.toml")).trials({CASE.name: CASE}, {"planted": PLANTED}, {"planted": "1.0"})
    trial = next(trial for trial in found if trial.track == fault.variant)
    ours, theirs = multiprocessing.Pipe(duplex=False)
    tell(theirs, trial, tmp_path)
    theirs.close()
    (ready, _), *_, (kind, said) = Inbox(ours).lines()
    ours.close()
    assert (ready, kind) == ("ready", "record")
    try:
        record = read_record(trial, said)
        judged(fault, record.status, record.reason, ledger)
    except BrokenMessage as error:
        judged(fault, "crashed", f"broken contract: {error}", ledger)


@pytest.mark.slow
@pytest.mark.timeout(1800)
def test_a_fault_of_an_answer_has_the_same_outcome_in_a_process_of_its_own(
    tmp_path: Path, with_plugins: Mapping[str, str]
) -> None:
    found = carried_out(tmp_path, with_plugins, *LIGHT).set_index("track")
    assert {fault.variant: found.loc[fault.variant, "status"] for fault in LIGHT} == {f.variant: f.status for f in LIGHT}


def test_the_sound_cells_beside_them_answer_as_alone(trials: pd.DataFrame, sound: str | None) -> None:
    beside = trials[trials["track"] == "tuned"]
    assert len(beside) == len({fault.family for fault in HEAVY})
    assert set(beside["status"]) == {"passed"}
    assert set(beside["trajectory_hash"]) == {sound}


def test_every_cell_has_exactly_one_row(trials: pd.DataFrame) -> None:
    assert trials["trial"].is_unique
    assert len(trials) == len(HEAVY) + len({fault.family for fault in HEAVY})


def test_no_process_that_an_engine_started_is_left(trials: pd.DataFrame) -> None:
    """In the folder of these tests: others may run the same ones on this machine."""
    assert len(trials)
    found = [process.info for process in psutil.process_iter(["pid", "cmdline", "cwd"])]
    assert not [one for one in found if SLEEP in (one["cmdline"] or ()) and one["cwd"] == str(ROOT)]
