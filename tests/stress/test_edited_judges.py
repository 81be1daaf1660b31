"""A third party edits a metric, a bound, a scene: the command line goes on with `--resume`, as a fresh run would have it."""

import os
import subprocess
import sys
from pathlib import Path

from plumbline.harness.run.verify import problems
from plumbline.harness.store.store import Store
from tests.stress.ledger import Page

METRIC = '''"""How far a body went."""

import numpy as np

from plumbline.harness.metric import Run, metric
from plumbline.harness.trajectory import Floats


@metric("m")
def flown(run: Run) -> Floats:
    """definition"""
    way: Floats = np.linalg.norm(run.actual.p_WB[-1] - run.actual.p_WB[0], axis=-1)
    return way
'''
CASE = '''"""A body that nothing holds."""

from flights.flown import flown
from plumbline.harness.case import Case, Check, Parameters
from plumbline.harness.scene import Body, Scene

DURATION = 0.5


class P(Parameters):
    speed: float = 3.0


def scene(p: P) -> Scene:
    """One body."""
    return Scene(bodies=(Body(name="body", v_WB=(p.speed, 0.0, 0.0)),))


CASE = Case.of(
    globals(),
    title="Thrown",
    question="How far does it fly?",
    source="none",
    truth="conservation",
    checks=(Check(flown, 10.0, "farther than it can"),),
)
'''
STUDY = """
name = "edited"
recordings = false

[[experiments]]
name = "thrown"
cases = ["thrown"]
engines = ["mujoco", "bullet"]
timing = false
"""


def edited(path: Path, old: str, new: str) -> None:
    text = path.read_text()
    assert text.count(old) == 1
    path.write_text(text.replace(old, new))


def tables(folder: Path) -> tuple[str, str]:
    store = Store(folder)
    trials = store.trials.drop(columns=["simulated_as", "answered_on"])
    return trials.to_csv(), store.measurements.to_csv()


def test_edits_of_what_judges_are_judged_as_in_a_fresh_run_and_one_of_a_scene_is_simulated(
    tmp_path: Path, ledger: Page
) -> None:
    installed, own = tmp_path / "own", tmp_path / "own" / "flights"
    (installed / "flights-1.0.dist-info").mkdir(parents=True)
    (installed / "flights-1.0.dist-info" / "METADATA").write_text("Metadata-Version: 2.1\nName: flights\nVersion: 1.0\n")
    (installed / "flights-1.0.dist-info" / "entry_points.txt").write_text("[plumbline.cases]\nthrown = flights.thrown:CASE\n")
    own.mkdir()
    (own / "__init__.py").write_text("")
    (own / "flown.py").write_text(METRIC)
    (own / "thrown.py").write_text(CASE)
    (tmp_path / "study.toml").write_text(STUDY)

    def run(out: str, *more: str) -> str:
        command = [sys.executable, "-m", "plumbline", "run", "study.toml", "--out", out, *more]
        variables = os.environ | {"PYTHONPATH": str(installed)}
        ended = subprocess.run(command, cwd=tmp_path, env=variables, capture_output=True, text=True, check=False, timeout=280)
        assert ended.returncode in (0, 1), ended.stderr
        return ended.stderr

    run("run")
    first = Store(tmp_path / "run").trials
    assert set(first["status"]) == {"passed"}
    edited(own / "flown.py", "return way", "return 2 * way")
    edited(own / "thrown.py", "flown, 10.0", "flown, 2.0")
    assert "judges anew 4: the case's source changed: flights/flown.py, flights/thrown.py" in run("run", "--resume")
    anew = Store(tmp_path / "run").trials
    assert set(anew["simulated_as"]) == set(first["trial"])
    assert set(anew["status"]) == {"failed"}
    run("fresh")
    assert tables(tmp_path / "run") == tables(tmp_path / "fresh")
    for path in (tmp_path / "fresh" / "trajectories").iterdir():
        assert (tmp_path / "run" / "trajectories" / path.name).read_bytes() == path.read_bytes()

    edited(own / "thrown.py", "speed: float = 3.0", "speed: float = 4.0")
    assert "runs anew 4: the case's source changed: flights/thrown.py" in run("run", "--resume")
    moved = Store(tmp_path / "run").trials
    assert set(moved["simulated_as"]) == {""}
    assert not set(moved["trajectory_hash"]) & set(anew["trajectory_hash"])
    assert [str(problem) for problem in problems(tmp_path / "run")] == []
    ledger.survived(
        "resume under changed circumstances", "a plug-in's metric, bound and scene edited", "other than a fresh run 0"
    )
