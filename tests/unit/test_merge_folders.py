"""Folders of one study's parts made into one: nothing is lost, nothing is mixed, and what does not fit is named."""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import pytest
from click.testing import CliRunner

from plumbline.harness.cli.main import main
from plumbline.harness.run.campaign import carry_out
from plumbline.harness.run.merge_folders import conflicts, merge_folders
from plumbline.harness.run.verify import problems
from plumbline.harness.store.journal import FolderTaken, Journal, read_written
from plumbline.harness.store.record import Record, Timing
from plumbline.harness.store.store import Store, write_json
from plumbline.harness.store.stored_tables import in_order, write_tables
from plumbline.harness.study import plugins
from plumbline.harness.study.experiment import Experiment
from plumbline.harness.study.study import Study

CASES = ("flight_box", "flight_projectile")
STUDY = Study(
    name="parts",
    recordings=False,
    experiments=(Experiment(name="parts", cases=CASES, samples=1, sample_seconds=0.001),),
)


def _ran(folder: Path, study: Study, shard: tuple[int, int]) -> Path:
    cases, adapters = {name: plugins.case(name) for name in CASES}, {"mujoco": plugins.adapter("mujoco")}
    carry_out(study, folder, cases, adapters, workers=1, resume=False, shard=shard)
    return folder


@pytest.fixture(scope="module")
def parts(tmp_path_factory: pytest.TempPathFactory) -> list[Path]:
    folder = tmp_path_factory.mktemp("parts")
    return [_ran(folder / str(number), STUDY, (number, 2)) for number in (1, 2)]


def _records(folder: Path) -> dict[str, Record]:
    return dict(read_written(folder / "journal.jsonl").records)


def _retold(part: Path, out: Path, records: Sequence[Record], timings: Sequence[Timing] = ()) -> Path:
    """A folder of a part's session with other records."""
    out.mkdir()
    journal = Journal(out)
    journal.begin(read_written(part / "journal.jsonl").sessions[0])
    for entry in (*records, *timings):
        journal.append(entry)
    journal.close()
    write_json(out / "machine.json", {**Store(part).machine, "journal": {"lines": 0, "checksum": ""}})
    write_tables(out, in_order(journal.records.values()))
    return out


def test_the_whole_holds_what_its_parts_hold_and_verifies(parts: list[Path], tmp_path: Path) -> None:
    assert conflicts(parts) == []
    store, notes = merge_folders(parts, tmp_path / "whole")
    assert notes == []
    first, second = map(_records, parts)
    assert not first.keys() & second.keys()
    assert _records(tmp_path / "whole") == first | second
    assert set(store.catalogue["cases"]) == set(CASES)
    assert store.machine["complete"] is True
    assert [p for p in problems(store.folder) if p.path.name not in ("junit.xml", "summary.md")] == []


def test_an_answer_that_two_folders_hold_is_kept_once(parts: list[Path], tmp_path: Path) -> None:
    merge_folders([*parts, parts[0]], tmp_path / "whole")
    assert _records(tmp_path / "whole") == _records(parts[0]) | _records(parts[1])


def test_two_answers_to_one_trial_are_named_and_nothing_is_written(parts: list[Path], tmp_path: Path) -> None:
    one = next(iter(_records(parts[0]).values()))
    other = _retold(parts[0], tmp_path / "other", [replace(one, trajectory_hash="0" * 16)])
    done = CliRunner().invoke(main, ["merge", str(parts[0]), str(other), "--out", str(tmp_path / "whole")])
    assert done.exit_code == 1
    assert one.trial in done.stderr
    assert str(one.trajectory_hash) in done.stderr
    assert "0" * 16 in done.stderr
    assert not (tmp_path / "whole").exists()


def test_what_another_machine_clocked_of_a_question_is_left_out_and_said(parts: list[Path], tmp_path: Path) -> None:
    first, second = (replace(record, timing=None) for record in list(_records(parts[0]).values())[:2])
    assert first.case == second.case
    folders = [
        _retold(parts[0], tmp_path / place, [record], [Timing(trial=record.trial, cpu_per_unit=1.0, clocked_on=place)])
        for place, record in (("here", first), ("there", second))
    ]
    _, notes = merge_folders(folders, tmp_path / "whole")
    written = read_written(tmp_path / "whole" / "journal.jsonl")
    assert [written.clocked_on(record.trial) for record in (first, second)] == ["here", None]
    assert len(notes) == 1
    assert "leaves out 1 timings" in notes[0]


def test_folders_of_two_studies_are_refused(parts: list[Path], tmp_path: Path) -> None:
    other = _ran(tmp_path / "other", replace(STUDY, experiments=(replace(STUDY.experiments[0], timing=False),)), (1, 2))
    with pytest.raises(FolderTaken, match="another study"):
        merge_folders([parts[0], other], tmp_path / "whole")
