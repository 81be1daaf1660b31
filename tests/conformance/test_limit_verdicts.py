"""What a limit says, against what its case says: where a case passes at a value, its axis is not reported as broken there."""

from dataclasses import replace

import numpy as np
import pytest

from plumbline.harness.adapter import Unsupported
from plumbline.harness.case import Case
from plumbline.harness.metrics.overlaps import pairs_met
from plumbline.harness.search.first_break import Ruler
from plumbline.harness.study import plugins
from plumbline.harness.study.experiment import Experiment, Limit
from plumbline.harness.study.study import Study
from plumbline.harness.study.trial import Trial
from plumbline.harness.trial.accuracy import run_trial
from plumbline.harness.trial.answer import answer_of
from plumbline.harness.trial.ensemble import BROKE_BY, OWN_CHECKS, SIGN, endure
from tests.conformance.engines import NAMES, adapter, why_unavailable

CASES = {name: case for name, case in sorted(plugins.cases().items()) if case.hard is not None}
EVENTS = ("impact", "tunnel", "stand_hit")
"""Cases whose question is of a blow: it presupposes that one happens."""
SLOW = {"system_scaling": NAMES, "stack_pile": ("dart",)}
"""Cases that take minutes at the middle of their axis, with the engines that do. A pile on DART did not end within 1500 s."""
QUICK = ("mujoco",)
"""The engine whose answers are cheapest: what a limit says of an answer does not depend on who gave it."""


def start(case: Case, engine: str, track: str, place: float, members: int) -> Trial:
    """A trial of an ensemble of starts, at a place of the case's axis from 0, the easy end, to 1."""
    assert case.hard is not None
    experiment = Experiment(name="axis", cases=(case.name,), tracks=(track,), timing=False, limit=Limit())
    study = Study(name="axis", experiments=(experiment,))
    (trial,) = study.trials({case.name: case}, {engine: adapter(engine)}, {engine: "1"})
    by = Ruler.of(case.hard, case.parameters, experiment.limit)
    value = by.value(place)
    told = round(value) if by.whole else value
    return replace(trial.probing(case, parameters={**trial.parameters, case.hard.parameter: told}), members=members)


def agrees(name: str, engine: str, track: str, place: float, members: int) -> None:
    """Where the case passes, all starts hold, the first of which is the case's own."""
    if reason := why_unavailable(engine):
        pytest.skip(reason)
    case = CASES[name]
    trial = start(case, engine, track, place, members)
    with np.errstate(all="ignore"):
        alone, many = run_trial(trial, case, adapter(engine), None), endure(trial, case, adapter(engine), None)
    if alone.status == "passed":
        assert many.status == "passed", f"the case passes, and its axis: {many.reason}"
        assert [one.value for one in many.measurements if one.metric == OWN_CHECKS] == [1.0]


@pytest.mark.parametrize("engine", [name if name in QUICK else pytest.param(name, marks=pytest.mark.slow) for name in NAMES])
@pytest.mark.parametrize("name", ["friction_wall_pinch", "stack_card_house", "stack_mass_ratio", "tunnel_sphere_wall"])
def test_where_a_case_passes_its_axis_is_not_broken(name: str, engine: str) -> None:
    agrees(name, engine, "tuned", 0.0, 2)


@pytest.mark.slow
@pytest.mark.timeout(1500)  # a heap of a thousand contacts takes minutes
@pytest.mark.parametrize("track", ["tuned", "default"])
@pytest.mark.parametrize("place", [0.0, 0.5])
@pytest.mark.parametrize("engine", NAMES)
@pytest.mark.parametrize("name", CASES)
def test_where_a_case_passes_no_axis_is_broken(name: str, engine: str, place: float, track: str) -> None:
    if place > 0 and engine in SLOW.get(name, ()):
        pytest.skip("takes minutes")
    agrees(name, engine, track, place, 1)


def test_a_house_that_stands_beside_one_that_falls_is_not_broken_by_the_fall() -> None:
    """The generic signs are said beside the question, and break nothing."""
    case = CASES["stack_card_house"]
    record = endure(start(case, "mujoco", "tuned", 0.0, 4), case, adapter("mujoco"), None)
    assert record.status == "passed"
    shares = {one.metric: one.value for one in record.measurements}
    assert shares[SIGN + "penetration"] > 0
    assert not any(name.startswith(BROKE_BY) for name in shares)


@pytest.mark.parametrize("track", ["tuned", pytest.param("default", marks=pytest.mark.slow)])
@pytest.mark.parametrize("engine", ["mujoco", "bullet", pytest.param("dart", marks=pytest.mark.slow)])
@pytest.mark.parametrize("name", [name for name in CASES if name.startswith(EVENTS)])
def test_at_the_easy_end_of_an_axis_of_blows_something_is_hit(name: str, engine: str, track: str) -> None:
    if reason := why_unavailable(engine):
        pytest.skip(reason)
    case = replace(CASES[name], with_contacts=True, sample_interval=0.0)
    trial = start(case, engine, track, 0.0, 1)
    try:
        run = answer_of(trial, trial.problem(case.put(trial.parameters)), adapter(engine)).actual
    except Unsupported as reason:
        pytest.skip(str(reason))
    assert pairs_met(case.scene(case.at(**trial.parameters)), run) >= 1
