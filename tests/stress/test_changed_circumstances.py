"""A run that goes on after something has changed: what holds is kept, the rest is run anew and says why, nothing is mixed."""

import os
import shutil
import subprocess
import sys
from collections.abc import Iterator, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from plumbline.api.present import present
from plumbline.harness.run import campaign
from plumbline.harness.run.verify import problems
from plumbline.harness.store import machine_fingerprint
from plumbline.harness.store.journal import FolderTaken, read_written
from plumbline.harness.store.store import Store
from plumbline.harness.study import plugins, provenance, sources
from plumbline.harness.study.study import Study
from plumbline.harness.trial import answer
from plumbline.reports.html.report import NOT_MADE
from tests.conftest import PLUGINS, Command
from tests.stress.ledger import Page
from tests.stress.light_run import STUDY, carry_out, light
from tests.stress.test_interruption import write_study

FAMILY = "resume under changed circumstances"
OTHER_MACHINE = {"processor": "another", "cores": 3}

HARNESS = Path(sources.__file__).parents[1]


def clear() -> None:
    for module in (sources, provenance):
        for one in vars(module).values():
            if hasattr(one, "cache_clear"):
                one.cache_clear()


@pytest.fixture(autouse=True)
def _light(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    light(monkeypatch)
    clear()
    yield
    clear()


@pytest.fixture(scope="module")
def carried_out(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A whole run folder, which is only read and copied."""
    folder = tmp_path_factory.mktemp("whole") / "run"
    with pytest.MonkeyPatch.context() as patch:
        light(patch)
        carry_out(folder)
    return folder


@pytest.fixture
def run(carried_out: Path, tmp_path: Path) -> Path:
    """A copy of it, to go on in."""
    shutil.copytree(carried_out, tmp_path / "run")
    return tmp_path / "run"


def marks(folder: Path) -> set[tuple[str, ...]]:
    """What tells rows apart that do not belong together."""
    trials = Store(folder).trials
    return {*zip(*(map(str, trials[name]) for name in ("engine_version", "sources", "clocked_on")), strict=True)}


def unmixed(folder: Path, trials: int = 2) -> None:
    """As many rows as cells, all of today's circumstances, and a folder that is whole."""
    assert len(Store(folder).trials) == trials
    assert len(marks(folder)) == 1
    assert [*problems(folder)] == []


def edit(monkeypatch: pytest.MonkeyPatch, file: Path) -> None:
    """As if a line were added to a source file."""
    plain = Path.read_bytes
    monkeypatch.setattr(Path, "read_bytes", lambda self: plain(self) + b"\n# changed" * (self == file))
    clear()


@pytest.mark.parametrize(
    ("file", "words"),
    [
        (PLUGINS / "faulty.py", "runs anew 2: the adapter's source changed: faulty.py; the case's source changed: faulty.py"),
        (
            HARNESS / "trial" / "simulate.py",
            "runs anew 2: the harness that steps changed: harness/trial/simulate.py",
        ),
        (
            HARNESS / "metrics" / "errors.py",
            "runs anew 2: the adapter's source changed: harness/metrics/errors.py",
        ),
    ],
    ids=lambda value: value.name if isinstance(value, Path) else "",
)
def test_a_changed_source_runs_its_trials_anew(
    file: Path, words: str, run: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], ledger: Page
) -> None:
    before = set(Store(run).trials["trial"])
    edit(monkeypatch, file)
    after = set(carry_out(run).trials["trial"])
    assert not before & after
    assert words in capsys.readouterr().err
    unmixed(run)
    ledger.survived(FAMILY, f"{file.name} edited before a resume", "unmarked rows 0")


def compared(store: Store) -> dict[str, Any]:
    """The tables of a run, as words, without what differs from run to run: who clocked it, and that it was not simulated."""
    trials = store.trials.drop(columns=["simulated_as"]).set_index("trial")
    return {"trials": trials.to_csv(), "measurements": store.measurements.to_csv(), "samples": store.samples.to_csv()}


def test_what_only_judges_is_edited_and_nothing_is_simulated(
    run: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], ledger: Page
) -> None:
    first = Store(run).trials
    edit(monkeypatch, HARNESS / "trial" / "truth_cache.py")
    with monkeypatch.context() as patch:
        patch.setattr(answer, "simulate", None)
        patch.setattr(campaign, "clock_group", lambda *_, **__: pytest.fail("the clock is asked"))
        again = carry_out(run)
    assert "judges anew 2: the harness that measures changed: harness/trial/truth_cache.py" in capsys.readouterr().err
    assert set(again.trials["simulated_as"]) == set(first["trial"])
    assert not set(again.trials["trial"]) & set(first["trial"])
    assert set(again.trials["motion"]) == set(first["motion"])
    unmixed(run)
    fresh = carry_out(tmp_path / "fresh")
    assert set(fresh.trials["simulated_as"]) == {""}
    assert compared(again) == compared(fresh)
    for path in (tmp_path / "fresh" / "trajectories").iterdir():
        assert (run / "trajectories" / path.name).read_bytes() == path.read_bytes()
    ledger.survived(FAMILY, "a bound or metric edited before a resume", "simulated anew 0, other than a fresh run 0")


