"""The search for limits, on an engine whose limit is planted: it is found within the tolerance, wherever it lies."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
import pytest

from plumbline.harness.adapter import Adapter, Diverged, Feature, Notice, Settings, Simulation, Unsupported
from plumbline.harness.case import Axis, Case, Check, Parameters
from plumbline.harness.case.starts import TOLERANCE, member
from plumbline.harness.metric import Metric, NotMeasurable
from plumbline.harness.metrics.errors import divergence
from plumbline.harness.scene import Body, Effect, PlacedShape, Scene, Sphere
from plumbline.harness.search.first_break import (
    ErrorAt,
    Ruler,
    bracket,
    extreme_untried,
    next_trials,
    next_value,
    remedied,
    unchanged,
    value_of,
)
from plumbline.harness.store.record import Record, StoredNotice, short_of
from plumbline.harness.study.experiment import Experiment, Limit, StudyError, axis_of
from plumbline.harness.study.study import Study
from plumbline.harness.study.trial import Trial
from plumbline.harness.trajectory import State
from plumbline.harness.trial.beside_tuned import idle_turns, is_surveyed
from plumbline.harness.trial.ensemble import BROKE_BY, HEADLINE, HELD, OWN_CHECKS, endure

EASY, EXTREME, FRAY = 1.0, 1e4, 0.05
"""Ends of the axis; starts break up to so much below the limit, each by its own."""


class P(Parameters):
    speed: float = 1.0


def stage(p: P) -> Scene:
    body = Body(name="ball", v_WB=(p.speed, 0.0, 0.0), collision=(PlacedShape(shape=Sphere(radius=0.1)),))
    return Scene(bodies=(body,), gravity=(0.0, 0.0, 0.0))


def case_of(easy: float = EASY, extreme: float = EXTREME, first: float = EASY, **more: Any) -> Case:
    return Case(
        name="flight_made",
        title="",
        question="",
        source="",
        truth="conservation",
        scene=stage,
        checks=(Check(metric=divergence, at_most=0.0, because=""),),
        parameters=P(first),
        duration=0.1,
        hard=Axis(parameter="speed", unit="m/s", easy=easy, extreme=extreme, lost=0.0),
        headline=divergence.name,
        **more,
    )


class Brittle:
    """Flies straight, and diverges where the speed is above the limit, less what this start's place takes off it."""

    def __init__(self, scene: Scene, settings: Settings, limit: float) -> None:
        self.resolved, self._state, self._time = settings, State.initial(scene), 0.0
        speed = float(np.linalg.norm(self._state.v_WB[0]))
        fray = FRAY * (abs(float(self._state.p_WB[0, 0])) * 1e6 % 1.0)
        self._breaks = speed > limit * (1 - fray)

    def step(self, count: int = 1) -> None:
        if self._breaks:
            raise Diverged("too fast")
        self._time += count * self.resolved.dt

    def state(self, out: State) -> None:
        out.p_WB[:] = self._state.p_WB + self._state.v_WB * self._time
        out.q_WB[:], out.v_WB[:], out.w_WB[:] = self._state.q_WB, self._state.v_WB, 0.0

    def warnings(self) -> tuple[str, ...]:
        return ()

    def close(self) -> None:
        pass

    def __getattr__(self, name: str) -> Any:
        raise Unsupported(name, "balls only fly here")


@dataclass(frozen=True, kw_only=True)
class BrittleEngine(Adapter):
    """Breaks above `limit` [m/s]; its sub-steps multiply that."""

    limit: float
    name: str = "brittle"
    title: str = "planted limit"
    distribution: str = "none"
    features: Feature = Feature.NONE
    tracks: Mapping[str, Settings] = field(default_factory=lambda: {"tuned": Settings(substeps=1)})
    knobs: Mapping[str, tuple[Any, ...]] = field(default_factory=lambda: {"substeps": (1, 2, 4)})

    def version(self) -> str:
        return "1"

    def build(self, scene: Scene, settings: Settings) -> Simulation:
        made: Any = Brittle(scene, settings, self.limit * (settings.substeps or 1))
        return made


