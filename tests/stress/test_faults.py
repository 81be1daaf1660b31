"""Faults of engines: each costs its own cells and nothing else, and each is an outcome with a reason."""

import json
import subprocess
import sys
from collections.abc import Iterator, Mapping
from pathlib import Path

import pandas as pd
import psutil
import pytest

from plumbline.harness.store.store import Store
from tests.conftest import Command
from tests.stress.ledger import Page

pytestmark = pytest.mark.slow  # `test_planted.py` has a fault of each of these families in `make test`

STUDY = """
name = "faults"
recordings = false
[[experiments]]
name = "faults"
cases = ["stress_fall"]
timing = false
deadline = 4.0
memory = 1000.0
"""
ENGINES = (
    "sound",
    "segfault",
    "abort",
    "vanish",
    "hang",
    "hoard",
    "raise",
    "flood",
    "nan",
    "compile",
    "loading_slowly",
    "compile_hang",
    "absent",
    "surrogate",
    "real_time",
    "orphan",
    "norm_3",
    "norm_0",
    "count",
    "warning",
    "garbage",
    "pickle",
    "pickle_line",
    "long_line",
    "half_a_line",
    "deep",
    "other_kind",
    "no_status",
    "long_number",
    "two_kinds",
)


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("faults")


@pytest.fixture(scope="module")
def trials(folder: Path, plumbline: Command) -> Iterator[pd.DataFrame]:
    patch = pytest.MonkeyPatch()
    patch.setenv("PICKLED", str(folder / "pickled"))
    (folder / "faults.toml").write_text(STUDY)
    wanted = [word for engine in ENGINES for word in ("--engine", engine)]
    done = plumbline("run", folder / "faults.toml", *wanted, "--workers", 4, "--out", folder / "out", plugins=True)
    assert done.returncode == 0, done.stderr
    yield Store(folder / "out").trials.set_index(["engine", "track"])
    patch.undo()


@pytest.mark.parametrize(
    ("engine", "status", "reason"),
    [
        ("sound", "passed", "every check holds"),
        ("segfault", "crashed", "SIGSEGV"),
        ("abort", "crashed", "SIGABRT"),
        ("vanish", "crashed", "exit code 0 and no result"),
        ("hang", "timeout", "deadline of 4 s"),
        ("hoard", "oom", "1000 MB"),
        ("raise", "crashed", "the engine's own exception"),
        ("flood", "crashed", "File too large"),
        ("nan", "diverged", "step"),
        ("compile", "passed", "every check holds"),
        # It loads for 2.5 s and works for 2.5 s: neither is more than the deadline.
        ("loading_slowly", "passed", "every check holds"),
        ("compile_hang", "timeout", "deadline of 4 s passed, and it did nothing"),
        ("absent", "unavailable", "not installed"),
        ("surrogate", "crashed", r"half a letter: \udc80, a colour: \u001b[31m"),
        ("real_time", "crashed", "killed by signal 37"),
        ("orphan", "passed", "every check holds"),
        ("norm_3", "crashed", "q_WB of body 'ball' at t = 0.0833333 s: got norm 3, expected 1"),
        ("norm_0", "crashed", "q_WB of body 'ball' at t = 0.0833333 s: got norm 0, expected 1"),
        ("count", "crashed", "broken contract: record.resolved.iterations: got np.int64(5)"),
        ("warning", "crashed", "BrokenContract: warnings()[0]: got b'bytes'"),
        ("garbage", "crashed", "broken contract: no JSON"),
        ("pickle", "crashed", "broken contract: no JSON"),
        ("pickle_line", "crashed", "broken contract: no JSON"),
        ("long_line", "crashed", "broken contract: a message of more than 4194304 bytes"),
        ("half_a_line", "timeout", "deadline of 4 s"),
        ("deep", "crashed", "broken contract: no JSON (RecursionError)"),
        ("other_kind", "crashed", "broken contract: a 'steps', expected a record"),
        ("no_status", "crashed", "broken contract: trial"),
        ("long_number", "crashed", "broken contract: no JSON"),
        ("two_kinds", "crashed", "broken contract: expected one kind of message"),
    ],
)
def test_a_faulty_engine_is_an_outcome_with_its_reason(
    trials: pd.DataFrame, engine: str, status: str, reason: str, ledger: Page
) -> None:
    for track in ("default", "tuned"):
        row = trials.loc[(engine, track)]
        assert row["status"] == status
        assert reason in row["reason"]
    if engine not in ("sound", "compile", "loading_slowly"):
        ledger.survived("engine and its pipe", engine.replace("_", " "), f"{status}, other cells lost 0")


