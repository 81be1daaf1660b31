"""What the coordinator of a cluster says with a cell, and what a worker does with it: fork servers as on one machine."""

from collections import deque
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from pathlib import Path
from threading import Barrier
from types import SimpleNamespace
from typing import Any, cast

import pytest

from plumbline.harness.run import fork_servers
from plumbline.harness.run.cluster import cells
from plumbline.harness.run.cluster.workplace import Workplace
from plumbline.harness.study import plugins
from plumbline.harness.study.experiment import Experiment
from plumbline.harness.study.provenance import sources_of
from plumbline.harness.study.study import Study
from plumbline.harness.study.trial import Trial
from plumbline.harness.trial.accuracy import outcome
from tests.needs import BULLET

MODULES = ("scipy.integrate", "plumbline.cases.flight_box")


@pytest.fixture(scope="module")
def trial() -> Trial:
    adapter = plugins.adapter("bullet")
    study = Study(name="s", experiments=(Experiment(name="e", tracks=("tuned",)),))
    versions = {"bullet": plugins.version_of(adapter)[0]}
    (trial,) = study.trials({"flight_box": plugins.case("flight_box")}, {"bullet": adapter}, versions, sources_of)
    return trial


@BULLET
def test_processes_of_a_cell_have_loaded_what_the_run_needs(trial: Trial, monkeypatch: pytest.MonkeyPatch) -> None:
    """A cell comes alone: that its engine will come again, and what the cases of the run import, is said with it."""
    ran: list[tuple[Sequence[Trial], int, list[str]]] = []

    def run_isolated(trials: Sequence[Trial], _folder: object, _workers: int, foreseen: int) -> list[Any]:
        ran.append((trials, foreseen, fork_servers._preload(fork_servers.Origin())))
        return [outcome(trial, "unsupported", "nothing was asked")]

    monkeypatch.setattr(cells, "run_isolated", run_isolated)
    monkeypatch.setattr(fork_servers, "_expected", [])
    cells.answer_cell(trial, 7, MODULES)
    ((trials, foreseen, modules),) = ran
    assert trials == [trial]
    assert foreseen == 7
    assert set(MODULES) <= set(modules)


@BULLET
def test_threads_of_a_worker_answer_at_once_each_in_a_folder_of_its_own(trial: Trial, monkeypatch: pytest.MonkeyPatch) -> None:
    both, folders = Barrier(2, timeout=60), list[Path]()

    def run_isolated(trials: Sequence[Trial], folder: Path, _workers: int, _foreseen: int) -> list[Any]:
        (folder / "logs").mkdir()
        (folder / "logs" / "a.log").write_text(folder.name)
        folders.append(folder)
        both.wait()
        return [outcome(trial, "unsupported", "nothing was asked") for trial in trials]

    monkeypatch.setattr(cells, "run_isolated", run_isolated)
    with ThreadPoolExecutor(2) as threads:
        answered = list(threads.map(cells.answer_cell, [trial, trial]))
    assert len(set(folders)) == 2
    assert not any(folder.exists() for folder in folders)
    assert {answer.files["logs/a.log"] for answer in answered} == {folder.name.encode() for folder in folders}


@BULLET
def test_a_truth_goes_to_each_run_once(trial: Trial, monkeypatch: pytest.MonkeyPatch) -> None:
    """A worker lives through several runs, and its truths with it."""

    def run_isolated(trials: Sequence[Trial], folder: Path, _workers: int, _foreseen: int) -> list[Any]:
        (folder / "truths" / "a.npz").write_bytes(b"states")
        return [outcome(trial, "unsupported", "nothing was asked") for trial in trials]

    monkeypatch.setattr(cells, "run_isolated", run_isolated)
    sent = [cells.answer_cell(trial, run=run).files for run in ("first", "first", "second")]
    assert sent == [{"truths/a.npz": b"states"}, {}, {"truths/a.npz": b"states"}]


def test_a_worker_is_told_how_often_an_engine_will_come_and_what_is_to_be_loaded(trial: Trial) -> None:
    told: list[tuple[list[Trial], list[int], tuple[str, ...]]] = []

    def handed_out(_answer: object, trials: list[Trial], foreseen: list[int], **how: Any) -> list[str]:
        told.append((trials, foreseen, how["modules"]))
        return [f"future {number}" for number in range(len(trials))]

    workplace = Workplace.__new__(Workplace)
    workplace._client = SimpleNamespace(map=handed_out, nthreads=lambda: {"tcp://a": 8, "tcp://b": 8})
    workplace._run = "a run"
    workplace.expect(MODULES)
    waiting = deque(replace(trial, seed=seed).named() for seed in range(3))
    foreseen = {"bullet": 30}
    futures = workplace._handed_out(waiting, 0, 0, cells.answer_cell, foreseen)
    assert len(futures) == 3
    ((trials, counts, modules),) = told
    assert [cast(Trial, cell) for _, cell in futures] == trials
    assert counts == [15, 15, 15]
    assert modules == MODULES
