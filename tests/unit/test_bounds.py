"""Bounds that are derived from parameters follow these: at every value that a study may give them, not at the case's alone."""

import ast
import inspect
import json
from collections.abc import Iterator

import numpy as np
import pytest

from plumbline.cases.system_level_of_detail import inner
from plumbline.harness.adapter import Settings
from plumbline.harness.case import Check
from plumbline.harness.metrics.errors import position_error_max
from plumbline.harness.scene import EARTH_GRAVITY
from plumbline.harness.study import plugins
from plumbline.harness.study.experiment import Experiment
from plumbline.harness.study.trial import Trial
from plumbline.harness.trial.accuracy import run_trial

CASES = plugins.cases()
SCALED = {
    "friction_rolling_resistance": {"COEFFICIENTS", "SPEED"},
    "joint_spring": {"RATE"},
    "stand_hit": {"SPEED", "SPIN"},
}
"""Own values that a bound is scaled from on purpose: a duration at one speed, a motion worked out at one rate, a figure rounded
up at one speed."""


LONG_ONES = ("joint_chain", "joint_double_pendulum_chaotic", "joint_fourbar", "joint_spring", "orbit_kepler")
"""Their bounds integrate a motion, as those of the double pendulum do, for longer."""


@pytest.mark.parametrize("name", [pytest.param(name, marks=pytest.mark.slow if name in LONG_ONES else ()) for name in CASES])
def test_a_bound_is_the_same_at_parameters_read_back_from_a_record(name: str) -> None:
    case = CASES[name]
    told = json.loads(json.dumps(dict(case.parameters)))
    for check in case.checks:
        bounds = [check.bound(case.dt, case.parameters), check.bound(case.dt, case.at(**told))]
        assert bounds[0] == bounds[1], check.metric.name
        assert np.isfinite(bounds[0])


def _names(node: ast.AST) -> Iterator[str]:
    """The names that an expression or a function reads, but for those that stand for defaults of its arguments."""
    if isinstance(node, ast.arguments):
        return
    if isinstance(node, ast.Name):
        yield node.id
    for part in ast.iter_child_nodes(node):
        yield from _names(part)


@pytest.mark.parametrize("name", CASES)
def test_no_bound_reads_a_constant_in_place_of_a_parameter(name: str) -> None:
    """Constants that are the default of a parameter of the scene, read by a bound or by what it calls or is made from."""
    module = ast.parse(inspect.getsource(inspect.getmodule(CASES[name].scene)))  # type: ignore[arg-type]
    meaning: dict[str, ast.AST] = {}
    for statement in module.body:
        if isinstance(statement, ast.FunctionDef):
            meaning[statement.name] = statement
        elif isinstance(statement, ast.Assign) and all(isinstance(target, ast.Name) for target in statement.targets):
            meaning[statement.targets[0].id] = statement.value  # type: ignore[attr-defined]
    scene = meaning[CASES[name].scene.__name__]
    fields = [node for statement in module.body if isinstance(statement, ast.ClassDef) for node in statement.body]
    own = {field.value.id for field in fields if isinstance(field, ast.AnnAssign) and isinstance(field.value, ast.Name)}
    checks = [node for node in ast.walk(module) if isinstance(node, ast.Call) and getattr(node.func, "id", "") == "Check"]
    ahead = [read for check in checks for read in _names(check.args[1])]
    read = set[str]()
    while ahead:
        one = ahead.pop()
        if one in read or one == "CASE":
            continue
        read.add(one)
        if one in meaning and meaning[one] is not scene:
            ahead += _names(meaning[one])
    assert read & own <= SCALED.get(name, set())


FALL, GIVE = -EARTH_GRAVITY[2] / 240**2, 1e-3
"""One step's fall and what a contact may give way [m]."""
BLOW = 2 * 2.0 * 0.1 * np.sin(np.arccos(inner(4))) / 240
"""A step's way at the speed by which a corner of 320 facets of a ball of 10 cm at 2 rad/s meets a face [m]."""
FOLLOWS = [
    ("impact_momentum", "momentum_drift_max", {"speed": 10.0}, 10.0),
    ("impact_cradle", "momentum_drift_max", {"speed": 1.0, "gaps": (1e-3, 0.0, 0.0, 0.0)}, 4.0),
    ("friction_slip_to_roll", "velocity_error_max", {"friction": 0.9}, 3.0),
    ("friction_roll_incline", "velocity_error_max", {"angle": 90.0}, 2.0),
    ("stack_card_house", "frame_friction_error", {"margin": 0.01}, 0.1),
    ("stack_tower", "stack_height_error", {"n": 1}, 19 * (FALL + GIVE) / (55 * FALL + 10 * GIVE)),
    ("spin_heavy_top", "precession_rate_error", {"spin": 1000.0}, 5.0),
    ("tunnel_thin_mesh", "lateral_kick", {"speed": 40.0, "slide": 2.0}, 2.0),
    ("stand_hit", "held_energy_gain_max", {"speed": 6.0}, 4.0),
    ("system_level_of_detail", "cam_follower_gap", {"rate": 4.0}, (FALL + 2 * BLOW + GIVE) / (FALL + BLOW + GIVE)),
    ("joint_limits", "limit_overshoot_max", {"amplitude": 179.0}, None),
]
"""Case, metric, changed parameters, and by hand how many times the bound at the case's own that at these is."""