def test_an_answer_that_was_judged_anew_is_judged_anew_once_more(run: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    first = set(Store(run).trials["trial"])
    for name in ("truth_cache.py", "accuracy.py"):
        with monkeypatch.context() as patch:
            edit(patch, HARNESS / "trial" / name)
            again = carry_out(run).trials
        clear()
        assert set(again["simulated_as"]) == first
    assert set(carry_out(run).trials["simulated_as"]) == {""}  # the edits are taken back: the first records are


@pytest.mark.parametrize("harm", ["a bit", "gone"])
def test_a_kept_trajectory_that_is_damaged_is_never_judged(
    harm: str, run: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], ledger: Page
) -> None:
    (damaged,) = (run / "trajectories").iterdir()  # both tracks of the falling engine answer alike
    content = damaged.read_bytes()
    damaged.write_bytes(content[:300] + bytes([content[300] ^ 1]) + content[301:])
    if harm == "gone":
        damaged.unlink()
    edit(monkeypatch, HARNESS / "trial" / "truth_cache.py")
    again = carry_out(run).trials
    assert next(iter(again["simulated_as"])) == ""  # its run writes the file anew, which the other one then may be judged by
    assert "runs anew 2: " in capsys.readouterr().err
    assert damaged.read_bytes() == content
    unmixed(run)
    ledger.survived(FAMILY, f"a bound edited, a trajectory damaged ({harm})", "damaged answers judged 0")


def test_an_edit_that_is_taken_back_brings_its_rows_back(run: Path, monkeypatch: pytest.MonkeyPatch, ledger: Page) -> None:
    first = Store(run).trials
    with monkeypatch.context() as patch:
        edit(patch, PLUGINS / "faulty.py")
        carry_out(run)
    clear()
    lines = len(read_written(run / "journal.jsonl").checksums)
    again = carry_out(run).trials
    assert again.equals(first)
    # One line brings two trials back, one withdraws those of the edit, one says what the session began under; two are clocked.
    assert len(read_written(run / "journal.jsonl").checksums) <= lines + 5
    unmixed(run)
    ledger.survived(FAMILY, "an edit made and taken back", "unmarked rows 0, run anew 0")


def test_another_version_of_an_engine_runs_its_trials_anew(
    run: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], ledger: Page
) -> None:
    monkeypatch.setattr(campaign, "version_of", lambda _engine: ("2.0", None))
    carry_out(run)
    assert "runs anew 2: sound: version 1.0 -> 2.0" in capsys.readouterr().err
    unmixed(run)
    assert set(Store(run).trials["engine_version"]) == {"2.0"}
    ledger.survived(FAMILY, "another engine version", "unmarked rows 0")


def test_other_numeric_libraries_run_trials_anew(
    run: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], ledger: Page
) -> None:
    monkeypatch.setattr(sources, "libraries", lambda: "numpy 9.9")
    clear()
    carry_out(run)
    assert "-> numpy 9.9" in capsys.readouterr().err
    unmixed(run)
    ledger.survived(FAMILY, "other numeric libraries", "unmarked rows 0")


def test_another_machine_clocks_anew_and_answers_nothing_anew(
    run: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], ledger: Page
) -> None:
    first = Store(run).trials
    plain = campaign.fingerprint
    monkeypatch.setattr(campaign, "fingerprint", lambda: plain() | OTHER_MACHINE)
    second = carry_out(run).trials
    said = capsys.readouterr().err
    assert "clocks anew 2: clocked on another machine (processor " in said
    assert "-> another, cores " in said
    assert list(second["trial"]) == list(first["trial"])
    assert set(first["clocked_on"]) != set(second["clocked_on"])
    unmixed(run)
    ledger.survived(FAMILY, "another machine", "unmarked timings 0, run anew 0")


@pytest.mark.parametrize(
    ("other", "where"),
    [
        (replace(STUDY, name="other"), "name"),
        pytest.param(
            replace(STUDY, experiments=(replace(STUDY.experiments[0], dt=(0.1,)),)),
            r"experiments\[0\].dt\[0\]",
            marks=pytest.mark.slow,
        ),
        (replace(STUDY, experiments=(replace(STUDY.experiments[0], tracks=("tuned",)),)), r"experiments\[0\].tracks"),
    ],
    ids=["name", "dt", "tracks"],
)
def test_another_study_is_refused_and_merged_where_that_is_asked(other: Any, where: str, run: Path, ledger: Page) -> None:
    before = (run / "journal.jsonl").read_bytes()
    with pytest.raises(FolderTaken, match=f"a run of study 'light', which differs in {where}.*--resume=merge"):
        carry_out(run, other)
    assert (run / "journal.jsonl").read_bytes() == before
    assert [*problems(run)] == []
    merged = carry_out(run, other, resume="merge").trials
    assert len(merged) == (4 if where != r"experiments\[0\].tracks" else 2)
    assert [*problems(run)] == []
    carry_out(run)
    carry_out(run, other)
    assert len(Store(run).trials) == len(merged)
    ledger.survived(
        FAMILY, f"another study (its {where.rpartition('.')[2].partition(chr(92))[0]})", "refused; merged on request"
    )


