"""What a folder says of its clock: a price of a part of a run is named."""

from dataclasses import replace
from pathlib import Path

import pytest
from click.testing import CliRunner, Result

from plumbline.harness.cli.main import main
from plumbline.harness.findings.summary import summaries
from plumbline.harness.run.campaign import carry_out
from plumbline.harness.store import journal
from plumbline.harness.store.journal import Journal, read_written
from plumbline.harness.store.record import Clocked
from plumbline.harness.store.store import Store, write_json
from plumbline.harness.store.stored_tables import in_order, write_tables
from plumbline.harness.study import plugins
from plumbline.harness.study.experiment import Experiment
from plumbline.harness.study.study import Study

CASE = "flight_box"
STUDY = Study(
    name="clock", recordings=False, experiments=(Experiment(name="c", cases=(CASE,), samples=1, sample_seconds=1e-3),)
)


@pytest.fixture(scope="module")
def run(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("clock") / "run"
    carry_out(STUDY, folder, {CASE: plugins.case(CASE)}, {"mujoco": plugins.adapter("mujoco")}, workers=1, resume=False)
    return _summarised(folder)


def _summarised(folder: Path) -> Path:
    for name, content in summaries(Store(folder)).items():
        (folder / name).write_bytes(content)
    return folder


def _written_anew(source: Path, out: Path, clocked: Clocked = "whole runs", **changes: int) -> Path:
    """A folder with the same answers, whose first timing has samples with these changes; its chain and seals are right."""
    records = read_written(source / "journal.jsonl")
    out.mkdir()
    book = Journal(out)
    book.begin(records.sessions[0])
    for number, record in enumerate(records.records.values()):
        book.append(replace(record, timing=None))
        timing = record.timing
        assert timing is not None
        if number == 0:
            samples = tuple(replace(sample, **changes) for sample in timing.samples)
            timing = replace(timing, clocked=clocked, samples=samples)
        book.append(timing)
    book.close()
    for name in ("study.toml", "catalogue.json"):
        for path in source.glob(f"{name}*"):
            (out / path.name).write_bytes(path.read_bytes())
    for folder in ("trajectories", "truths", "logs"):
        for path in (source / folder).glob("*"):
            (out / folder).mkdir(exist_ok=True)
            (out / folder / path.name).write_bytes(path.read_bytes())
    ended = {"journal": book.written.reached, "tables": write_tables(out, in_order(book.records.values()))}
    write_json(out / "machine.json", {**Store(source).machine, **ended})
    return _summarised(out)


def _verified(folder: Path) -> Result:
    return CliRunner().invoke(main, ["verify", str(folder)])


def test_every_sample_of_a_run_is_of_whole_runs_and_the_row_says_so(run: Path) -> None:
    store = Store(run)
    assert set(store.trials["clocked"]) == {"whole runs"}
    assert (store.samples["run"] == 240).all()
    assert (store.samples["steps"] % 240 == 0).all()
    assert _verified(run).exit_code == 0


def test_a_folder_written_anew_as_it_was_verifies(run: Path, tmp_path: Path) -> None:
    told = _verified(_written_anew(run, tmp_path / "same"))
    assert (told.exit_code, told.stdout) == (0, "")


PARTS: list[tuple[Clocked, dict[str, int]]] = [
    ("whole runs", {"steps": 37}),
    ("whole runs", {"steps": 37, "run": 37}),
    ("whole runs", {"steps": 37, "run": 0}),
    ("calls", {"steps": 37, "run": 0}),
]


@pytest.mark.parametrize(("clocked", "changes"), PARTS, ids=str)
def test_a_doctored_store_whose_price_is_of_a_part_of_a_run_exits_with_3(
    run: Path, tmp_path: Path, clocked: Clocked, changes: dict[str, int], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(journal, "parts_of_runs", lambda *_: [])
    told = _verified(_written_anew(run, tmp_path / "doctored", clocked, **changes))
    assert told.exit_code == 3
    assert "was clocked over 37 steps, expected whole runs of 240" in told.stdout


def test_no_price_of_a_part_of_a_run_is_stored(run: Path, tmp_path: Path) -> None:
    with pytest.raises(AssertionError, match="clocked over parts of runs"):
        _written_anew(run, tmp_path / "part", steps=37)
