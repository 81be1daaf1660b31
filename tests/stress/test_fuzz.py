"""Mutants of sound files: each is read or refused, by name, soon, in little memory, and never with a traceback."""

import json
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

from tests.stress.ledger import Page

ROOT = Path(__file__).parents[2]
SOUND = sorted((Path(__file__).parent / "sound_files").iterdir())
MOST_MEMORY = 300.0
"""MB that a process may grow to by reading mutants, all that it imports included."""


def read_mutants(sound: Path, count: int, budget: float) -> dict[str, Any]:
    command = [sys.executable, "-m", "tests.stress.fuzz_child", str(sound), "0", str(count), str(budget)]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, timeout=3600, check=False)
    assert done.returncode == 0, done.stderr[-2000:]
    found: dict[str, Any] = json.loads(done.stdout.splitlines()[-1])
    return found


def judge(sound: Path, found: dict[str, Any], ledger: Page) -> None:
    assert not found["troubles"], f"{sound.name}: {found['troubles'][:5]} of {len(found['troubles'])}"
    assert found["peak"] < MOST_MEMORY
    assert found["refused"]
    figure = f"{found['refused']} refused, {found['accepted']} read, slowest {found['slowest']:.2f} s, {found['peak']:.0f} MB"
    ledger.survived("fuzz", f"{found['tried']} mutants of {sound.name}", figure)


@pytest.mark.parametrize("sound", SOUND[:: len(SOUND) // 2], ids=lambda path: path.name)
def test_some_mutants_of_sound_files_are_read_or_refused(sound: Path, ledger: Page) -> None:
    found = read_mutants(sound, 60, 5.0)
    judge(sound, found, ledger)


@pytest.mark.slow
@pytest.mark.timeout(3600)
@pytest.mark.parametrize("sound", SOUND, ids=lambda path: path.name)
def test_two_thousand_mutants_of_each_sound_file_are_read_or_refused(sound: Path, ledger: Page) -> None:
    found = read_mutants(sound, 2000, 1200.0)
    judge(sound, found, ledger)
    assert found["tried"] == 2000
