"""Numbers of files that are finite until they are used: a file is refused by name, or each engine builds it or says why not."""

import json
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from plumbline.harness.intake.error import PlumblineError
from plumbline.harness.intake.import_wishes import Wishes
from plumbline.harness.scene.importers.reading import read
from plumbline.harness.study import plugins
from tests.stress.ledger import Page

ROOT = Path(__file__).parents[2]
HERE = Path(__file__).parent
ENGINES = ("reference", "mujoco", "bullet", "dart")
SOUND = tuple(
    HERE / name
    for name in (
        "sound_robots/machine.urdf",
        "sound_robots/machine.xml",
        "sound_robots/machine.sdf",
        "sound_files/ball.toml",
        "sound_files/fourbar.json",
        "sound_files/lidar.toml",
    )
)
EXAMPLES, MANY = 84, 3340
"""Of each of six files: 504 in all, and 20 040 in the long test."""
PROGRAM_DEATHS = 12
"""Processes that one file may take down before the test gives up."""


def exchanged(sound: Path, count: int, note: Path) -> dict[str, Any]:
    """What became of so many examples; those under which a process died are told apart."""
    totals: dict[str, Any] = {"refused": 0, "built": 0, "slowest": 0.0, "troubles": [], "died": []}
    first = 0
    while first < count and len(totals["died"]) < PROGRAM_DEATHS:
        command = [sys.executable, "-m", "tests.stress.number_fuzz_child", sound, first, count - first, note, *ENGINES]
        done = subprocess.run(list(map(str, command)), cwd=ROOT, capture_output=True, text=True, timeout=3000, check=False)
        if done.returncode:
            assert done.returncode < 0, done.stderr[-2000:]
            at = int(note.read_text())
            totals["died"].append((at, done.returncode))
            first = at + 1
            continue
        told = json.loads(done.stdout.splitlines()[-1])
        for name in ("refused", "built", "troubles"):
            totals[name] += told[name]
        totals["slowest"] = max(totals["slowest"], told["slowest"])
        first = count
    return totals


def judge(sound: Path, count: int, ledger: Page, note: Path) -> None:
    told = exchanged(sound, count, note)
    assert not told["troubles"], f"{sound.name}: {told['troubles'][:3]} of {len(told['troubles'])}"
    assert not told["died"], f"{sound.name}: {told['died']}"
    assert told["refused"]
    assert told["built"]
    figure = f"{told['refused']} refused, {told['built']} built or declined, slowest {told['slowest']:.2f} s"
    ledger.survived("number fuzz", f"{count} examples of {sound.name}", figure)


@pytest.mark.parametrize("sound", SOUND, ids=lambda path: path.name)
def test_every_number_may_be_any_number(sound: Path, ledger: Page, tmp_path: Path) -> None:
    judge(sound, EXAMPLES, ledger, tmp_path / "note")


@pytest.mark.slow
@pytest.mark.timeout(3600)
@pytest.mark.parametrize("sound", SOUND, ids=lambda path: path.name)
def test_every_number_may_be_any_number_many_times(sound: Path, ledger: Page, tmp_path: Path) -> None:
    judge(sound, MANY, ledger, tmp_path / "note")


@pytest.mark.parametrize(
    ("name", "old", "new"),
    [
        ("machine.urdf", 'ixx="0.02"', 'ixx="1e308"'),
        ("machine.urdf", 'radius="0.05"', 'radius="1e308"'),
        ("machine.urdf", '<axis xyz="0 1 0"/>', '<axis xyz="0 1e308 0"/>'),
        ("machine.urdf", 'mass value="3"', 'mass value="1e200"'),
        ("machine.xml", 'gravity="0 0 -9.81"', 'gravity="0 0 1e308"'),
        ("machine.sdf", "<mass>3</mass>", "<mass>1e308</mass>"),
    ],
)
def test_what_is_finite_until_it_is_squared_is_refused_with_its_line(
    name: str, old: str, new: str, tmp_path: Path, ledger: Page
) -> None:
    text = (HERE / "sound_robots" / name).read_text()
    assert old in text
    (tmp_path / name).write_text(text.replace(old, new))
    with pytest.raises(PlumblineError, match=rf"{name}: .*expected at most 1e\+60 in size"):
        read(tmp_path / name, Wishes(root="floating" if name.endswith(".urdf") else None))
    ledger.survived("number fuzz", f"{name} {new.replace('<', '').replace('>', ' ')}", "refused with its line")


def test_an_inertia_that_is_off_by_a_rounding_is_the_mean_of_its_two_halves(ledger: Page) -> None:
    """A scene takes 1e-9 of its size, and the engine 1e-12."""
    from plumbline.harness.scene import Body, Scene

    inertia = np.diag([0.01, 0.012, 0.014])
    inertia[0, 1] = 5e-12
    scene = Scene(bodies=(Body(name="b", mass=1.0, inertia=tuple(map(tuple, inertia.tolist()))),))
    adapter = plugins.adapter("reference")
    adapter.build(scene, adapter.tracks["tuned"]).close()
    ledger.survived("number fuzz", "an inertia off by a rounding", "built")