def test_what_a_process_hands_over_runs_no_command(trials: pd.DataFrame, folder: Path) -> None:
    assert len(trials)
    assert not (folder / "pickled").exists()


def test_the_pickle_would_run_its_command_where_pickles_are_opened(folder: Path, with_plugins: Mapping[str, str]) -> None:
    script = "import faulty, pickle; pickle.loads(faulty.TOLD['pickle'][4:])"
    opened = folder / "opened"
    subprocess.run([sys.executable, "-c", script], env={**with_plugins, "PICKLED": str(opened)}, check=True)
    assert opened.exists()


def test_what_an_engine_starts_ends_with_its_trial(trials: pd.DataFrame) -> None:
    assert len(trials)
    found = [process.pid for process in psutil.process_iter(["cmdline"]) if "86399.25" in (process.info["cmdline"] or ())]
    assert not found


@pytest.mark.parametrize("table", ["trials", "measurements"])
def test_what_an_engine_says_is_shown_without_control_characters(
    trials: pd.DataFrame, folder: Path, table: str, printed: Command
) -> None:
    assert len(trials)
    done = printed("show", folder / "out", "--table", table)
    assert done.returncode == 0, done.stderr
    assert "\x1b" not in done.stdout


def test_every_cell_has_exactly_one_row(trials: pd.DataFrame) -> None:
    assert len(trials) == 2 * len(ENGINES)
    assert trials.index.is_unique


def test_a_gigabyte_of_output_leaves_a_megabyte_of_log(trials: pd.DataFrame, folder: Path) -> None:
    for track in ("default", "tuned"):
        log = folder / "out" / "logs" / f"{trials.loc[('flood', track)]['trial']}.log"
        assert 0 < log.stat().st_size <= 2**20


def test_what_a_crashing_engine_printed_is_kept(trials: pd.DataFrame) -> None:
    assert "about to read address zero" in trials.loc[("segfault", "tuned")]["detail"]


def test_the_sound_engine_answers_as_without_its_faulty_neighbours(
    trials: pd.DataFrame, tmp_path: Path, plumbline: Command
) -> None:
    (tmp_path / "faults.toml").write_text(STUDY)
    done = plumbline("run", tmp_path / "faults.toml", "--engine", "sound", "--out", tmp_path / "out", plugins=True)
    assert done.returncode == 0, done.stderr
    alone = Store(tmp_path / "out").trials.set_index(["engine", "track"])
    assert list(alone["trajectory_hash"]) == list(trials.loc["sound"]["trajectory_hash"])


def test_a_third_partys_engine_stands_in_the_listing_beside_the_built_in_ones(plumbline: Command) -> None:
    done = plumbline("engines", "--json", plugins=True)
    rows = {row["name"]: row for row in json.loads(done.stdout)}
    assert rows["sound"]["available"]
    assert rows["sound"]["version"] == "1.0"
    assert not rows["absent"]["available"]
    assert "not installed" in rows["absent"]["unavailable"]


@pytest.mark.parametrize(
    ("engine", "reason"),
    [("segfault_again", "killed by SIGSEGV"), ("hang_again", "deadline of 4 s passed"), ("raise_again", "the engine's own")],
)
def test_an_answer_outlives_the_rough_clock_of_a_sweep(
    engine: str, reason: str, tmp_path: Path, plumbline: Command, ledger: Page
) -> None:
    """An engine that does not bear to be built twice in a process has its answers, no cost, and a warning that says why."""
    (tmp_path / "faults.toml").write_text(STUDY + "sweep = 4\n")
    done = plumbline("run", tmp_path / "faults.toml", "--engine", engine, "--out", tmp_path / "out", plugins=True)
    assert done.returncode == 0, done.stderr
    told = Store(tmp_path / "out").trials.set_index("track")
    for track in ("default", "tuned"):
        assert told.loc[track, "status"] == "passed"
        assert pd.isna(told.loc[track, "rough_cost"])
        assert "rough cost: none" in str(told.loc[track, "warnings"])
        assert reason in str(told.loc[track, "warnings"])
    ledger.survived("engine under the rough clock", engine.replace("_", " "), "answers lost 0")