@pytest.mark.parametrize(("name", "metric", "changed", "times"), FOLLOWS)
def test_a_bound_follows_the_parameters_that_it_is_derived_from(
    name: str, metric: str, changed: dict[str, object], times: float | None
) -> None:
    case = CASES[name]
    (check,) = (check for check in case.checks if check.metric.name == metric)
    if times is None:  # w^2 ~ cos(stop) - cos(amplitude)
        speeds = [np.sqrt(np.cos(np.radians(20.0)) - np.cos(np.radians(amplitude))) for amplitude in (80.0, 179.0)]
        times = float(speeds[1] / speeds[0])
    told = dict(case.parameters) | changed
    assert check.bound(case.dt, case.at(**told)) == pytest.approx(times * check.bound(case.dt, case.parameters), rel=1e-12)


@pytest.mark.parametrize("ratios", [(0.1,), pytest.param((0.1, 1.0, 2.0), marks=pytest.mark.slow)])
def test_a_spring_of_any_rate_errs_by_as_much_in_its_own_time(ratios: tuple[float, ...]) -> None:
    """x(t) = X(w t): an error per step of X is that of x over w, and the largest one comes at the same w t."""
    case = CASES["joint_spring"]
    (check,) = (check for check in case.checks if check.metric.name == "position_error_max")
    slow = dict(case.parameters) | {"ratios": ratios}
    assert check.bound(1e-8, case.at(**(slow | {"rate": 6e4}))) == pytest.approx(check.bound(1e-4, case.at(**slow)), rel=1e-6)


def test_where_a_motion_has_no_truth_its_bound_is_no_number() -> None:
    """A number there could let pass what nothing was compared with; beyond mu = 4/3 Painleve's rod has no motion."""
    case = CASES["friction_painleve"]
    (check,) = (check for check in case.checks if check.metric.name == "position_error_max")
    assert np.isfinite(check.bound(1e-3, case.at(friction=0.5)))
    assert np.isnan(check.bound(1e-3, case.at(friction=2.0)))
    assert not check.passes(0.0, 1e-3, case.at(friction=2.0))


def test_a_trial_is_judged_by_the_bound_at_its_own_parameters() -> None:
    case, adapter = CASES["flight_box"], plugins.adapter("reference")
    trial = Trial(
        study="s",
        experiment=Experiment(name="e"),
        case=case.name,
        parameters={"speed": 90.19, "spin": 2.0},
        engine="reference",
        engine_version="1",
        track="tuned",
        settings=Settings(dt=case.dt, substeps=4),
        seed=0,
    ).named()
    record = run_trial(trial, case, adapter, None)
    found = {one.metric: one for one in record.measurements}
    assert record.substep == case.dt / 4
    # Half a unit in the last place of single precision of speed + g T = 100 m/s, in each of 240 steps' four sub-steps.
    assert found["velocity_error_max"].at_most == pytest.approx(2.0**-24 * 100.0 * 240 * 4, rel=1e-12)


def test_a_bound_is_of_the_step_that_is_taken_unless_it_names_the_one_between_two_calls() -> None:
    """g dt of a fall, and a run that ends within an outer step, at 1/60 s taken in eight."""
    tower, house = CASES["stack_tower"], CASES["stack_card_house"]
    (fall,) = (check for check in tower.checks if check.metric.name == "rms_speed")
    assert fall.bound(1 / 60, tower.parameters, 1 / 480) == pytest.approx(fall.bound(1 / 480, tower.parameters), rel=1e-12)
    (end,) = (check for check in house.checks if check.metric.better == "higher")
    assert end.bound(1 / 60, house.parameters, substep=1 / 480) == end.bound(1 / 60, house.parameters)
    box = CASES["flight_box"]
    both = Check(metric=position_error_max, at_most=lambda dt, p: p.speed * (dt + 10 * dt.outer), because="test")
    assert both.bound(0.1, box.at(speed=2.0), 0.025) == pytest.approx(2.05, rel=1e-12)
    assert both.bound(0.1, box.at(speed=1.0)) == pytest.approx(1.1, rel=1e-12)


def test_a_parameter_that_a_case_does_not_have_is_refused() -> None:
    with pytest.raises(TypeError, match="unexpected keyword argument 'mass'"):
        CASES["flight_box"].at(mass=1.0)
