"""A night whose process is killed again and again, with an engine that hangs in it: it goes on as the same night."""

import os
import re
import signal
import subprocess
import sys
import time
from collections.abc import Mapping
from pathlib import Path

import pytest

from plumbline.harness.history.folder import opened
from plumbline.harness.history.retention import problems_of
from tests.stress.ledger import Page

ROOT = Path(__file__).parents[2]
STEPS = (30, 33, 36, 39)
STUDY = f"""
name = "few"
recordings = false
[[experiments]]
name = "look"
cases = ["stress_fall"]
dt = [{", ".join(f"{0.5 / n:.17g}" for n in STEPS)}]
deadline = 2.0
samples = 3
sample_seconds = 0.001
"""
CELLS = 2 * len(STEPS)
"""Of an engine: every step on two tracks."""
KILLS = 3
LONGEST = 240.0


def begun(root: Path, study: Path, environment: Mapping[str, str]) -> subprocess.Popen[str]:
    words = ["nightly", "--history", root, "--study", study, "--engine", "sound", "--engine", "hang", "--gate", "sound"]
    return subprocess.Popen(
        [sys.executable, "-m", "plumbline", *map(str, words)],
        env=dict(environment) | {"PYTHONPATH": os.pathsep.join((environment["PYTHONPATH"], str(ROOT)))},
        cwd=ROOT,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )


def ended(process: subprocess.Popen[str]) -> str:
    """What a night said that came to its end."""
    said, errors = process.communicate(timeout=LONGEST)
    assert process.returncode == 0, errors
    return said


def lines(root: Path) -> int:
    """Of the journal of the only night, 0 where there is none yet."""
    return sum(len(path.read_bytes().splitlines()) for path in root.glob("nights/*/journal.jsonl"))


def killed(process: subprocess.Popen[str], root: Path, more: int) -> None:
    """Kill it when so many lines more are written."""
    until, enough = time.monotonic() + LONGEST, lines(root) + more
    while lines(root) < enough:
        assert process.poll() is None, process.communicate()
        assert time.monotonic() < until
        time.sleep(0.005)
    process.send_signal(signal.SIGKILL)
    process.communicate()


def said_of(root: Path) -> dict[tuple[str, str, float], tuple[str, str | None]]:
    """Status and hash of each cell of the only night."""
    (night,) = opened(root).nights()
    assert night.whole
    trials = night.store().trials
    assert trials["trial"].is_unique
    hashes = trials["trajectory_hash"].astype(object).where(trials["trajectory_hash"].notna(), None)
    keys = zip(trials["engine"], trials["track"], trials["dt"], strict=True)
    return dict(zip(keys, zip(trials["status"], hashes, strict=True), strict=True))


@pytest.mark.slow
@pytest.mark.timeout(1200)
def test_a_night_that_is_killed_three_times_beside_an_engine_that_hangs_ends_as_the_undisturbed_one(
    tmp_path: Path, with_plugins: Mapping[str, str], ledger: Page
) -> None:
    study, undisturbed, root = tmp_path / "few.toml", tmp_path / "undisturbed", tmp_path / "h"
    study.write_text(STUDY)
    ended(begun(undisturbed, study, with_plugins))
    for number in range(KILLS):
        # The first lines are what the journal begins with; then answers, and in the end prices.
        killed(begun(root, study, with_plugins), root, more=3 + number)
    ended(begun(root, study, with_plugins))
    found = said_of(root)
    assert found == said_of(undisturbed)
    assert [status for (engine, _, _), (status, _) in found.items() if engine == "hang"] == ["timeout"] * CELLS
    assert [status for (engine, _, _), (status, _) in found.items() if engine == "sound"] == ["passed"] * CELLS
    history = opened(root)
    assert [*problems_of(history)] == []
    assert (history.nights()[0].store().trials["cpu_per_unit"] > 0).sum() == CELLS
    # The next night recalls what was answered, time-outs too, but for what is drawn to be computed again.
    computed = re.search(r"(\d+) computed \((\d+) of them known ones again", ended(begun(root, study, with_plugins)))
    assert computed is not None
    assert computed[1] == computed[2]
    assert [*problems_of(history)] == []
    ledger.survived("nights", f"{KILLS} kills of a night, an engine that hangs", f"{len(found)} cells, lost 0, doubled 0")
