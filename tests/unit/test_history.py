"""What nights keep: answers recalled and computed again, deaths, locks, addresses, what goes, and what was damaged."""

import os
import shutil
import signal
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import pytest

from plumbline.harness.case import Case
from plumbline.harness.history import night_policy
from plumbline.harness.history.budget import bytes_of
from plumbline.harness.history.folder import Night, Pool, created, locked, opened
from plumbline.harness.history.night_policy import AGAIN, NightWish, computed_again
from plumbline.harness.history.remote_storage import copy_of
from plumbline.harness.history.retention import COLUMNS, problems_of, prune, pruning, rows
from plumbline.harness.metrics.errors import position_error_max
from plumbline.harness.run import campaign
from plumbline.harness.store.journal import StoreError, read_journal
from tests.conftest import Command
from tests.nights import CELLS, STUDY, Fault, asked, drawn, night, planted
from tests.stress.light_run import STUDY as LIGHT
from tests.stress.light_run import light

LOOK = replace(STUDY, experiments=STUDY.experiments[:1])
"""Its first experiment alone."""


@pytest.fixture
def root(first_night: Path, tmp_path: Path) -> Path:
    """A copy of a history with one night."""
    return Path(shutil.copytree(first_night, tmp_path / "h"))


def test_a_twentieth_of_the_known_answers_is_computed_again_and_the_same_one_for_the_same_seed() -> None:
    names = [f"{number:016x}" for number in range(4000)]
    again = [name for name in names if computed_again(name, "a night")]
    # Binomial: 200 of 4000 with a standard deviation of 14; six of them are never met.
    assert abs(len(again) - AGAIN * len(names)) < 6 * 14
    assert again == [name for name in names if computed_again(name, "a night")]
    assert again != [name for name in names if computed_again(name, "another night")]


def kill_behind_three_answers(root: Path, wanted: NightWish) -> None:
    """Let a night with a fault in our engine die once it has written down three answers."""
    child = os.fork()
    if child == 0:
        with planted(Fault(engine="reference")):
            answers = campaign.run_isolated

            def dying(*arguments: object) -> Iterator[object]:
                for number, record in enumerate(answers(*arguments)):  # type: ignore[arg-type]
                    yield record
                    if number == 2:
                        os.kill(os.getpid(), signal.SIGKILL)

            campaign.run_isolated = dying  # type: ignore[assignment]
            night(root, wanted)
        os._exit(0)
    assert os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) == -signal.SIGKILL


def test_a_night_that_was_killed_goes_on_where_it_was(root: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    drawn(monkeypatch, 0.0)
    before = len(opened(root).nights())
    kill_behind_three_answers(root, wanted := asked(LOOK))
    history = opened(root)
    killed = history.nights()[-1]
    assert len(history.nights()) == before + 1
    assert not killed.whole
    with planted(Fault(engine="reference")) as computed:
        again, _, account = night(root, wanted)
    assert again == killed
    assert again.whole
    assert len(computed) == 4 - 3  # three were written down before it died
    assert account["answers"] == 2 * 4
    assert [*problems_of(history)] == []


def test_a_night_that_goes_on_keeps_no_more_new_trajectories_than_one_that_was_never_killed(
    kept_nothing: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    root = Path(shutil.copytree(kept_nothing, tmp_path / "h"))
    kill_behind_three_answers(root, wanted := asked(LOOK, keep="all"))
    there = opened(root).nights()[-1].folder / "trajectories"
    before = {path.stem: path.stat().st_size for path in there.glob("*.npz")}
    assert before
    monkeypatch.setattr(night_policy, "MOST_KEPT", sum(before.values()) + 1)
    with planted(Fault(engine="reference")) as computed:
        night(root, wanted)
    assert computed
    assert {path.stem for path in there.glob("*.npz")} == before.keys()


def test_two_nights_never_meet_and_a_dead_one_holds_nothing(tmp_path: Path) -> None:
    history = created(tmp_path / "h")
    told, tell = os.pipe()
    child = os.fork()
    if child == 0:
        with locked(history):
            os.write(tell, b"held")
            signal.pause()
    assert os.read(told, 4) == b"held"
    with pytest.raises(StoreError, match=f"another night holds it .process {child} on "), locked(history):
        pass
    os.kill(child, signal.SIGKILL)
    os.waitpid(child, 0)
    with locked(history):
        pass


def test_a_history_lies_at_any_address(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "here"))
    there = copy_of("memory://nights/h")
    few = asked(LOOK, engines=("mujoco",))
    with there.locked(60.0), pytest.raises(StoreError, match="another night holds it"), there.locked(60.0):
        pass
    with planted():
        night(there.root, few)
    there.send()
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "another machine"))
    elsewhere = copy_of("memory://nights/h")
    assert elsewhere.root != there.root
    elsewhere.fetch()
    assert [*problems_of(opened(elsewhere.root))] == []
    with planted() as computed:
        _, _, account = night(elsewhere.root, few)
    assert account["recalled"] == account["answers"] - len(computed) > 0
    elsewhere.send()
    there.fetch()
    assert len(opened(there.root).nights()) == 2


