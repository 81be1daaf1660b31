"""No claim against MuJoCo, Bullet or DART without a script in the vendor's own words that agrees: of what an engine misses in
the quick study, and of what breaks in the limits study at the easiest value already."""

import ast
import tomllib
from dataclasses import replace
from pathlib import Path

import pytest
from pydantic import Field
from pydantic.dataclasses import dataclass

from plumbline.harness.adapter import Adapter
from plumbline.harness.scene.values import FROZEN
from plumbline.harness.study import plugins
from plumbline.harness.study.experiment import axis_of
from plumbline.harness.study.study import load_study
from plumbline.harness.trial.accuracy import run_trial
from plumbline.harness.trial.ensemble import endure

VENDOR = Path(__file__).parents[1] / "vendor"
ENGINES = ("bullet", "dart", "mujoco")
SAME = 0.01
"""Of a figure: it is written with four digits, and a newer build of an engine may round otherwise where contacts are found."""


@dataclass(frozen=True, kw_only=True, config=FROZEN)
class Script:
    """What shows something of an engine. Terms: script: 'file::test' in `tests/vendor`. because: why, in a line."""

    engine: str
    script: str
    because: str


@dataclass(frozen=True, kw_only=True, config=FROZEN)
class Shown(Script):
    """Something that a script shows of an engine in a case, on a track."""

    track: str
    case: str


@dataclass(frozen=True, kw_only=True, config=FROZEN)
class Claim(Shown):
    """What an engine misses in a case at the case's own step. Terms: checks: figure by metric."""

    checks: dict[str, float] = Field(min_length=1)

    @property
    def cell(self) -> tuple[str, str, str]:
        return self.engine, self.track, self.case


@dataclass(frozen=True, kw_only=True, config=FROZEN)
class Easiest(Shown):
    """What breaks at the easiest value of an axis. Terms: along: the parameter that is made harder."""

    along: str


@dataclass(frozen=True, kw_only=True, config=FROZEN)
class Beyond(Script):
    """Errors that an engine does not come down to in these cases of the price study, where another comes ten times as far."""

    cases: tuple[str, ...] = Field(min_length=1)


TABLES = tomllib.loads((VENDOR / "claims.toml").read_text())
CLAIMS = [Claim(**row) for row in TABLES["claims"]]
EASIEST = [Easiest(**row) for row in TABLES["easiest"]]
BEYOND = [Beyond(**row) for row in TABLES["beyond"]]
QUICK = load_study("quick")
CASES = sorted({name for experiment in QUICK.experiments for name in experiment.cases})
LONG = {
    "friction_isotropy",
    "impact_bounce",
    "joint_double_pendulum",
    "joint_pendulum",
    "rest_jitter",
    "sensor_imu_noise",
    "sensor_lidar_noise",
    "spin_asymmetric_top",
    "stack_tower",
    "stand_quadruped",
}
"""Cases that take a second and more on three engines and both tracks; the others have claims against each engine and track."""


def _named(claim: Script) -> str:
    told = f"{claim.track}/{claim.case}" if isinstance(claim, Shown) else claim.script.rpartition("::")[2]
    return f"{claim.engine}/{told}"


@pytest.mark.parametrize("claim", [*CLAIMS, *EASIEST, *BEYOND], ids=_named)
def test_the_script_of_a_claim_is_there_and_of_its_engine(claim: Script) -> None:
    file, _, name = claim.script.partition("::")
    assert file.startswith(f"test_{claim.engine}_")
    functions = {node.name for node in ast.parse((VENDOR / file).read_text()).body if isinstance(node, ast.FunctionDef)}
    assert name in functions


def test_what_is_beyond_an_engine_is_asked_of_it_in_the_price_study() -> None:
    asked = {name for experiment in load_study("price").experiments for name in experiment.cases}
    told = [(claim.engine, case) for claim in BEYOND for case in claim.cases]
    assert {case for _, case in told} <= asked
    assert len(set(told)) == len(told)


def test_no_claim_is_told_twice() -> None:
    cells = [claim.cell for claim in CLAIMS]
    assert len(set(cells)) == len(cells)


def here() -> dict[str, Adapter]:
    """The engines of others that are installed."""
    adapters = {name: plugins.adapter(name) for name in ENGINES}
    return {name: adapter for name, adapter in adapters.items() if plugins.version_of(adapter)[1] is None}


@pytest.mark.parametrize("case", [pytest.param(c, marks=pytest.mark.slow if c in LONG else ()) for c in CASES])
def test_what_an_engine_misses_in_the_quick_study_is_what_its_scripts_show(case: str, tmp_path: Path) -> None:
    """At the case's own step, by the claimed figures; at others nothing but what is claimed there."""
    engines, question = here(), plugins.case(case)
    claimed = {claim.cell: claim.checks for claim in CLAIMS if claim.case == case and claim.engine in engines}
    found: dict[tuple[str, str, str], dict[str, float]] = {}
    for trial in QUICK.trials({case: question}, engines, dict.fromkeys(engines, "here")):
        record = run_trial(trial, question, engines[trial.engine], tmp_path)
        cell = (trial.engine, trial.track, case)
        assert record.status in ("passed", "failed", "unsupported"), f"{cell}: {record.reason}"
        missed = {m.metric: m.value for m in record.measurements if m.passed is False}
        if trial.settings.dt == question.dt:
            found |= {cell: missed} if missed else {}
        else:
            assert missed.keys() <= claimed.get(cell, {}).keys(), f"{cell} at dt {trial.settings.dt:g}"
    assert {cell: sorted(missed) for cell, missed in found.items()} == {c: sorted(checks) for c, checks in claimed.items()}
    for cell, missed in found.items():
        assert missed == pytest.approx(claimed[cell], rel=SAME), cell


LIMITS = load_study("limits")
AXES = sorted({case for e in LIMITS.experiments if e.limit for case in plugins.cases() if e.asks(case)})


@pytest.mark.slow
@pytest.mark.parametrize("case", AXES)
def test_what_breaks_at_the_easiest_value_of_an_axis_is_what_scripts_show(case: str, tmp_path: Path) -> None:
    """Two starts of each; an axis that is searched at several values of another is told once."""
    engines, question = here(), plugins.case(case)
    claimed = {(e.engine, e.track, e.along) for e in EASIEST if e.case == case and e.engine in engines}
    found = set()
    for trial in LIMITS.trials({case: question}, engines, dict.fromkeys(engines, "here")):
        if trial.experiment.limit is not None:
            record = endure(replace(trial, members=2), question, engines[trial.engine], tmp_path)
            if record.status not in ("passed", "unsupported"):
                found.add((trial.engine, trial.track, axis_of(trial.experiment, question).parameter))
    assert found == claimed