def searched(case: Case, engine: BrittleEngine, limit: Limit) -> tuple[list[Trial], dict[str, Record]]:
    """The whole search, in this process."""
    experiment = Experiment(name="axis", tracks=("tuned",), timing=False, limit=limit)
    study = Study(name="limits", experiments=(experiment,))
    cases, adapters = {case.name: case}, {engine.name: engine}
    trials = list(study.trials(cases, adapters, {engine.name: "1"}))
    records = {trial.trial: endure(trial, case, engine, None) for trial in trials}
    while more := next_trials(trials, records, cases, adapters):
        records |= {trial.trial: endure(trial, case, engine, None) for trial in more}
        trials += more
    return trials, records


def plain_bracket(trials: list[Trial], records: Mapping[str, Record], case: Case) -> tuple[float | None, float | None]:
    axis = axis_of(trials[0].experiment, case)
    known = {value_of(t, axis): str(records[t.trial].status) for t in trials if not t.remedied}
    found = bracket(known, Ruler(axis, False, 1.1))
    return found.held, found.broke


@pytest.mark.parametrize("seed", [*range(6), *(pytest.param(seed, marks=pytest.mark.slow) for seed in range(6, 20))])
def test_a_planted_limit_is_found_within_the_tolerance(seed: int) -> None:
    limit = math.exp(np.random.default_rng(seed).uniform(math.log(2 * EASY), math.log(EXTREME / 2)))
    case = case_of()
    held, broke = plain_bracket(*searched(case, BrittleEngine(limit=limit), Limit(within=1.1, members=4)), case)
    assert held is not None
    assert broke is not None
    assert held <= limit
    assert broke >= limit * (1 - FRAY)
    assert broke / held <= 1.1 * (1 + 1e-9)


def test_the_share_that_held_is_told_where_only_some_starts_break() -> None:
    case, limit = case_of(), 100.0
    trials, _ = searched(case, BrittleEngine(limit=limit), Limit())
    there = replace(trials[0], parameters={"speed": limit * (1 - FRAY / 2)})
    record = endure(there, case, BrittleEngine(limit=limit), None)
    share = next(m.value for m in record.measurements if m.metric == HELD)
    assert 0.0 < share < 1.0
    assert record.status == "failed"
    assert "finite" in record.reason


def test_an_engine_that_never_breaks_and_one_that_always_does() -> None:
    case = case_of()
    assert plain_bracket(*searched(case, BrittleEngine(limit=2 * EXTREME), Limit()), case) == (EXTREME, None)
    assert plain_bracket(*searched(case, BrittleEngine(limit=EASY / 2), Limit()), case) == (None, EASY)


def test_an_axis_that_falls_and_one_of_whole_numbers() -> None:
    falling = Ruler(Axis(parameter="x", unit="1", easy=1.0, extreme=0.01), False, 1.25)
    known: dict[float, str] = {}
    while (value := next_value(known, falling, 4)) is not None:
        known[value] = "passed" if value >= 0.2 else "failed"
    found = bracket(known, falling)
    assert found.held is not None
    assert found.broke is not None
    assert found.broke < 0.2 <= found.held <= 1.25 * found.broke * (1 + 1e-9)
    whole = Ruler(Axis(parameter="n", unit="1", easy=1, extreme=30), True, 1.01)
    known = {}
    while (value := next_value(known, whole, 4)) is not None:
        assert value == round(value)
        known[value] = "passed" if value <= 17 else "crashed"
    assert bracket(known, whole) == type(found)(17.0, 18.0)


def test_an_axis_that_begins_at_zero_is_halved_until_its_bracket_is_a_share_of_it() -> None:
    by = Ruler(Axis(parameter="x", unit="1", easy=0.0, extreme=0.45), False, 1.6)
    known: dict[float, str] = {}
    while (value := next_value(known, by, 3)) is not None:
        known[value] = "passed" if value <= 0.41 else "failed"
    found = bracket(known, by)
    assert found.held is not None
    assert found.broke is not None
    assert found.held <= 0.41 < found.broke
    assert found.broke - found.held <= 0.6 / 4 * 0.45 * (1 + 1e-9)