def test_a_study_that_was_written_before_it_had_a_list_for_something_is_the_same_study(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, ledger: Page
) -> None:
    today = campaign.plain_study

    def older(study: Study) -> dict[str, Any]:
        written = today(study)
        for experiment in written["experiments"]:
            assert experiment.pop("libraries") == []
        return written

    with monkeypatch.context() as patch:
        patch.setattr(campaign, "plain_study", older)
        first = carry_out(tmp_path / "run").trials
    assert list(carry_out(tmp_path / "run").trials["trial"]) == list(first["trial"])
    ledger.survived(FAMILY, "a study without a list that is empty today", "run anew 0")


def test_an_engine_that_is_gone_and_comes_back_keeps_its_rows(run: Path, monkeypatch: pytest.MonkeyPatch, ledger: Page) -> None:
    first = Store(run).trials
    with monkeypatch.context() as patch:
        patch.setattr(campaign, "version_of", lambda _engine: ("none", "not installed"))
        plain = campaign.describe_engine
        patch.setattr(campaign, "describe_engine", lambda engine: plain(engine) | {"unavailable": "not installed"})
        gone = carry_out(run).trials
        assert set(gone["status"]) == {"unavailable"}
        assert len(gone) == 2
    again = carry_out(run).trials
    assert list(again["trajectory_hash"]) == list(first["trajectory_hash"])
    unmixed(run)
    ledger.survived(FAMILY, "an engine that is gone, and back", "unmarked rows 0, run anew 0")


def test_records_beside_what_is_asked_now_stay(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    study = replace(STUDY, experiments=(replace(STUDY.experiments[0], cases=("*",), engines=("*",)),))
    fall = {"stress_fall": plugins.case("stress_fall")}
    for name in ("sound", "raise"):
        engines = {name: plugins.adapter(name)}
        campaign.carry_out(study, tmp_path / "two", fall, engines, workers=1, resume=True)
    assert "keeps 2 of 2 trials, 2 of them beside what is asked now (sound 1.0)" in capsys.readouterr().err
    assert len(Store(tmp_path / "two").trials) == 4


def test_a_run_that_finds_all_done_leaves_tables_and_report_as_they_are(
    run: Path, monkeypatch: pytest.MonkeyPatch, ledger: Page
) -> None:
    """Of the same version; another one, tables that were touched, and a report with a page that failed are made anew."""
    index, table = run / "report" / "index.html", run / "trials.parquet"

    def gone_on(commit: str) -> tuple[int, int]:
        monkeypatch.setattr(machine_fingerprint, "_commit", lambda: commit)
        present(carry_out(run), recordings=False, anew=False)
        assert not [*problems(run)]
        return table.stat().st_mtime_ns, index.stat().st_mtime_ns

    clean = gone_on("one")
    assert gone_on("one") == clean
    for commit in ("another", "another+", "another+", "one"):  # what is not committed may change unseen
        table_before, page_before = clean
        clean = gone_on(commit)
        assert clean[0] > table_before
        assert clean[1] > page_before
    index.write_text(f"{index.read_text()}{NOT_MADE}")
    failed = gone_on("one")
    assert failed[0] == clean[0]
    assert failed[1] > clean[1]
    assert NOT_MADE not in index.read_text()
    table.write_bytes(table.read_bytes() + b"x")
    assert gone_on("one")[0] > failed[0]
    ledger.survived(FAMILY, "a run that finds all done", "files written anew 0")


@pytest.mark.slow
def test_the_command_line_says_what_it_keeps_and_what_it_runs_anew(
    tmp_path: Path, with_plugins: Mapping[str, str], plumbline: Command
) -> None:
    """For real: the plug-in's file is edited between two runs."""
    shutil.copytree(PLUGINS, tmp_path / "plugins")
    study, out = write_study(tmp_path), tmp_path / "out"
    paths = os.pathsep.join((str(tmp_path / "plugins"), with_plugins.get("PYTHONPATH", "")))

    def run(*more: str) -> "subprocess.CompletedProcess[str]":
        command = [sys.executable, "-m", "plumbline", "run", study, "--engine", "sound", "--out", out, *more]
        environment = dict(with_plugins) | {"PYTHONPATH": paths}
        return subprocess.run([*map(str, command)], env=environment, capture_output=True, text=True, timeout=280, check=False)

    assert run().returncode == 0
    with (tmp_path / "plugins" / "faulty.py").open("a") as file:
        file.write("\n# another line\n")
    done = run("--resume")
    assert done.returncode == 0, done.stderr
    assert f"{out}: runs anew 20: the adapter's source changed: faulty.py" in done.stderr
    assert len(Store(out).trials) == 20
    assert plumbline("verify", out).returncode == 0