@pytest.fixture(scope="module")
def kept_nothing(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A history with one night of one engine, which kept no motion; it is only copied."""
    root = tmp_path_factory.mktemp("kept_nothing") / "h"
    with planted():
        night(root, asked(LOOK, engines=("mujoco",), keep="none"))
    return root


@pytest.mark.parametrize(
    ("keep", "stays"), [("all", True), ("changed", False), pytest.param("none", False, marks=pytest.mark.slow)]
)
def test_of_what_passed_as_before_the_hash_is_kept(
    keep: night_policy.Keep, stays: bool, kept_nothing: Path, tmp_path: Path
) -> None:
    """The adapter's source is another, its answers are the same: they are computed, and none is news."""
    root = Path(shutil.copytree(kept_nothing, tmp_path / "h"))
    with planted(Fault(engine="mujoco")):
        last, _, _ = night(root, asked(LOOK, engines=("mujoco",), keep=keep))
    records = read_journal(last.folder / "journal.jsonl").values()
    assert {record.trajectory_kept for record in records if record.status == "passed"} == {stays}
    kept = {record.trajectory_hash for record in records if record.trajectory_kept}
    assert {path.stem for path in Pool(opened(root).pool).trajectories()} == kept
    assert {path.stem for path in (last.folder / "trajectories").glob("*.npz")} == kept
    assert [*problems_of(opened(root))] == []


def test_what_is_computed_again_lies_on_the_disk_once(root: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    drawn(monkeypatch, 1.0)
    few = asked(LOOK, keep="all")
    with planted() as computed:
        _, _, first = night(root, few)
        last, _, account = night(root, few)
    assert len(computed) == 2 * account["answers"] == 2 * account["again"]
    pool = Pool(opened(root).pool)
    paths = sorted((last.folder / "trajectories").glob("*.npz"))
    assert paths
    assert all(path.samefile(pool.trajectory_path(path.stem)) for path in paths)
    assert account["bytes"]["pool"] == first["bytes"]["pool"] > sum(path.stat().st_size for path in paths)
    assert account["bytes"]["trajectories"] == 0
    assert 0 < account["bytes"]["night"] < bytes_of([last.folder])
    # A night that goes takes nothing along that stays under another name.
    assert bytes_of([last.folder, pool.folder], shared=False) < bytes_of([last.folder, pool.folder])
    assert bytes_of([root], shared=False) == bytes_of([root])


def test_old_nights_go_and_answers_that_no_night_names_but_not_the_last_that_saw_something(root: Path) -> None:
    with planted(Fault(engine="reference")):
        night(root)
    with planted(Fault(engine="reference")):
        night(root, asked(LOOK))
    history = opened(root)
    what = pruning(history, keep_nights=1)
    assert what.nights == history.nights()[:1]
    assert what.standing == history.nights()[1:2]
    assert len(what.answers) == CELLS // 2
    assert what.bytes > 0
    assert len([*Pool(history.pool).answers()]) == CELLS + CELLS // 2
    prune(what)
    assert len(history.nights()) == 2
    assert len([*Pool(history.pool).answers()]) == CELLS
    assert [*problems_of(history)] == []


def stricter(case: Case) -> Case:
    """Half of every bound, and one more thing that is looked at."""
    checks = tuple(replace(check, at_most=0.5 * check.bound(case.dt, case.parameters)) for check in case.checks)
    return replace(case, checks=checks, observe=(*case.observe, replace(position_error_max, name="another")))


def judgements(night: Night) -> str:
    """What was said of each answer, whichever trial simulated it, and when."""
    store = night.store()
    trials = store.trials.drop(columns=["simulated_as", "recalled", *(c for c in store.trials if "cpu" in c or "wall" in c)])
    trials = trials.drop(columns=["realtime_factor"])
    return trials.to_csv() + store.measurements.to_csv()


def test_an_edited_bound_and_metric_are_judged_on_what_is_kept_and_nothing_is_simulated(
    root: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    drawn(monkeypatch, 0.0)
    with planted(judges=stricter) as computed:
        last, _, _ = night(root, asked(LOOK))
        assert computed == []
        fresh, _, _ = night(tmp_path / "fresh", asked(LOOK))
    before = opened(root).nights()[0].store().trials
    assert set(last.store().trials["simulated_as"]) == set(before["trial"][before["experiment"] == "look"])
    assert judgements(last) == judgements(fresh)
    assert "another" in set(last.store().measurements["metric"])
    assert [*problems_of(opened(root))] == []


def test_where_no_motion_was_kept_an_edit_of_what_judges_is_simulated(kept_nothing: Path, tmp_path: Path) -> None:
    root = Path(shutil.copytree(kept_nothing, tmp_path / "h"))
    with planted(judges=stricter) as computed:
        last, _, _ = night(root, asked(LOOK, engines=("mujoco",)))
    assert computed
    assert set(computed) == set(last.store().trials["trial"])
    assert set(last.store().trials["simulated_as"]) == {""}


def test_a_damaged_answer_is_named_and_computed_again(root: Path) -> None:
    damaged = next(Pool(opened(root).pool).answers())
    damaged.write_bytes(damaged.read_bytes().replace(b"passed", b"failed").replace(b"every", b"some "))
    assert [problem.path for problem in problems_of(opened(root))] == [damaged]
    with planted() as computed:
        night(root)
    assert damaged.stem in computed
    assert [*problems_of(opened(root))] == []


def test_the_nights_are_listed(first_night: Path) -> None:
    (row,), _ = rows(opened(first_night))
    assert tuple(row) == COLUMNS
    assert (row["state"], row["answers"], row["computed"], row["clocked"]) == ("whole", CELLS, CELLS, CELLS)
    assert "mujoco" in row["versions"]


def test_a_history_of_this_schema_is_read_by_its_successors(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, printed: Command
) -> None:
    """`tests/unit/history_1` was written by the first version that had histories; its sources are others by now."""
    light(monkeypatch)
    root = Path(shutil.copytree(Path(__file__).parent / "history_1", tmp_path / "h"))
    (row,), _ = rows(opened(root))
    assert (row["night"], row["state"], row["answers"], row["clocked"]) == ("20261124T135557Z", "whole", 2, 2)
    assert [Pool(opened(root).pool).answer(path.stem) for path in Pool(opened(root).pool).answers()].count(None) == 0
    old = opened(root).nights()[0]
    assert printed("show", old.folder, "--format", "json").returncode == 0
    _, news, account = night(root, asked(LIGHT, engines=("sound",)))
    assert account["answers"] == 2
    assert news is not None
    assert news.changes.matched == 2
