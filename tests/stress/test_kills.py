"""Random SIGKILLs of the parent of a run that is resumed after each: nothing that was written is lost, nothing stands twice."""

import json
import os
import random
import signal
import subprocess
import sys
import time
from collections.abc import Iterator, Mapping
from contextlib import suppress
from pathlib import Path
from threading import Thread
from typing import IO

import pytest

from plumbline.harness.run.verify import problems
from plumbline.harness.store.journal import read_written
from plumbline.harness.store.store import Store
from tests.stress.ledger import Page
from tests.stress.test_interruption import write_study

LONGEST = 60.0
MACHINE = 3
HELD = "another run writes to this folder"
"""A child that was forked the instant before its parent was killed has the journal open until its trial ends. Those of a real
run come off a fork server, and have not."""


class Mother:
    """Our end of `tests.stress.mother`."""

    def __init__(self, process: "subprocess.Popen[str]") -> None:
        assert process.stdin is not None
        assert process.stdout is not None
        self._told: IO[str] = process.stdin
        self._says: IO[str] = process.stdout

    def start(self, study: Path, out: Path) -> int:
        arguments = ["run", str(study), "--engine", "sound", "--out", str(out), "--resume"]
        self._told.write(json.dumps({"arguments": arguments, "log": str(out.with_suffix(".log"))}) + "\n")
        self._told.flush()
        return int(self._says.readline())

    def ended(self) -> int:
        return int(self._says.readline())


@pytest.fixture(scope="module")
def mother(with_plugins: Mapping[str, str]) -> Iterator[Mother]:
    here = Path(__file__).parents[2]
    paths = os.pathsep.join((with_plugins["PYTHONPATH"], str(here)))
    process = subprocess.Popen(
        [sys.executable, "-m", "tests.stress.mother"],
        env=dict(with_plugins) | {"PYTHONPATH": paths},
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
    )
    try:
        yield Mother(process)
    finally:
        process.kill()
        process.communicate()


def size(path: Path) -> int:
    return path.stat().st_size if path.is_file() else 0


def kill_somewhere(pid: int, journal: Path, chance: random.Random) -> None:
    """Kill it after a time, or a little after its journal has grown by some bytes; it may have ended by then."""
    until = time.monotonic() + (chance.uniform(0.0, 1.5) if chance.random() < 0.25 else LONGEST)
    grown = size(journal) + chance.choice((1, 1, 3000, 6000, 20_000))
    while time.monotonic() < until and size(journal) < grown and Path(f"/proc/{pid}").exists():
        time.sleep(0.0005)
    time.sleep(chance.choice((0.0, chance.uniform(0.0, 0.02), chance.uniform(0.0, 0.2))))
    with suppress(ProcessLookupError):
        os.kill(pid, signal.SIGKILL)


def kills(count: int, folder: Path, mother: Mother, expected: Mapping[str, str], seed: int = 2) -> dict[str, int]:
    """Kill a run and resume it, so many times, in a new folder whenever one is complete.

    Returns: how many kills hit, folders completed, torn lines met, trials lost.
    """
    chance, found = random.Random(seed), {"kills": 0, "completed": 0, "torn": 0, "lost": 0}
    study = write_study(folder)
    while found["kills"] < count:
        out = folder / str(found["completed"])
        safe: set[str] = set()
        while not complete(out, expected):
            pid = mother.start(study, out)
            killer = Thread(target=kill_somewhere, args=(pid, out / "journal.jsonl", chance))
            if found["kills"] < count:
                killer.start()
            code = mother.ended()
            if killer.ident is not None:
                killer.join()
            if code == MACHINE and HELD in out.with_suffix(".log").read_text().splitlines()[-1]:
                time.sleep(0.05)
                continue
            assert code in (0, -signal.SIGKILL), out.with_suffix(".log").read_text()
            found["kills"] += code == -signal.SIGKILL
            written = read_written(out / "journal.jsonl")  # raises where a line is doubled, missing or damaged
            found["lost"] += len(safe - written.records.keys())
            safe = {*written.records}
            found["torn"] += written.torn > 0
        found["completed"] += 1
    return found


def complete(out: Path, expected: Mapping[str, str]) -> bool:
    """Is the run whole? Then it has to be the undisturbed one."""
    if not (out / "summary.md").is_file():
        return False
    if [*problems(out)]:
        return False
    trials = Store(out).trials
    assert trials["trial"].is_unique
    assert dict(zip(trials["trial"], trials["trajectory_hash"], strict=True)) == expected
    return True


@pytest.fixture(scope="module")
def undisturbed(tmp_path_factory: pytest.TempPathFactory, mother: Mother) -> dict[str, str]:
    folder = tmp_path_factory.mktemp("undisturbed")
    mother.start(write_study(folder), folder / "out")
    assert mother.ended() == 0
    trials = Store(folder / "out").trials
    return dict(zip(trials["trial"], trials["trajectory_hash"], strict=True))


def tell(found: Mapping[str, int], ledger: Page) -> None:
    figure = f"lost {found['lost']}, doubled 0, {found['completed']} runs completed, {found['torn']} torn lines"
    ledger.survived("SIGKILL of the parent", f"{found['kills']} kills, each followed by a resume", figure)
    assert found["lost"] == 0


def test_two_kills_lose_and_double_nothing(tmp_path: Path, mother: Mother, undisturbed: dict[str, str], ledger: Page) -> None:
    tell(kills(2, tmp_path, mother, undisturbed), ledger)


@pytest.mark.slow
@pytest.mark.timeout(7200)
def test_five_hundred_kills_lose_and_double_nothing(
    tmp_path: Path, mother: Mother, undisturbed: dict[str, str], ledger: Page
) -> None:
    tell(kills(500, tmp_path, mother, undisturbed), ledger)