def test_the_first_place_that_breaks_counts_and_not_an_island_beyond() -> None:
    by = Ruler(Axis(parameter="x", unit="1", easy=0.0, extreme=1.0), False, 1.05)
    assert bracket({0.0: "passed", 0.3: "failed", 0.6: "passed", 1.0: "failed"}, by).held == 0.0
    assert next_value({0.0: "passed", 0.5: "failed"}, by, 3) == 0.25


def test_a_run_without_an_answer_ends_the_search() -> None:
    by = Ruler(Axis(parameter="x", unit="1", easy=1.0, extreme=100.0), False, 1.25)
    assert next_value({1.0: "passed", 10.0: "timeout"}, by, 3) is None
    assert bracket({1.0: "passed", 10.0: "timeout"}, by).stopped


def test_a_remedy_that_helps_is_followed_and_one_that_does_not_is_told() -> None:
    case, limit = case_of(eased={"slow": {"speed": 1.0}}), 100.0
    trials, records = searched(case, BrittleEngine(limit=limit), Limit(within=1.1, members=4, remedies=("tuned",)))
    sick = {trial.remedied for trial in trials if trial.remedied}
    assert len(sick) == 1
    by_remedy = {trial.remedy: records[trial.trial].status for trial in reversed(trials) if trial.remedied}
    assert by_remedy["sub-steps x 4"] == "passed"
    assert by_remedy["damping"] == "failed"
    farther = [trial.parameters["speed"] for trial in trials if trial.remedy == "sub-steps x 4"]
    assert len(farther) > 1
    assert max(farther) > limit


def test_what_an_adapter_names_of_its_documentation_is_tried_where_it_acts_and_does_not_stand_already() -> None:
    """Among a scene's knobs, and at another value."""
    knobs = {"options.grip": (1.0, 2.0), "options.hinge": (1.0, 2.0)}
    named = {"firm": ("options.grip", 2.0), "as it is": ("options.grip", 1.0), "elsewhere": ("options.hinge", 2.0)}
    track = {"tuned": Settings(options={"grip": 1.0})}
    engine = BrittleEngine(limit=100.0, knobs=knobs, acts_on={"options.hinge": Effect.JOINTS}, remedies=named, tracks=track)
    trials, _ = searched(case_of(), engine, Limit(within=1.1, members=4, remedies=("tuned",)))
    tried = {trial.remedy: trial.settings for trial in trials if trial.remedied}
    assert tried["firm"].options == {"grip": 2.0}
    assert not tried.keys() & {"as it is", "elsewhere"}


@dataclass(frozen=True, kw_only=True)
class Deaf(BrittleEngine):
    """The same with integrators that it does not listen to."""

    knobs: Mapping[str, tuple[Any, ...]] = field(default_factory=lambda: {"integrator": ("euler", "rk4")})

    def build(self, scene: Scene, settings: Settings) -> Simulation:
        made: Any = Brittle(scene, replace(settings, integrator=None), self.limit)
        return made


def test_a_knob_that_is_idle_where_a_case_breaks_is_no_remedy() -> None:
    case, engine = case_of(), Deaf(limit=100.0, name="deaf")
    limit = Limit(within=1.1, members=4, remedies=("tuned",))
    trials, records = searched(case, engine, limit)
    sick = next(trial for trial in trials if records[trial.trial].status == "failed" and not trial.remedied)
    assert is_surveyed(sick, records[sick.trial])
    idle = idle_turns(sick, case, engine)
    assert idle == (("integrator", "euler"), ("integrator", "rk4"))
    before, after = ({one.remedy for one in remedied(sick, case, engine, 9, known)} for known in ((), idle))
    assert before - after == {"integrator euler", "integrator rk4"}
    assert after


