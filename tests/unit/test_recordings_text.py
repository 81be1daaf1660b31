"""What is not drawn of a run stands in the text of its recording: nothing is left out without a word."""

import dataclasses
from pathlib import Path

import numpy as np
import pytest

from plumbline.harness.store.journal import StoreError
from plumbline.reports.recordings import recording_of
from plumbline.reports.recordings.viewer import open_viewer
from tests.recorded_folder import Folder, Read, record, rising, zoo

STATUSES = ("passed", "failed", "diverged", "unsupported", "unavailable", "timeout", "crashed", "oom", "interrupted")


@pytest.fixture
def folder(tmp_path: Path) -> Folder:
    return Folder(tmp_path / "run")


def test_a_diverged_run_is_shown_as_far_as_it_is_finite_and_says_why(folder: Folder) -> None:
    actual = rising(zoo())
    actual.v_WB[7:, 2, 0] = np.nan
    reason = "by step 7 of 10: a state is not finite"
    folder.add(record("rise", "mujoco", status="diverged", reason=reason), zoo(), actual, rising(zoo()))
    folder.add(record("rise", "bullet"), zoo(), rising(zoo()), rising(zoo()))
    read = Read(folder.write()[0])
    assert len(read.column("/world/mujoco/tuned/sphere", "InstancePoses3D:translations")) == 7
    assert len(read.column("/world/bullet/tuned/sphere", "InstancePoses3D:translations")) == 11
    row = next(line for line in read.text().splitlines() if line.startswith("| mujoco"))
    assert "diverged" in row
    assert reason in row
    assert "shown up to instant 7 of 11" in row


def test_every_outcome_is_listed_and_a_case_without_any_trajectory_has_its_text(folder: Folder) -> None:
    for status in STATUSES:
        folder.add(record("void", "mujoco", status=status, reason=f"because of | {status}"))
    read = Read(folder.write(void={"title": "Nothing"})[0])
    rows = [line for line in read.text().splitlines() if line.startswith("| mujoco")]
    assert len(rows) == len(STATUSES)
    for status in STATUSES:
        # A bar within a reason must not open another cell.
        assert any(f"because of \\| {status}" in row and f"| {status} |" in row for row in rows)
    assert "nothing can be drawn" in read.text()
    assert not [path for path in read.chunks if path.startswith(("/world/mujoco", "/metrics"))]


def test_a_trajectory_that_cannot_be_read_is_named_and_the_others_are_shown(folder: Folder) -> None:
    folder.add(record("rise", "mujoco", trajectory_hash="0123456789abcdef"))
    folder.add(record("rise", "dart"), zoo(), rising(zoo(), 7.0))
    (torn,) = (folder.path / "trajectories").iterdir()
    torn.write_bytes(torn.read_bytes()[:1000])
    folder.add(record("rise", "bullet"), zoo(), rising(zoo()))
    read = Read(folder.write()[0])
    for engine, name in (("mujoco", "0123456789abcdef"), ("dart", torn.stem)):
        row = next(line for line in read.text().splitlines() if line.startswith(f"| {engine}"))
        assert "| no |" in row
        assert f"trajectory {name} is not readable" in row
    assert "/world/bullet/tuned/sphere" in read.chunks
    assert "/world/dart/tuned/sphere" not in read.chunks


def test_of_many_time_steps_the_one_of_the_case_is_shown_and_the_others_are_listed(folder: Folder) -> None:
    for dt in (0.04, 0.01, 0.0025):
        folder.add(record("rise", "mujoco", dt=dt), zoo(), dataclasses.replace(rising(zoo(), 100 * dt), dt=dt))
    read = Read(folder.write(rise={"dt": 0.01, "parameters": {"mass": 2.0}})[0])
    assert read.column("/metrics/speed/mujoco/tuned", "Scalars:scalars")[0] == [pytest.approx(1.0)]
    rows = [line for line in read.text().splitlines() if line.startswith("| mujoco")]
    assert len(rows) == 3
    assert [("| yes |" in row) for row in rows] == [True, False, False]


def test_names_that_are_no_file_names_stay_within_the_folder(folder: Folder) -> None:
    folder.add(record("../../escape", "a/b <c>"), zoo(), rising(zoo()))
    path = folder.write()[0]
    assert path.parent == folder.path / "recordings"
    assert recording_of(folder.path, "../../escape") == path


def test_a_missing_recording_is_told_with_those_that_exist(folder: Folder, tmp_path: Path) -> None:
    folder.add(record("rise", "mujoco"), zoo(), rising(zoo()))
    folder.write()
    assert recording_of(folder.path, "rise").is_file()
    with pytest.raises(StoreError, match="no recording of case 'fall'; there are: rise"):
        recording_of(folder.path, "fall")
    with pytest.raises(StoreError, match="no run folder"):
        recording_of(tmp_path, "rise")


def test_without_a_display_the_viewer_says_what_to_do(
    folder: Folder, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr("sys.platform", "linux")
    for name in ("DISPLAY", "WAYLAND_DISPLAY"):
        monkeypatch.delenv(name, raising=False)
    assert open_viewer(folder.path / "recordings" / "rise.rrd") == 3
    assert f"plumbline serve {folder.path}" in capsys.readouterr().err
