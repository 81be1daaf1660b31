"""Small studies of limits, effects and determinism, run through the command line, on engines that come compiled.

That of limits has its trials in the test's own process; those of the others, and a trial of limits again, have processes of
their own.
"""

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from plumbline.harness.findings.standing import BUDGETS
from plumbline.harness.store.store import Store
from plumbline.harness.study import plugins
from plumbline.harness.study.experiment import Experiment, Limit
from plumbline.harness.study.study import Study
from plumbline.harness.trial.ensemble import endure
from tests import study_texts
from tests.charts import checked
from tests.conftest import Command
from tests.in_process import barely_clocked, in_this_process
from tests.needs import BULLET

SLOW = pytest.mark.slow
"""What the same is asked of a second time, on other engines."""


def carried_out(text: str, folder: Path, call: Command) -> Path:
    (folder / "study.toml").write_text(text)
    done = call("run", str(folder / "study.toml"), "--out", str(folder / "run"), "--workers", "2")
    assert done.returncode == 0, done.stderr
    return folder / "run"


def table(folder: Path, name: str, printed: Command) -> list[dict[str, Any]]:
    rows: list[dict[str, Any]] = json.loads(printed("show", str(folder), "--table", name, "--format", "json").stdout)
    return rows


@pytest.fixture(scope="module")
def limits(printed: Command, tmp_path_factory: pytest.TempPathFactory) -> Path:
    with pytest.MonkeyPatch.context() as patch:
        in_this_process(patch)
        return carried_out(study_texts.limits(), tmp_path_factory.mktemp("limits"), printed)


@BULLET
def test_a_limit_agrees_with_a_direct_scan(limits: Path, printed: Command, monkeypatch: pytest.MonkeyPatch) -> None:
    """Up to eight speeds, one by one, without any search: the first that breaks lies where the bracket says."""
    case = plugins.case("tunnel_sphere_wall")
    barely_clocked(monkeypatch)
    sought = [row for row in table(limits, "limits", printed) if row["experiment"] == "walls"]
    assert {row["engine"] for row in sought} == {"mujoco", "bullet"}
    for row in sought:
        assert row["verdict"] == "limit"
        engine = plugins.adapter(row["engine"])
        experiment = Experiment(name="scan", tracks=("tuned",), timing=False, limit=Limit(members=2))
        study = Study(name="scan", experiments=(experiment,))
        (start,) = study.trials({case.name: case}, {engine.name: engine}, {engine.name: "1"})
        before, first = 0.0, None
        for speed in map(float, np.geomspace(row["easy"], row["extreme"], 8)):
            parameters = {**start.parameters, "continuous": False, "speed": speed}
            if endure(start.probing(case, parameters=parameters), case, engine, None).status != "passed":
                first = speed
                break
            before = speed
        assert first is not None
        assert row["held"] < first
        assert row["broke"] > before
        assert row["broke"] <= study_texts.WITHIN * row["held"] * (1 + 1e-9)


@BULLET
def test_what_helps_is_told_with_its_cost(limits: Path, printed: Command) -> None:
    rows = {(row["engine"], row["remedy"]): row for row in table(limits, "remedies", printed)}
    # A quarter of the step quarters the way between two looks; a wall four times as thick is looked at more often too.
    for engine in ("mujoco", "bullet"):
        for remedy in ("sub-steps x 4", "wall four times as thick"):
            assert rows[engine, remedy]["verdict"] == "helps"
            assert rows[engine, remedy]["farther"] > 0
        assert rows[engine, "sub-steps x 4"]["cost_ratio"] > 1
        # On its way to the wall, .05 m and a sixtieth of a second, it takes at most a fiftieth of the speed from 13 m/s.
        assert rows[engine, "damping"]["farther"] < rows[engine, "sub-steps x 4"]["farther"] / 10


@BULLET
def test_who_leads_is_told_at_equal_sub_steps_and_for_equal_time(limits: Path, printed: Command) -> None:
    rows = table(limits, "farthest", printed)
    equal = [row for row in rows if row["at"] == "equal sub-step"]
    assert {(row["engine"], row["parts"], row["leads"]) for row in equal} == {("mujoco", 1, True)}  # asked alone
    assert sorted(row["substep"] for row in equal) == pytest.approx([1 / 240, 1 / 120, 1 / 60], rel=1e-12)
    timed = {(row["condition"], row["engine"]) for row in rows if row["at"] == "equal time" and "continuous" in row["where"]}
    assert timed == {(budget, engine) for budget in BUDGETS for engine in ("mujoco", "bullet")}
    counted = {(row["at"], row["condition"], row["of"]) for row in table(limits, "leads", printed)}
    assert ("equal sub-step", "dt", 3) in counted


