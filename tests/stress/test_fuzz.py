"""Mutants of sound files: each is read or refused, by name, soon, in little memory, and never with a traceback."""

import json
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import pytest

from tests.stress.ledger import Page

ROOT = Path(__file__).parents[2]
SOUND = sorted((Path(__file__).parent / "sound_files").iterdir())
MOST_MEMORY = 300.0
"""MB that a process may grow to by reading mutants, all that it imports included."""


def read_mutants(sound: Sequence[Path], count: int, budget: float) -> dict[Path, dict[str, Any]]:
    """What became of so many mutants of each, all in one process."""
    command = [sys.executable, "-m", "tests.stress.fuzz_child", "0", str(count), str(budget), *map(str, sound)]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, timeout=3600, check=False)
    assert done.returncode == 0, done.stderr[-2000:]
    return dict(zip(sound, map(json.loads, done.stdout.splitlines()[-len(sound) :]), strict=True))


def judge(sound: Path, found: dict[str, Any], ledger: Page) -> None:
    assert not found["troubles"], f"{sound.name}: {found['troubles'][:5]} of {len(found['troubles'])}"
    assert found["peak"] < MOST_MEMORY
    assert found["refused"]
    figure = f"{found['refused']} refused, {found['accepted']} read, slowest {found['slowest']:.2f} s, {found['peak']:.0f} MB"
    ledger.survived("fuzz", f"{found['tried']} mutants of {sound.name}", figure)


FEW = SOUND[:: len(SOUND) // 2]


@pytest.fixture(scope="module")
def few() -> dict[Path, dict[str, Any]]:
    return read_mutants(FEW, 20, 5.0)


@pytest.mark.parametrize("sound", FEW, ids=lambda path: path.name)
def test_some_mutants_of_sound_files_are_read_or_refused(sound: Path, few: dict[Path, dict[str, Any]], ledger: Page) -> None:
    judge(sound, few[sound], ledger)


@pytest.mark.slow
@pytest.mark.timeout(3600)
@pytest.mark.parametrize("sound", SOUND, ids=lambda path: path.name)
def test_two_thousand_mutants_of_each_sound_file_are_read_or_refused(sound: Path, ledger: Page) -> None:
    found = read_mutants([sound], 2000, 1200.0)[sound]
    judge(sound, found, ledger)
    assert found["tried"] == 2000