@dataclass(frozen=True, kw_only=True)
class Stepper(BrittleEngine):
    """The same without sub-steps: what it holds grows as its time step shrinks."""

    knobs: Mapping[str, tuple[Any, ...]] = field(default_factory=dict)

    def build(self, scene: Scene, settings: Settings) -> Simulation:
        made: Any = Brittle(scene, settings, self.limit * round(1 / 240 / settings.dt))
        return made


def test_at_equal_sub_steps_a_divided_step_is_as_good_as_sub_steps() -> None:
    """Two engines with one law, limit = 100 m/s a part of the step: one takes sub-steps, the other shorter steps."""
    found: dict[str, dict[int, tuple[float | None, float | None]]] = {}
    for engine in (BrittleEngine(limit=100.0), Stepper(limit=100.0, name="stepper")):
        trials, records = searched(case_of(), engine, Limit(within=1.5, parts=(1, 4)))
        assert {trial.parts for trial in trials} == {1, 4}
        for trial in trials:
            assert records[trial.trial].substep == pytest.approx(1 / 240 / trial.parts, rel=1e-12)
        found[engine.name] = {
            parts: plain_bracket([t for t in trials if t.parts == parts], records, case_of()) for parts in (1, 4)
        }
    assert found["brittle"] == found["stepper"]
    assert found["brittle"][4][0] is not None
    assert found["brittle"][1][1] is not None
    assert found["brittle"][4][0] > found["brittle"][1][1]


def test_four_times_the_sub_steps_are_offered_to_an_engine_that_has_none() -> None:
    engine, limit = Stepper(limit=100.0, name="stepper"), Limit(within=1.1, members=4, remedies=("tuned",))
    trials, records = searched(case_of(), engine, limit)
    helped = [trial for trial in trials if trial.remedy == "sub-steps x 4"]
    assert {trial.settings.dt for trial in helped} == {1 / 960}
    assert records[helped[0].trial].status == "passed"
    assert not any(trial.remedy == "time step / 4" for trial in trials)


def test_parts_of_a_step_that_is_itself_sought_are_refused() -> None:
    with pytest.raises(ValueError, match=r"limit\.parts: \[1, 4\] along 'dt', expected none, or 1"):
        Experiment(name="e", limit=Limit(along="dt", parts=(1, 4)))


def test_starts_are_the_same_for_everyone_and_differ_from_each_other() -> None:
    scene = stage(P(5.0))
    first, again, other = (member(scene, number, 0.01) for number in (3, 3, 4))
    assert first.scene == again.scene
    assert first.scene != other.scene
    run = State.initial(first.scene)
    # Up to a step's way along the motion, and the tolerance across it, once told back.
    assert first.told is not None
    assert np.linalg.norm(run.p_WB[0]) <= 5.0 * 0.01 + math.sqrt(3) * TOLERANCE * 0.2
    assert np.linalg.norm(run.v_WB[0]) == pytest.approx(5.0, rel=1e-14)


def test_remedies_are_for_tracks_that_run() -> None:
    with pytest.raises(ValueError, match=r"limit\.remedies: 'default', expected one of the experiment's tracks: tuned"):
        Experiment(name="e", tracks=("tuned",), limit=Limit(remedies=("default",)))


def test_an_axis_that_is_not_there_is_named() -> None:
    with pytest.raises(StudyError, match="no axis 'weight', expected one of: dt, speed"):
        axis_of(Experiment(name="e", limit=Limit(along="weight")), case_of())


def judged(measure: Any, lost: float = 0.0, bound: float = 0.0) -> Record:
    """The ensemble of a case whose headline is the measure, on an engine that never breaks."""
    metric = Metric(name="made", unit="1", source="", measure=measure)
    case = replace(case_of(), headline="made", checks=(Check(metric=metric, at_most=bound, because=""),))
    assert case.hard is not None
    case = replace(case, hard=replace(case.hard, lost=lost))
    experiment = Experiment(name="axis", tracks=("tuned",), timing=False, limit=Limit())
    engine = BrittleEngine(limit=2 * EXTREME)
    trials = Study(name="limits", experiments=(experiment,)).trials(
        {case.name: case}, {engine.name: engine}, {engine.name: "1"}
    )
    return endure(next(iter(trials)), case, engine, None)


