"""The one rule for the speed at an error: known between two steps, else that of one run; a bound never stands for a value."""

from pathlib import Path

import pandas as pd
import pytest

from plumbline.harness.findings.selection import Wish, choose
from plumbline.harness.findings.selection.words import undecided_sentence
from plumbline.harness.findings.speed import Speed, speeds
from plumbline.harness.store.store import Store
from tests.run_folder import LADDER
from tests.selection_folder import STEPS, Made, write_selection_folder

COARSEST = max(LADDER)


def speed_of(folder: Path, made: Made, error: float) -> Speed | None:
    store = Store(write_selection_folder(folder, {"mujoco": made}, 0, noise=0.0))
    return speeds(store, error).get(("joint_pendulum", "mujoco", "tuned"))


def test_between_two_steps_the_speed_is_that_of_the_error_asked_for(tmp_path: Path) -> None:
    """2 % at 1/240 s at a cost of 0.1: 1 % is met at half the step, at twice the cost."""
    found = speed_of(tmp_path, Made(2.0, 0.1), 1e-2)
    assert found is not None
    assert (found.at_error, found.bound) == (True, False)
    assert found.times.value == pytest.approx(5.0, rel=1e-6)
    assert found.error == 1e-2
    assert found.step == ""


def test_a_speed_between_two_steps_is_unstable_where_the_timing_of_either_was(tmp_path: Path) -> None:
    """1 % lies between the finest step and 1/240 s; the coarsest has no part in it."""
    for dt, unstable in zip(STEPS, (False, True, True), strict=True):
        folder = write_selection_folder(tmp_path / f"{dt:.4f}", {"mujoco": Made(1.9, 0.1)}, 0, noise=0.0)
        trials = pd.read_parquet(folder / "trials.parquet")
        trials["unstable_timing"] |= (trials["dt"] / dt - 1).abs() < 1e-9
        trials.to_parquet(folder / "trials.parquet", index=False)
        found = speeds(Store(folder), 1e-2)["joint_pendulum", "mujoco", "tuned"]
        assert (found.at_error, found.unstable) == (True, unstable), dt


def test_where_no_step_errs_more_it_is_the_cheapest_run_and_says_so(tmp_path: Path) -> None:
    """0.8 % at 1/60 s, the coarsest that was run: 10 % might be met much faster, which nobody has measured."""
    found = speed_of(tmp_path, Made(0.2, 0.1), 1e-1)
    assert found is not None
    assert (found.at_error, found.bound) == (False, True)
    assert found.times.value == pytest.approx(COARSEST * 240 / 0.1, rel=1e-6)
    assert found.error == pytest.approx(8e-3)
    assert found.words == "40 times real time at dt = 1/60 s"


def test_where_none_comes_down_to_the_error_it_is_the_cheapest_run_that_passes(tmp_path: Path) -> None:
    found = speed_of(tmp_path, Made(0.9, 0.1), 1e-5)
    assert found is not None
    assert (found.at_error, found.bound) == (False, False)
    assert found.error > 1e-3


def test_a_run_that_fails_another_check_than_that_of_the_error_has_no_speed(tmp_path: Path) -> None:
    folder = write_selection_folder(tmp_path, {"mujoco": Made(0.5, 0.1)}, 0, noise=0.0)
    frame, trials = pd.read_parquet(folder / "measurements.parquet"), pd.read_parquet(folder / "trials.parquet")
    sunk = frame.assign(metric="penetration", value=1.0, at_most=0.1, passed=False).astype({"passed": "boolean"})
    pd.concat([frame, sunk]).to_parquet(folder / "measurements.parquet", index=False)
    trials.assign(status="failed", reason="penetration").to_parquet(folder / "trials.parquet", index=False)
    assert speeds(Store(folder), 1e-2) == {}


def test_a_speed_that_larger_steps_may_raise_leaves_a_requirement_open(tmp_path: Path) -> None:
    """The other is known to be too slow, and is left out."""
    engines = {"mujoco": Made(0.02, 0.8), "dart": Made(2.0, 0.2)}
    folder = write_selection_folder(tmp_path / "run", engines, 0, noise=0.0)
    found = choose(Store(folder), Wish(realtime=15.0))
    assert {drop.engine for drop in found.dropped} == {"dart"}
    assert {drop.engine for drop in found.undecided} == {"mujoco"}
    said = undecided_sentence(found.undecided[0], str, str)
    assert "5 times real time at dt = 1/60 s, and no larger step was run" in said
