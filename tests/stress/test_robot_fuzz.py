"""Mutants of robot files: each is read or refused by name, with no traceback, no hang and no read outside."""

import json
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

from tests.stress.ledger import Page

ROOT = Path(__file__).parents[2]
SOUND = sorted((Path(__file__).parent / "sound_robots").iterdir())


def read_mutants(sound: Path, count: int, note: Path) -> dict[str, Any]:
    """What became of `count` mutants; a process that dies goes on in another one behind the seed it died of."""
    totals: dict[str, Any] = {
        "refused": 0,
        "read": 0,
        "slowest": 0.0,
        "troubles": [],
        "tried": 0,
        "outside": [],
        "peak": 0.0,
        "died": [],
    }
    seed = 0
    while seed < count:
        # A crash costs the figures of its own batch alone.
        batch = min(500, count - seed)
        command = [sys.executable, "-m", "tests.stress.robot_fuzz_child", str(sound), str(seed), str(batch), str(note)]
        done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, timeout=3600, check=False)
        if done.returncode < 0 or done.returncode > 1:
            at = int(note.read_text())
            totals["died"].append((at, done.returncode))
            totals["tried"] += at + 1 - seed
            seed = at + 1
            continue
        assert done.returncode == 0, done.stderr[-2000:]
        found = json.loads(done.stdout.splitlines()[-1])
        for name in ("refused", "read", "tried"):
            totals[name] += found[name]
        for name in ("troubles", "outside"):
            totals[name] += found[name]
        for name in ("slowest", "peak"):
            totals[name] = max(totals[name], found[name])
        seed += batch
    return totals


def judge(sound: Path, found: dict[str, Any], ledger: Page) -> None:
    assert not found["troubles"], f"{sound.name}: {found['troubles'][:5]} of {len(found['troubles'])}"
    assert not found["outside"]
    assert found["refused"]
    if sound.suffix == ".urdf":
        assert not found["died"]
    died = f", the compiler died {len(found['died'])} times" if sound.suffix == ".xml" else ""
    figure = f"{found['refused']} refused, {found['read']} read, slowest {found['slowest']:.2f} s, {found['peak']:.0f} MB{died}"
    ledger.survived("robot fuzz", f"{found['tried']} mutants of {sound.name}", figure)


@pytest.mark.parametrize("sound", SOUND, ids=lambda path: path.name)
def test_some_mutants_of_robots_are_read_or_refused(sound: Path, ledger: Page, tmp_path: Path) -> None:
    judge(sound, read_mutants(sound, 20, tmp_path / "seed"), ledger)


@pytest.mark.slow
@pytest.mark.timeout(3600)
@pytest.mark.parametrize("sound", SOUND, ids=lambda path: path.name)
def test_five_thousand_mutants_of_robots_are_read_or_refused(sound: Path, ledger: Page, tmp_path: Path) -> None:
    found = read_mutants(sound, 5000, tmp_path / "seed")
    judge(sound, found, ledger)
    assert found["tried"] == 5000
