"""Every file of a run folder flipped, cut, emptied, exchanged or gone: `verify` names it, --resume mends what can be mended."""

import random
import shutil
from collections.abc import Iterator, Mapping
from itertools import islice
from pathlib import Path

import pytest

from plumbline.harness.run.verify import problems
from plumbline.harness.store.journal import StoreError
from plumbline.harness.store.store import Store
from plumbline.reports.html import report as html
from tests.conftest import Command
from tests.stress.ledger import Page
from tests.stress.light_run import carry_out, light, same_tables, tables

FAMILY = "stored file damaged"
SHOWN = {"report", "recordings", "logs"}


@pytest.fixture(autouse=True)
def _light(monkeypatch: pytest.MonkeyPatch) -> None:
    light(monkeypatch)


@pytest.fixture(scope="module")
def carried_out(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A whole run folder, with truths that count as slow."""
    folder = tmp_path_factory.mktemp("whole") / "run"
    with pytest.MonkeyPatch.context() as patch:
        light(patch)
        patch.setattr("plumbline.harness.trial.truth_cache.LONG", -1.0)
        carry_out(folder)
    assert [*problems(folder)] == []
    return folder


@pytest.fixture
def run(carried_out: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A copy of it, to be damaged."""
    monkeypatch.setattr("plumbline.harness.trial.truth_cache.LONG", -1.0)
    shutil.copytree(carried_out, tmp_path / "run")
    return tmp_path / "run"


def files(folder: Path) -> list[Path]:
    found = sorted(path for path in folder.rglob("*") if path.is_file() and path.relative_to(folder).parts[0] not in SHOWN)
    kinds = {path.relative_to(folder).parts[0] for path in found}
    assert {"journal.jsonl", "truths", "trajectories", "catalogue.json", "machine.json", "study.toml"} <= kinds
    return found


def damages(path: Path, others: Mapping[Path, bytes], flips: int, chance: random.Random) -> Iterator[tuple[str, bytes | None]]:
    """What may become of a file's bytes; None for a file that is gone."""
    whole = path.read_bytes()
    for _ in range(flips):
        place, bit = chance.randrange(len(whole)), chance.randrange(8)
        yield "a bit flipped", whole[:place] + bytes([whole[place] ^ 1 << bit]) + whole[place + 1 :]
    yield "cut short", whole[: chance.randrange(len(whole))]
    yield "emptied", b""
    yield "its first half twice", whole[: len(whole) // 2] + whole
    yield "gone", None
    swapped = next((content for other, content in others.items() if other.suffix == path.suffix and content != whole), None)
    if swapped is not None:
        yield "exchanged with another", swapped


def named(folder: Path, path: Path, to_the_end: bool = True) -> str:
    """The problem that names a file, in words. Raises: AssertionError, where none does.

    Args: to_the_end: go on behind it, with what else is checked.
    """
    found = (problem for problem in problems(folder) if problem.path == path)
    first = next(found, None)
    assert first, f"{path}: unnoticed"
    if to_the_end:
        list(found)
    return str(first)


def damage_all(folder: Path, flips: int, ledger: Page, every: int = 1) -> None:
    """Args: every: of each file every so many damages, one after the other in turn."""
    chance = random.Random(3)
    kept = {path: path.read_bytes() for path in files(folder)}
    for number, (path, whole) in enumerate(kept.items()):
        counts: dict[str, int] = {}
        for what, content in islice(damages(path, kept, flips, chance), number % every, None, every):
            if what == "gone" and path.parent.name == "truths":
                continue  # a truth is kept to save time: that it is not there is no damage
            path.unlink() if content is None else path.write_bytes(content)
            said = named(folder, path, to_the_end=not counts)
            assert "\n" not in said
            assert "; " in said, "it says what to do"
            counts[what] = counts.get(what, 0) + 1
            path.write_bytes(whole)
        name = path.relative_to(folder).as_posix() if path.parent == folder else f"{path.parent.name}/*{path.suffix}"
        for what, count in counts.items():
            ledger.survived(FAMILY, f"{name} {what}", f"named {count} of {count}")
    assert [*problems(folder)] == []


def test_verify_names_every_damaged_file(run: Path, ledger: Page) -> None:
    damage_all(run, 1, ledger, every=3)


@pytest.mark.slow
@pytest.mark.timeout(3600)
def test_verify_names_every_file_with_a_bit_flipped_at_two_hundred_places(run: Path, ledger: Page) -> None:
    damage_all(run, 200, ledger)


@pytest.mark.parametrize("every", [2, pytest.param(1, marks=pytest.mark.slow)])
@pytest.mark.parametrize("how", ["flipped", "gone"])
def test_resuming_mends_what_can_be_made_again_and_blames_no_engine(
    how: str, every: int, run: Path, ledger: Page, capsys: pytest.CaptureFixture[str]
) -> None:
    """Every file, or one half of them flipped and the other gone."""
    expected = tables(run)
    for path in [path for path in files(run) if path.name != "journal.jsonl"][(how == "gone") % every :: every]:
        whole = path.read_bytes()
        path.unlink() if how == "gone" else path.write_bytes(whole[:-40] + bytes([whole[-40] ^ 1]) + whole[-39:])
        store = carry_out(run)
        assert set(store.trials["status"]) == {"passed"}
        same_tables(run, expected)
        if path.parent.name == "trajectories":
            found = f"runs anew 2: {path} is {'missing' if how == 'gone' else 'damaged'}"
            assert found in capsys.readouterr().err, "both tracks gave this answer"
            assert path.read_bytes() == whole, "bit for bit"
        assert [*problems(run)] == []
        where = f"{path.parent.name}/*{path.suffix}" if path.parent != run else path.name
        ledger.survived(FAMILY, f"{where} {how}, then a resume", "mended; engines blamed 0")


def test_a_truth_that_is_damaged_while_a_run_goes_on_is_made_again(
    run: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], ledger: Page
) -> None:
    """The same trials in another folder, whose truths are damaged before they are wanted."""
    other = run.with_name("other")
    shutil.copytree(run / "truths", other / "truths")
    kept = {path: path.read_bytes() for path in sorted((other / "truths").iterdir())}
    assert kept
    for path, whole in kept.items():
        path.write_bytes(whole[:100] + bytes([whole[100] ^ 1]) + whole[101:])
    expected = tables(run)
    monkeypatch.setattr("plumbline.harness.run.resume._mended_truths", lambda _folder: [])
    carry_out(other)
    same_tables(other, expected)
    said = capsys.readouterr().err
    for path, whole in kept.items():
        assert f"{path}: its content is not what was written" in said
        assert path.read_bytes() == whole
    ledger.survived(FAMILY, "truths damaged under a run", f"{len(kept)} named and made again; engines blamed 0")


def test_lines_lost_at_the_end_of_a_journal_are_told_by_whoever_reads_it(run: Path, printed: Command, ledger: Page) -> None:
    expected = tables(run)
    path = run / "journal.jsonl"
    lines = path.read_bytes().splitlines(keepends=True)
    path.write_bytes(b"".join(lines[:-3]))
    due = f"{path}: ends at line {len(lines) - 3}, and had {len(lines)}: what the others held is missing"
    assert Store(run).notes == (due,)
    assert due in printed("show", run).stderr
    assert "ends at line" in named(run, path)
    carry_out(run)
    same_tables(run, expected)
    assert [*problems(run)] == []
    ledger.survived(FAMILY, "journal.jsonl without its last three lines", "named by show, verify and resume; mended")


def test_a_torn_tail_is_told_by_whoever_reads_it(
    run: Path, printed: Command, monkeypatch: pytest.MonkeyPatch, ledger: Page
) -> None:
    monkeypatch.setattr(html, "pages", tuple)  # that there is a report at all reads the journal
    path = run / "journal.jsonl"
    path.write_bytes(path.read_bytes()[:-7])
    for command in ("show", "report"):
        assert "the last, is torn, as a kill leaves it" in printed(command, run).stderr
    assert "its last line is torn" in named(run, path)
    ledger.survived(FAMILY, "journal.jsonl with a torn tail", "told by show, report and verify")


def test_a_damaged_trajectory_is_named_to_whoever_reads_it(run: Path, ledger: Page) -> None:
    path = next((run / "trajectories").iterdir())
    whole = path.read_bytes()
    path.write_bytes(whole[:300] + bytes([whole[300] ^ 1]) + whole[301:])
    with pytest.raises(StoreError, match=f"{path.name}: not readable: .*checksum differs.*--resume makes it anew"):
        Store(run).trajectory(path.stem, ["time"])
    ledger.survived(FAMILY, "a trajectory damaged under a reader", "named before it is read")


def test_strangers_in_a_folder_are_named(run: Path) -> None:
    for name in ("notes.txt", ".machine.json.99", "trajectories/0123456789abcdef.npz", "truths/mine.npz", "logs/none.log"):
        path = run / name
        path.parent.mkdir(exist_ok=True)
        path.write_bytes(b"x")
        assert "delete it" in named(run, path)
        path.unlink()


def test_drafts_that_a_kill_left_are_named_and_cleared_by_a_resume(run: Path) -> None:
    drafts = [run / name for name in (".trials.parquet.7", "truths/.a.npz.7", ".timing-abc.log", ".report.7/index.html")]
    for path in drafts:
        path.parent.mkdir(exist_ok=True)
        path.write_bytes(b"half")
    assert len([*problems(run)]) == len(drafts)
    carry_out(run)
    assert [*problems(run)] == []
    assert not any(path.exists() for path in drafts)


def test_verify_ends_well_or_with_a_machine_that_failed(run: Path, printed: Command) -> None:
    whole = printed("verify", run)
    assert (whole.returncode, whole.stdout, whole.stderr) == (0, "", "every file is as it was written\n")
    (run / "machine.json").unlink()
    (run / "trials.parquet").write_bytes(b"x")
    broken = printed("verify", run)
    assert broken.returncode == 3
    assert broken.stdout.splitlines() == [
        f"{run / 'machine.json'}: missing; --resume makes it anew",
        f"{run / 'trials.parquet'}: differs from the journal; --resume makes it anew",
    ]