def test_a_question_that_cannot_be_measured_is_not_held() -> None:
    def blind(*_: object) -> float:
        raise NotMeasurable("nothing met")

    record = judged(blind)
    assert record.status == "unsupported"
    assert "nothing met" in record.reason


def test_an_axis_asks_no_more_than_its_case_grants() -> None:
    assert judged(lambda *_: 0.5, lost=0.1, bound=0.6).status == "passed"
    assert judged(lambda *_: 0.5, lost=0.1, bound=0.4).status == "failed"
    assert judged(lambda *_: 0.5, lost=0.6, bound=0.4).status == "passed"


def test_what_broke_is_named_by_the_headline_and_the_own_checks_are_said_beside() -> None:
    record = judged(lambda *_: 0.5, lost=0.6, bound=0.4)
    shares = {one.metric: one.value for one in record.measurements}
    assert shares[OWN_CHECKS] == 0.0
    broken = judged(lambda *_: 0.5, lost=0.1, bound=0.4)
    assert {one.metric: one.value for one in broken.measurements}[BROKE_BY + "made"] == 1.0


CONSTANT = (ErrorAt(1.0, 0.167, 0.3), ErrorAt(8.0, 0.31, 0.3), ErrorAt(1e6, 0.333, 0.3))
"""MuJoCo's head-on pairs along their mass ratio: 0.333 r/(1 + r), which cannot double from r = 1 on."""


def test_an_error_that_has_not_doubled_is_a_constant_and_one_that_has_is_a_matter_of_the_axis() -> None:
    assert unchanged(CONSTANT, 1.0, 1e6)
    assert not unchanged((*CONSTANT[:2], ErrorAt(1e6, 0.34, 0.3)), 1.0, 1e6)
    assert not unchanged(CONSTANT[:2], 1.0, 1e6), "the extreme is unknown"
    assert not unchanged((ErrorAt(1.0, 0.0, 0.3), CONSTANT[2]), 1.0, 1e6), "nothing at the easy end"


def test_the_extreme_is_tried_where_the_first_value_that_broke_errs_hardly_more_than_the_easy_end() -> None:
    assert extreme_untried(CONSTANT[:2], 1.0, 8.0, 1e6)
    assert not extreme_untried(CONSTANT, 1.0, 8.0, 1e6)
    assert not extreme_untried((ErrorAt(1.0, 0.1, 0.3), CONSTANT[1]), 1.0, 8.0, 1e6)
    assert not extreme_untried((), 1.0, 8.0, 1e6), "no axis is about an error"


def test_an_ensemble_records_the_headline_error_of_its_worst_start_with_its_bar() -> None:
    record = judged(lambda *_: 0.5, lost=0.1, bound=0.4)
    assert [(one.value, one.at_most, one.passed) for one in record.measurements if one.metric == HEADLINE] == [
        (0.5, 0.4, False)
    ]


@dataclass(frozen=True, kw_only=True)
class Full(BrittleEngine):
    """The same, which holds half of the scene."""

    def build(self, scene: Scene, settings: Settings) -> Simulation:
        made: Any = super().build(scene, settings)
        made.warnings = lambda: (Notice("holds half of it", "capacity"), Notice("a note"))
        return made


def test_what_an_engine_could_not_hold_begins_the_reason_of_what_broke() -> None:
    case = case_of()
    for limit, begins in ((EASY / 2, "holds half of it; "), (2 * EXTREME, "all ")):
        _, records = searched(case, Full(limit=limit), Limit())
        assert all(record.reason.startswith(begins) for record in records.values())
    short = short_of((StoredNotice("holds half of it", "capacity"), StoredNotice("a note")))
    assert short == "holds half of it; "