def test_the_report_of_limits_has_its_page(limits: Path) -> None:
    text = (limits / "report" / "limits.html").read_text()
    assert "What helps" in text
    assert "equal time: 0.1 ms a step" in text
    assert "wall four times as thick" in text
    assert text.count('class="spec"') == checked([text]) == 1  # the map of three steps


def test_an_ensemble_is_reproduced_bit_by_bit(limits: Path, printed: Command) -> None:
    trials = Store(limits).trials
    name = trials[(trials["status"] == "failed") & (trials["remedy"] == "damping")]["trial"].iloc[0]
    done = printed("reproduce", str(limits), name)
    assert done.returncode == 0, done.stdout
    assert "bit-identical" in done.stdout


@pytest.mark.parametrize("engines", [("mujoco",), pytest.param(("reference", "bullet", "dart"), marks=SLOW)])
def test_each_effect_has_a_price_and_a_verdict(engines: tuple[str, ...], printed: Command, tmp_path: Path) -> None:
    folder = carried_out(study_texts.effects(engines), tmp_path, printed)
    rows = table(folder, "effects", printed)
    by: Mapping[tuple[str, str, str], Any] = {(row["case"], row["engine"], row["effect"]): row for row in rows}
    assert {row["engine"] for row in rows} == set(engines)
    for engine in engines:
        assert by["flight_projectile", engine, "gravity"]["verdict"] == "needed and on"
        for effect in ("gravity", "contact", "friction"):
            assert by["friction_stop", engine, effect]["verdict"] == "needed and on"
            assert by["friction_stop", engine, effect]["cost"] > 0
        assert by["friction_stop", engine, "everything on"]["low"] > 0
    assert checked([(folder / "report" / "effects.html").read_text()]) == 1


@BULLET
@pytest.mark.parametrize(("engines", "restored"), [
    (("mujoco", "bullet"), ("bit-identical", "unsupported")), pytest.param(("dart",), (), marks=SLOW)
])  # fmt: skip
def test_repetitions_are_compared_bit_by_bit(
    engines: tuple[str, ...], restored: tuple[str, ...], printed: Command, tmp_path: Path
) -> None:
    folder = carried_out(study_texts.determinism(engines), tmp_path, printed)
    rows = {(row["engine"], row["way"]): row for row in table(folder, "determinism", printed)}
    for engine in engines:
        assert rows[engine, "again"]["verdict"] == "bit-identical"
        assert rows[engine, "alone"]["verdict"] == "bit-identical"
        # One bit is 7e-18 m at the 0.04 m of a body. What differs is multiplied a thousand times, by blows or another order of
        # contacts: the comparison could have failed.
        assert rows[engine, "nudged"]["verdict"] == "parts"
        assert max(rows[engine, way]["farthest"] for way in ("nudged", "reordered")) > 7e-15
    for engine, verdict in zip(engines, restored, strict=False):
        assert rows[engine, "restored"]["verdict"] == verdict
    assert (folder / "report" / "determinism.html").is_file()


@BULLET
def test_a_bar_that_a_constant_crosses_is_no_limit(printed: Command, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """MuJoCo leaves a ninth of the closing speed at every mass ratio: 0.333 r/(1 + r) m/s of the lighter ball, bar 0.3."""
    in_this_process(monkeypatch)
    text = """
name = "pairs"
recordings = false
[[experiments]]
name = "pairs"
cases = ["impact_pairs"]
engines = ["mujoco", "bullet"]
tracks = ["tuned"]
timing = false
limit = { scan = 3, within = 4.0, parts = [1] }
"""
    rows = {row["engine"]: row for row in table(carried_out(text, tmp_path, printed), "limits", printed)}
    assert rows["mujoco"]["verdict"] == "no limit"
    assert rows["mujoco"]["along"] == "0.167 at 1, 0.333 at 1e+06; bar 0.3"
    assert rows["bullet"]["verdict"] == "beyond the extreme"
    told = printed("show", str(tmp_path / "run"), "--table", "limits").stdout
    assert "8.66" not in told
    assert "sub-step dt/1: ratio up to 1e+06: bullet" in told
