"""A trial read back from a run folder: with its settings, and with the time and memory that its study allowed."""

from pathlib import Path

import pytest

from plumbline.harness.store.journal import StoreError
from plumbline.harness.store.store import Store
from plumbline.harness.study.reproduce import trial_of
from tests.run_folder import write_run_folder

STUDY = """name = "quick"
[[experiments]]
name = "ladder"
cases = ["spin_*"]
deadline = 5.0
[[experiments]]
name = "ladder"
cases = ["joint_*"]
deadline = 900.0
memory = 20000.0
"""


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """A run folder whose trials are of an experiment 'ladder'."""
    return write_run_folder(tmp_path / "run", only=("joint_pendulum", "rest_table"))


def _name(folder: Path, case: str) -> str:
    trials = Store(folder).trials
    return str(trials.loc[trials["case"] == case, "trial"].iloc[0])


def test_a_trial_is_run_again_within_the_limits_of_its_study(folder: Path) -> None:
    (folder / "study.toml").write_text(STUDY)
    again = trial_of(Store(folder), _name(folder, "joint_pendulum"))
    assert (again.experiment.name, again.experiment.deadline, again.experiment.memory) == ("ladder", 900.0, 20000.0)
    assert not again.experiment.timing


@pytest.mark.parametrize("study", ["", STUDY])
def test_where_the_study_does_not_say_the_limits_are_those_that_nobody_sets(folder: Path, study: str) -> None:
    (folder / "study.toml").write_text(study)
    again = trial_of(Store(folder), _name(folder, "rest_table"))
    assert (again.experiment.name, again.experiment.deadline, again.experiment.memory) == ("ladder", 60.0, 4096.0)


def test_a_name_that_is_none_or_not_one_trials_is_refused(folder: Path) -> None:
    with pytest.raises(StoreError, match="names 0 trials, expected one"):
        trial_of(Store(folder), "nonsense")
