"""Why trials ended, in words for people: made of what was measured, without names of metrics or effects as code has them."""

from pathlib import Path

import pandas as pd
import pytest

from plumbline.harness.store.record import Measurement, StoredNotice
from plumbline.harness.store.store import Store
from plumbline.reports.tables.trial_results import answers
from plumbline.reports.words.status import notices, reasons
from tests.recorded_folder import Folder, record
from tests.run_folder import write_run_folder


def measured(metric: str, value: float, passed: bool | None, *, at_most: float | None = 0.25, unit: str = "m") -> Measurement:
    return Measurement(metric=metric, value=value, unit=unit, at_most=at_most, passed=passed, because="made")


BLIND = float("nan")


@pytest.mark.parametrize(
    ("status", "measurements", "words"),
    [
        ("failed", [measured("position_error_max", 0.5, False)], "largest position error 0.5 m, bound 0.25 m"),
        (
            "failed",
            [measured("creep", 0.1, True), measured("creep", 0.5, False), measured("friction_ratio", 2.0, False, unit="1")],
            "creep (2) 0.5 m, bound 0.25 m; friction ratio 2, bound 0.25",
        ),
        ("failed", [], "as stored"),
        ("passed", [measured("contact_gap", BLIND, None)], "every check holds; not measurable: contact gap"),
        ("passed", [measured("contact_gap", BLIND, None, at_most=None)], "as stored"),  # observed only: no check
        ("diverged", [measured("position_error_max", 0.5, False)], "as stored"),
    ],
)
def test_a_reason_is_made_of_what_was_measured(
    tmp_path: Path, status: str, measurements: list[Measurement], words: str
) -> None:
    folder = Folder(tmp_path / "run")
    trial = folder.add(record("c", "mujoco", status=status, reason="as stored", measurements=tuple(measurements)))
    folder.journal.close()
    assert reasons(Store(folder.path))[trial] == words


def test_a_notice_is_told_by_its_kind_and_in_its_own_words(tmp_path: Path) -> None:
    said = (StoredNotice("linear damping, by default", "surplus", "linear_damping"), StoredNotice("a note_of it"))
    folder = Folder(tmp_path / "run")
    trial = folder.add(record("c", "mujoco", warnings=said))
    folder.journal.close()
    assert notices(Store(folder.path), trial) == ["surplus: linear damping, by default", "a note_of it"]


def test_every_answer_has_its_reason_in_words_and_the_stored_one_beside_it(tmp_path: Path) -> None:
    store = Store(write_run_folder(tmp_path / "run", only=("joint_pendulum",)))
    rows = answers(store)
    failed = rows[rows["status"] == "failed"]
    assert len(failed)
    assert not failed["said"].str.contains("angle_error").any()
    assert failed["said"].str.startswith("angle error ").all()
    pd.testing.assert_series_equal(rows["reason"], store.asked["reason"].reset_index(drop=True))
