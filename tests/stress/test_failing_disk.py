"""Every call of the store fails once, or the power goes there: the folder opens, says what is missing, and is completed."""

import random
import shutil
import subprocess
import sys
from collections.abc import Iterator, Sequence
from pathlib import Path

import pytest

from plumbline.harness.run import campaign, child
from plumbline.harness.run.verify import problems
from plumbline.harness.store import disk
from plumbline.harness.store.journal import Journal, StoreError
from plumbline.harness.store.record import Record
from plumbline.harness.store.store import Store
from plumbline.harness.study.trial import Trial
from tests.stress.failing_disk import ERRORS, Counting, Failing, Losing, PowerCut
from tests.stress.ledger import Page
from tests.stress.light_run import carry_out, light, same_tables, tables

TRIALS = 2
"""Of the light study."""
Whole = tuple[dict[str, bytes], list[str]]
FAULTS = [(error, stays) for stays in (False, True) for error in ERRORS]


@pytest.fixture(autouse=True)
def _light(monkeypatch: pytest.MonkeyPatch) -> None:
    light(monkeypatch)


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> Whole:
    """The tables of an undisturbed run, and its calls."""
    counting, folder = Counting(), tmp_path_factory.mktemp("whole") / "undisturbed"
    with pytest.MonkeyPatch.context() as patch, Using(counting):
        light(patch)
        carry_out(folder)
    assert [*problems(folder)] == []
    return tables(folder), counting.seen


class Using:
    """Other calls for the store, for the time of a block."""

    def __init__(self, calls: disk.Calls) -> None:
        self.calls = calls

    def __enter__(self) -> None:
        disk.calls = self.calls

    def __exit__(self, *_: object) -> None:
        disk.calls = disk.Calls()


def completed(folder: Path, expected: dict[str, bytes], broke: bool) -> int:
    """Open, verify and go on. Returns: how many problems `verify` named."""
    named = 0
    if (folder / "journal.jsonl").is_file():
        kept = len(Store(folder).trials)
        found = [str(problem) for problem in problems(folder)]
        named = len(found)
        if broke and not found:  # the last thing that a run does may be done when it fails
            same_tables(folder, expected)
        lines = (folder / "journal.jsonl").read_bytes().count(b"\n")
        if lines > 0 and kept < TRIALS:
            assert any(f"{TRIALS - kept} of {TRIALS} trials have no record" in sentence for sentence in found)
    carry_out(folder)
    same_tables(folder, expected)
    assert [*problems(folder)] == []
    return named


def numbers(calls: list[str], every: int) -> Iterator[int]:
    """The numbers of the calls that are to fail: all kinds of call, and of each every so many."""
    seen: dict[str, int] = {}
    for number, name in enumerate(calls, start=1):
        seen[name] = seen.get(name, 0) + 1
        if seen[name] % every == 1 % every:
            yield number


def let_fail(tmp_path: Path, whole: Whole, every: int, ledger: Page) -> None:
    """Each call with all faults; where not every call fails, with one: an allocation lacks memory, a write meets a bad disk."""
    expected, calls = whole
    for place, number in enumerate(numbers(calls, every)):
        for error, stays in FAULTS if every == 1 else (FAULTS[(place - 1) % len(FAULTS)],):
            folder = tmp_path / "failing"
            failing, broke = Failing(number, error, stays), False
            with Using(failing):
                try:
                    carry_out(folder)
                except (OSError, StoreError, MemoryError):
                    broke = True
            assert failing.met == calls[number - 1], "the run is the same up to the fault"
            named = completed(folder, expected, broke)
            mode = "and all behind it" if stays else "alone"
            ledger.survived("store call fails", f"{error} at call {number} ({failing.met}) {mode}", f"{named} problems named")
            shutil.rmtree(folder)


def test_a_call_of_each_kind_fails(tmp_path: Path, whole: Whole, ledger: Page) -> None:
    let_fail(tmp_path, whole, 40, ledger)


@pytest.mark.slow
@pytest.mark.timeout(3600)
def test_every_call_fails(tmp_path: Path, whole: Whole, ledger: Page) -> None:
    let_fail(tmp_path, whole, 1, ledger)


