"""Faults in the sources of an adapter, real processes, the real clock: a night tells exactly these, and ends with 1."""

import json
import os
import shutil
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

from plumbline.harness.history.folder import opened

ROOT = Path(__file__).parents[2]
PACKAGES = ("adapters", "cases", "engine", "findings", "harness", "reports", "src")
FAULTY = {
    "simulation.py": (
        # A fifth more CPU time, by work that does nothing.
        (
            "            self._world.step(count * self._steps - listened)\n",
            "            from time import thread_time\n"
            "            begun = thread_time()\n"
            "            self._world.step(count * self._steps - listened)\n"
            "            until = begun + 1.2 * (thread_time() - begun)\n"
            "            while thread_time() < until:\n"
            "                pass\n",
        ),
        # The last bit of one coordinate, where there is a joint.
        (
            "table[:, 7:10], table[:, 10:]\n",
            "table[:, 7:10], table[:, 10:]\n"
            "        if self._scene.joints:\n"
            "            import numpy\n"
            "            out.p_WB[0, 0] = numpy.nextafter(out.p_WB[0, 0], numpy.inf)\n",
        ),
    ),
    # Three per cent more friction.
    "surfaces.py": (
        ("law.static_friction if rubs", "1.03 * law.static_friction if rubs"),
        ("law.kinetic_friction if rubs", "1.03 * law.kinetic_friction if rubs"),
    ),
}
STUDY = """
name = "few"
recordings = false
[[experiments]]
name = "look"
cases = ["flight_projectile", "friction_stop", "joint_pendulum", "spin_principal"]
samples = 5
sample_seconds = 0.05
"""
BUDGET = 600.0
"""Seconds; far more than such a night takes on two cores that nobody else uses."""


def broken_copy(folder: Path) -> Path:
    """The sources with three faults in the reference adapter."""
    for name in PACKAGES:
        shutil.copytree(ROOT / name, folder / name, symlinks=True, ignore=shutil.ignore_patterns("__pycache__"))
    for name, exchanges in FAULTY.items():
        path = folder / "adapters" / "reference" / name
        text = path.read_text()
        for sound, faulty in exchanges:
            assert text.count(sound) == 1, (name, sound)
            text = text.replace(sound, faulty)
        path.write_text(text)
    return folder


def night(sources: Path, root: Path, study: Path) -> subprocess.CompletedProcess[str]:
    """A night of these sources, in a process of its own."""
    words = ["nightly", "--history", root, "--study", study, "--budget", f"{BUDGET:g}", "--engine", "reference"]
    return subprocess.run(
        [sys.executable, "-m", "plumbline", *map(str, words), "--engine", "mujoco"],
        cwd=sources,
        env=os.environ | {"PYTHONPATH": str(sources / "src")},
        capture_output=True,
        text=True,
        timeout=2 * BUDGET,
        check=False,
    )


def told(root: Path) -> list[dict[str, Any]]:
    """What the last night says of what engines do."""
    rows: list[dict[str, Any]] = json.loads((opened(root).nights()[-1].folder / "changes" / "changes.json").read_text())
    return [row for row in rows if row["kind"] in ("verdict", "error", "price", "limit", "determinism", "digest")]


@pytest.mark.slow
@pytest.mark.timeout(1800)
def test_a_fifth_slower_three_percent_of_friction_and_one_ulp_are_told_and_nothing_else(tmp_path: Path) -> None:
    root, study = tmp_path / "h", tmp_path / "few.toml"
    study.write_text(STUDY)
    for number in range(2):
        done = night(ROOT, root, study)
        print(done.stdout)
        assert done.returncode == 0, done.stderr
        assert number == 0 or not told(root)
    faulty = night(broken_copy(tmp_path / "broken"), root, study)
    print(faulty.stdout)
    assert faulty.returncode == 1, faulty.stderr
    rows = told(root)
    assert {row["engine"] for row in rows} == {"reference"}
    prices = [row for row in rows if row["kind"] == "price"]
    answers = [row for row in rows if row["kind"] != "price"]
    assert {(row["case"], row["sense"]) for row in answers} == {
        ("friction_stop", "worse"),
        ("joint_pendulum", "within tolerance"),
    }
    (whole,) = (row for row in prices if not row["case"])
    assert whole["sense"] == "worse"
    # A fifth at least: the wait asks a clock a few times more, which counts beside steps of a microsecond.
    assert whole["high"] > 1.2
    assert "gate: reference: as a whole, over 8 prices, dearer" in faulty.stdout
    assert "gate: friction_stop on reference" in faulty.stdout
    assert "plumbline reproduce" in faulty.stdout
    summary = (opened(root).nights()[-1].folder / "changes" / "summary.md").read_text()
    assert "joint_pendulum on reference" in summary
