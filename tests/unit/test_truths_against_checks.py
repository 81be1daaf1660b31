"""The truth of every case is put to the case's own checks: it holds, or its parameters are refused by name."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from click.testing import CliRunner
from hypothesis import given, settings
from hypothesis import strategies as st

from plumbline.harness.case import ByParameters, Case, Check, Parameters, Positive
from plumbline.harness.case.own_truth import broken_checks, refused
from plumbline.harness.cli.main import main
from plumbline.harness.metrics.errors import divergence
from plumbline.harness.metrics.jitter import rms_speed
from plumbline.harness.scene import Body, Scene
from plumbline.harness.study import plugins
from plumbline.harness.study.foreseen_cost import NoScene, scene_at
from plumbline.harness.trajectory import Floats, Trajectory
from plumbline.harness.trial.accuracy import TruthBroken, judge

CLOSED = {name: case for name, case in plugins.cases().items() if case.expected is not None}
SLOW = {"joint_double_pendulum_chaotic", "joint_chain", "joint_double_pendulum", "friction_painleve", "friction_static_kinetic"}
"""Truths that are integrated anew for each set of parameters, half a second or more."""
DRAWN = {
    (name, parameter): own
    for name, case in CLOSED.items()
    if name not in SLOW
    for parameter, own in case.parameters.items()
    if isinstance(own, int | float) and not isinstance(own, bool) and parameter not in ("seed", "worlds")
}


@pytest.mark.parametrize("name", CLOSED)
def test_a_truth_keeps_the_checks_of_its_own_case_at_every_step_of_its_ladder(name: str) -> None:
    case = CLOSED[name]
    broken = {dt: reasons for dt in {case.dt, *case.ladder} if (reasons := list(broken_checks(case, dt)))}
    assert not broken


def outcome(case: Case, parameters: Mapping[str, Any]) -> str:
    """'outside' the domain, 'no scene', 'refused' by name, or 'holds'."""
    for name, value in parameters.items():
        if case.parameters.misfit(name, value):
            return "outside"
    try:
        scene = scene_at(case, {**case.parameters, **parameters})
    except NoScene:
        return "no scene"
    with np.errstate(all="ignore"):
        reason = refused(case, {**case.parameters, **parameters}, case.dt)
        if reason:
            assert case.name in reason
            assert all(f"{name} = " in reason for name in parameters)
            return "refused"
        at = case.put({**case.parameters, **parameters})
        assert at.expected is not None
        samples = round(at.duration / (at.sample_interval or at.dt)) + 1
        made = at.expected(np.arange(samples) * (at.sample_interval or at.dt), at.parameters)
    if made is None:
        return "holds"
    truth = made if isinstance(made, Trajectory) else made.trajectory
    assert truth.finite
    assert truth.p_WB.shape == (samples, len(scene.bodies), 3)
    return "holds"


@settings(max_examples=40, deadline=None)
@given(drawn=st.data())
def test_drawn_parameters_hold_or_are_refused(drawn: st.DataObject) -> None:
    name, parameter = drawn.draw(st.sampled_from(sorted(DRAWN)))
    own = DRAWN[name, parameter]
    factor = drawn.draw(st.sampled_from([-1.0, 0.0, 0.1, 0.5, 0.9, 1.1, 2.0, 3.0]))
    value = round(own * factor) if isinstance(own, int) else own * factor
    found = outcome(CLOSED[name], {parameter: value})
    if factor in (0.9, 1.1):
        assert found == "holds"


@pytest.mark.parametrize("name", [name for name, case in CLOSED.items() if case.hard is not None and name not in SLOW])
def test_a_truth_holds_near_both_ends_of_its_cases_axis(name: str) -> None:
    """Searches go there of their own accord, and nobody is at the door to refuse anything."""
    case = CLOSED[name]
    axis = case.hard
    assert axis is not None
    if axis.parameter != "dt":
        for value in (axis.easy, min(axis.extreme, 4 * float(case.parameters[axis.parameter]))):
            kind = round if isinstance(case.parameters[axis.parameter], int) else float
            assert outcome(case, {axis.parameter: kind(value)}) == "holds"


def test_a_planets_ellipse_has_an_eccentricity_below_one() -> None:
    parameters = CLOSED["orbit_kepler"].parameters
    assert parameters.misfit("eccentricity", 1.0) == "less than 1"
    assert parameters.misfit("eccentricity", 0.99) == ""


@pytest.mark.parametrize("name", ["friction_stop", "friction_rolling_resistance"])
@pytest.mark.parametrize("factor", [0.5, 2.0, 4.0])
def test_a_run_lasts_until_all_that_slows_down_has_stopped(name: str, factor: float) -> None:
    case = CLOSED[name]
    speed = factor * float(case.parameters["speed"])
    faster = case.put({**case.parameters, "speed": speed})
    assert faster.duration == pytest.approx(factor * case.duration, rel=1e-12)
    assert outcome(case, {"speed": speed}) == "holds"


# --- A case made for the purpose --------------------------------------------------------------------------------------------


class P(Parameters):
    speed: Positive = 1.0


def scene(p: P) -> Scene:
    return Scene(bodies=(Body.ball("ball", 0.1, touches=False, v_WB=(p.speed, 0.0, 0.0)),), gravity=(0.0, 0.0, 0.0))


def expected(time: Floats, p: P) -> Trajectory:
    """It slows down by 1 m/s2 and stops."""
    truth = Trajectory.of(time, 1)
    truth.v_WB[:, 0, 0] = np.maximum(p.speed - truth.time, 0.0)
    return truth


def slowing(duration: float, start: float, another_truth: str = "") -> Case:
    return Case(
        name="slowing",
        title="Slowing",
        question="Does it stop?",
        source="by hand",
        truth="closed form",
        scene=scene,
        expected=expected,
        parameters=P(),
        duration=duration,
        checks=(
            Check(divergence, 0.0, "finite"),
            Check(rms_speed, 1e-9, "at rest", start=start, another_truth=another_truth),
        ),
    )


def test_times_that_follow_from_parameters_are_worked_out_where_the_case_is_put() -> None:
    case = slowing(ByParameters(lambda p: 2 * p.speed), ByParameters(lambda p: 1.5 * p.speed))
    assert (case.duration, case.checks[1].start) == (2.0, 1.5)
    faster = case.put({"speed": 3.0})
    assert (faster.duration, faster.checks[1].start) == (6.0, 4.5)
    assert refused(case, {"speed": 3.0}, 1 / 240) == ""


def test_a_truth_that_still_moves_is_refused_with_its_figure() -> None:
    reason = refused(slowing(2.0, 1.5), {"speed": 3.0}, 1 / 240)
    # Of the speeds from 1.5 to 1 m/s that it has between 1.5 and 2 s the largest mean square is told.
    assert reason.startswith("case 'slowing' does not hold at speed = 3.0: rms_speed of the truth itself is 1.")
    assert reason.endswith(" m/s, bound 1e-09")


def test_parameters_of_its_own_and_another_seed_are_not_tried_again() -> None:
    assert refused(slowing(2.0, 0.0), {"speed": 1.0}, 1 / 240) == ""


def test_an_engine_is_not_judged_by_a_truth_that_breaks_the_bound_itself() -> None:
    case = slowing(2.0, 0.0)
    truth = expected(np.arange(121) / 60, P())
    with pytest.raises(TruthBroken, match=r"rms_speed of the truth itself is"):
        judge(case, scene(P()), truth, None if case.expected is None else _exact(truth))


def test_a_check_of_another_truth_is_left_to_the_engine() -> None:
    truth = expected(np.arange(121) / 60, P())
    rows = judge(slowing(2.0, 0.0, another_truth="it is that of a ball"), scene(P()), truth, _exact(truth))
    assert [row.passed for row in rows] == [True, False]


def _exact(truth: Trajectory) -> Any:
    from plumbline.harness.case import Converged

    return Converged(trajectory=truth, position_error=0.0, velocity_error=0.0)


@pytest.mark.parametrize(
    ("case", "parameter", "value", "expected"),
    [
        ("orbit_kepler", "eccentricity", "1.5", "parameter 'eccentricity': 1.5, expected less than 1"),
        ("joint_limits", "amplitude", "8.0", "case 'joint_limits' does not hold at amplitude = 8.0: limit_overshoot_max"),
    ],
)
def test_a_study_is_refused_before_anything_runs(tmp_path: Path, case: str, parameter: str, value: str, expected: str) -> None:
    study = tmp_path / "own.toml"
    study.write_text(
        f'name = "own"\n[[experiments]]\nname = "one"\ncases = ["{case}"]\ntiming = false\n'
        f"parameters = {{{parameter} = [{value}]}}\n"
    )
    with np.errstate(all="ignore"):
        result = CliRunner().invoke(main, ["run", str(study), "--engine", "reference", "--out", str(tmp_path / "out")])
    assert result.exit_code == 2
    assert expected in result.output
    assert not (tmp_path / "out").exists()