def cut_power(
    tmp_path: Path,
    whole: Whole,
    every: int,
    ledger: Page,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """At each call in both ways; where not at every one, in one way and the other in turn."""
    expected, calls = whole
    acknowledged: list[str] = []
    plain = Journal.append

    def noted(self: Journal, entry: object) -> None:
        plain(self, entry)  # type: ignore[arg-type]
        acknowledged.append(entry.trial)  # type: ignore[attr-defined]

    monkeypatch.setattr(Journal, "append", noted)
    chance = random.Random(5)
    for names_first in (False, True):
        first, apart = (0, 1) if every == 1 else (every * names_first, 2 * every)
        for number in range(first, len(calls), apart):
            folder = tmp_path / "lost"
            acknowledged.clear()
            losing = Losing(number, folder, names_first)
            with Using(losing), pytest.raises(PowerCut):
                carry_out(folder)
            losing.settle(chance)
            safe = set(acknowledged)
            if safe:
                assert safe <= set(Store(folder).trials["trial"]), "what was written through is lost"
            named = completed(folder, expected, broke=True)
            order = "names reach the disk first" if names_first else "names are undone"
            ledger.survived("power cut", f"at call {number + 1} ({calls[number]}), {order}", f"{named} problems named, 0 lost")
            shutil.rmtree(folder)


def test_the_power_goes_at_some_calls(tmp_path: Path, whole: Whole, ledger: Page, monkeypatch: pytest.MonkeyPatch) -> None:
    cut_power(tmp_path, whole, 29, ledger, monkeypatch)


@pytest.mark.slow
@pytest.mark.timeout(3600)
def test_the_power_goes_at_every_call(tmp_path: Path, whole: Whole, ledger: Page, monkeypatch: pytest.MonkeyPatch) -> None:
    cut_power(tmp_path, whole, 1, ledger, monkeypatch)


def test_a_disk_that_forgets_what_is_not_synchronised_shows_a_store_that_does_not_synchronise(
    tmp_path: Path, whole: Whole, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The model is no good unless it finds the fault that it is made for."""
    monkeypatch.setattr(disk.Appended, "append", lambda self, piece: disk._write(self.descriptor, piece))
    folder = tmp_path / "careless"
    losing = Losing(len(whole[1]) // 2, folder, names_first=False)
    with Using(losing), pytest.raises(PowerCut):
        carry_out(folder)
    shown = (folder / "journal.jsonl").stat().st_size
    losing.settle(random.Random(0))
    assert (folder / "journal.jsonl").stat().st_size < shown


def starve(folder: Path, every: int, ledger: Page) -> None:
    pytest.importorskip("_testcapi", reason="this Python was built without its test modules")
    command = [sys.executable, "-m", "tests.stress.starved", folder, every]
    done = subprocess.run([*map(str, command)], capture_output=True, text=True, check=False, timeout=280)
    assert done.returncode == 0, done.stderr[-2000:]
    allocations, failed = map(int, done.stdout.split())
    assert failed > allocations // every // 2
    which = "each allocation" if every == 1 else f"every {every}th allocation"
    ledger.survived("memory ends", f"at {which} of an append", f"{failed} of {allocations} raised, 0 lines lost or doubled")


def test_memory_ends_at_some_allocations_of_an_append(tmp_path: Path, ledger: Page) -> None:
    starve(tmp_path, 29, ledger)


@pytest.mark.slow
def test_memory_ends_at_every_allocation_of_an_append(tmp_path: Path, ledger: Page) -> None:
    starve(tmp_path, 1, ledger)


@pytest.mark.parametrize("error", ["ENOSPC", "EIO"])
def test_an_answer_that_cannot_be_kept_is_no_crash_of_its_engine(
    error: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, ledger: Page
) -> None:
    """In the child: the trial stays open, the run ends with what the machine said, and a resume runs it."""
    plain = disk.write_atomically

    def refuse(path: Path, content: bytes) -> None:
        if path.suffix == ".npz":
            raise ERRORS[error]()
        plain(path, content)

    def isolated(trials: Sequence[Trial], folder: Path, _workers: int) -> Iterator[Record]:
        for trial in trials:
            yield from (answer for answer in child.answers(trial, folder) if answer is not None)

    folder = tmp_path / "run"
    with monkeypatch.context() as patch:
        patch.setattr(campaign, "run_isolated", isolated)
        patch.setattr(disk, "write_atomically", refuse)
        with pytest.raises(StoreError, match=r"2 of 2 answers could not be kept, first: .*\.npz: not written"):
            carry_out(folder)
    assert len(Store(folder).trials) == 0
    assert any("2 of 2 trials have no record; --resume runs them" in str(problem) for problem in problems(folder))
    assert set(carry_out(folder).trials["status"]) == {"passed"}
    ledger.survived("store call fails", f"{error} while a child keeps its trajectory", "engines blamed 0; completed")
