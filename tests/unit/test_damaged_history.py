"""Histories that would stop a night: damaged files, names that are no dates, what is no file; it names them and goes on."""

import json
import os
import shutil
import time
from collections.abc import Callable
from pathlib import Path

import pytest

from plumbline.harness.findings.summary import summaries
from plumbline.harness.history.folder import History, Pool, opened
from plumbline.harness.history.regressions import read_trends
from plumbline.harness.history.retention import problems_of, prune, pruning
from plumbline.harness.run import verify
from plumbline.harness.store import disk
from plumbline.harness.store.journal import Journal
from plumbline.harness.store.seal import sealed_json
from plumbline.harness.store.store import Store, read_plain
from tests.conftest import Command
from tests.nights import planted
from tests.unit.test_history_news import FILE


@pytest.fixture
def words(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> list[str | Path]:
    """A night of four answers of one engine, in h."""
    monkeypatch.setattr("plumbline.harness.findings.vendor_findings.shelf", tuple)
    (tmp_path / "few.toml").write_text(FILE)
    return ["nightly", "--history", tmp_path / "h", "--study", tmp_path / "few.toml", "--engine", "mujoco", "--no-report"]


@pytest.fixture
def root(tmp_path: Path, words: list[str | Path], printed: Command) -> Path:
    """Two nights of it."""
    for _ in range(2):
        with planted():
            assert printed(*words).returncode == 0
    return tmp_path / "h"


def last(root: Path) -> Path:
    return sorted((root / "nights").iterdir())[-1]


def damage_plan(root: Path) -> Path:
    path = last(root) / "night.json"
    path.write_bytes(path.read_bytes().replace(b"complete", b"complote"))
    return path


def later_plan(root: Path) -> Path:
    path = last(root) / "night.json"
    path.write_bytes(sealed_json(path.name, {**read_plain(path), "schema": 99}))
    return path


def plan_is_fifo(root: Path) -> Path:
    path = last(root) / "night.json"
    path.unlink()
    os.mkfifo(path)
    return path


def journal_is_fifo(root: Path) -> Path:
    path = last(root) / "journal.jsonl"
    path.unlink()
    os.mkfifo(path)
    return path


def journal_is_folder(root: Path) -> Path:
    path = last(root) / "journal.jsonl"
    path.unlink()
    path.mkdir()
    return path


def damage_journal(root: Path) -> Path:
    path = last(root) / "journal.jsonl"
    lines = path.read_bytes().splitlines(keepends=True)
    path.write_bytes(b"".join([*lines[:2], lines[2].replace(b"mujoco", b"mujaco"), *lines[3:]]))
    return path


def year_9999(root: Path) -> Path:
    path = root / "nights" / "99991231T235959Z"
    shutil.copytree(last(root), path)
    return path


def month_13(root: Path) -> Path:
    path = root / "nights" / "20261301T000000Z"
    shutil.copytree(last(root), path)
    return path


def acknowledged_is_no_line(root: Path) -> Path:
    path = root / "acknowledged.jsonl"
    path.write_text("no line\n")
    return path


@pytest.mark.parametrize(
    "damage",
    [damage_plan, later_plan, plan_is_fifo, journal_is_fifo, journal_is_folder, damage_journal, year_9999, month_13,
     acknowledged_is_no_line],
)  # fmt: skip
def test_what_cannot_be_read_is_left_out_and_named_and_tonight_goes_on(
    damage: Callable[[Path], Path], root: Path, words: list[str | Path], printed: Command
) -> None:
    path = damage(root)
    with planted():
        done = printed(*words)
    assert done.returncode == 0, done.stderr
    assert f"left out: {path}" in done.stdout
    assert "nothing of it was seen before" not in done.stdout
    summary = Path(done.stdout.splitlines()[-1])
    assert f"Left out: {path}" in summary.read_text().replace("\\", "")
    if path.name != "acknowledged.jsonl":
        for command in (("history", root), ("history", "trends", root)):
            listed = printed(*command)
            assert listed.returncode == 0, listed.stderr
            assert f"left out: {path}" in listed.stderr or path.name == "journal.jsonl"
    assert path in {problem.path for problem in problems_of(opened(root))}


def test_an_unfinished_night_whose_records_are_damaged_is_not_gone_on_with(
    root: Path, words: list[str | Path], printed: Command
) -> None:
    path = last(root) / "night.json"
    path.write_bytes(sealed_json(path.name, {**read_plain(path), "complete": False}))
    damaged = damage_journal(root)
    with planted():
        done = printed(*words)
    assert done.returncode == 0, done.stderr
    assert last(root) != damaged.parent
    assert f"left out: {damaged}" in done.stdout


def of_later_schema(path: Path) -> None:
    path.write_bytes(sealed_json(path.name, {**read_plain(path), "record_schema": 99}))


def without_record(path: Path) -> None:
    path.write_bytes(sealed_json(path.name, {"schema": 1, "record_schema": 1}))


def is_folder(path: Path) -> None:
    path.unlink()
    path.mkdir()


@pytest.mark.parametrize("spoil", [of_later_schema, without_record, is_folder])
def test_an_answer_of_the_pool_that_cannot_be_read_is_named_and_computed_again(
    spoil: Callable[[Path], None], root: Path, words: list[str | Path], printed: Command
) -> None:
    path = next(Pool(opened(root).pool).answers())
    spoil(path)
    with planted() as computed:
        done = printed(*words)
    assert done.returncode == 0, done.stderr
    assert path.stem in computed
    assert str(path) in (last(root) / "night.log").read_text()


def test_a_history_that_can_only_be_read_is_read(root: Path, printed: Command, monkeypatch: pytest.MonkeyPatch) -> None:
    shutil.rmtree(root / "readings", ignore_errors=True)

    def refuse(*_: object) -> None:
        raise OSError(30, "Read-only file system", str(root))

    for name in ("make", "open", "rename"):
        monkeypatch.setattr(disk.calls, name, refuse)
    nights = [str(night.folder) for night in opened(root).nights()]
    assert printed("history", root, "--json").returncode == 0
    trends = printed("history", "trends", root)
    assert trends.returncode == 0, trends.stderr
    assert "2 nights; 0 regressions stand" in trends.stdout
    assert "the page was not written" in trends.stderr
    assert printed("diff", *nights, "--gate", "mujoco").returncode == 0
    assert len(read_trends(opened(root)).nights) == 2


def test_what_goes_of_a_history_is_never_behind_a_link(root: Path, tmp_path: Path, printed: Command) -> None:
    history = opened(root)
    outside = tmp_path / "outside"
    first = history.nights()[0].folder
    shutil.move(first, outside)
    first.symlink_to(outside)
    inside = pruning(history, keep_nights=1)
    assert inside.nights == ()
    assert inside.links == (first,)
    said = printed("history", root, "--prune", "--keep-nights", "1")
    assert f"stays: {first} lies elsewhere by a link" in said.stdout
    prune(inside)
    assert (outside / "journal.jsonl").is_file()


def test_who_is_notified_ends_with_the_budget_and_the_lock_is_not_held_meanwhile(
    root: Path, words: list[str | Path], printed: Command, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("plumbline.harness.cli.nightly_command._LEAST", 1.0)
    held = root.parent / "held"
    begun = time.monotonic()
    with planted():
        done = printed(*words, "--budget", "10", "--notify", f"flock -n {root}/lock echo free > {held}; sleep 600")
    assert time.monotonic() - begun < 120.0
    assert done.returncode == 0
    assert "--notify: ended after" in done.stderr
    assert held.read_text() == "free\n"


def test_summaries_are_made_again_only_where_they_are_not_what_their_night_wrote(
    root: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    made = []

    def counted(store: Store) -> dict[str, bytes]:
        made.append(store.folder)
        return summaries(store)

    monkeypatch.setattr(verify, "summaries", counted)
    assert not [*problems_of(opened(root))]
    assert not made
    path = last(root) / "summary.md"
    path.write_bytes(path.read_bytes() + b"more")
    assert [problem.path for problem in problems_of(opened(root))] == [path]
    assert made == [last(root)]


def test_a_table_of_nights_shows_the_last_ones_and_says_how_many_there_are(
    root: Path, printed: Command, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("plumbline.harness.cli.history_command._SHOWN", 1)
    done = printed("history", root)
    first, second = (night.stamp for night in opened(root).nights())
    assert (first[:8] in done.stdout, second[:8] in done.stdout) == (first[:8] == second[:8], True)
    assert done.stdout.splitlines()[-1] == "and 1 earlier nights; --json prints all 2"
    assert len(json.loads(printed("history", root, "--json").stdout)) == 2


def test_a_night_in_which_nothing_was_answered_stops_no_trends(root: Path) -> None:
    folder = root / "nights" / "20240101T013000Z"
    folder.mkdir()
    Journal(folder).close()
    for name in ("catalogue.json", "machine.json"):
        shutil.copy(last(root) / name, folder / name)
    trends = read_trends(opened(root))
    assert ([night.stamp for night in trends.nights][:1], len(trends.nights), trends.unread) == ([folder.name], 3, ())


def test_a_lock_that_is_no_file_is_named(root: Path, words: list[str | Path], printed: Command) -> None:
    (root / "lock").unlink(missing_ok=True)
    os.mkfifo(root / "lock")
    done = printed(*words)
    assert done.returncode == 3 or done.returncode == 2
    assert f"{root / 'lock'}: is no file; delete it" in done.stderr


def test_a_history_says_what_it_leaves_out(root: Path) -> None:
    path = month_13(root)
    assert [str(error) for error in History(root).unread()] == [f"{path}: has a name that is no date; rename or delete it"]
