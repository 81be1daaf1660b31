"""Faults of engines: each costs its own cells and nothing else, and each is an outcome with a reason."""

import json
from pathlib import Path

import pandas as pd
import pytest

from harness.store import Store
from tests.conftest import Command

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
    "compile_hang",
    "absent",
)


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("faults")


@pytest.fixture(scope="module")
def trials(folder: Path, plumbline: Command) -> pd.DataFrame:
    (folder / "faults.toml").write_text(STUDY)
    wanted = [word for engine in ENGINES for word in ("--engine", engine)]
    done = plumbline("run", folder / "faults.toml", *wanted, "--out", folder / "out", plugins=True)
    assert done.returncode == 0, done.stderr
    return Store(folder / "out").trials.set_index(["engine", "track"])


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
        ("compile_hang", "timeout", "deadline of 4 s"),
        ("absent", "unavailable", "not installed"),
    ],
)
def test_a_faulty_engine_is_an_outcome_with_its_reason(trials: pd.DataFrame, engine: str, status: str, reason: str) -> None:
    for track in ("default", "tuned"):
        row = trials.loc[(engine, track)]
        assert row["status"] == status
        assert reason in row["reason"]


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
def test_an_answer_outlives_the_rough_clock_of_a_sweep(engine: str, reason: str, tmp_path: Path, plumbline: Command) -> None:
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
