"""The sweep against an engine made of formulas: it tries what matters, leaves what does not, and ends."""

import random
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import pytest

from plumbline.harness.adapter import Adapter, Feature, Settings, Simulation
from plumbline.harness.case import Case
from plumbline.harness.metrics.errors import position_error_max
from plumbline.harness.scene import Body, Scene
from plumbline.harness.search.front import SCREENING, due_for_clock, next_trials
from plumbline.harness.store.record import Measurement, Record
from plumbline.harness.study.experiment import Experiment
from plumbline.harness.study.one_knob import turned
from plumbline.harness.study.study import Study
from plumbline.harness.study.trial import Trial

CASE = Case(
    name="flight_made",
    title="",
    question="",
    source="",
    truth="closed form",
    scene=lambda _: Scene(bodies=(Body(name="ball", mass=1.0),)),
    checks=(),
    duration=1.0,
    headline=position_error_max.name,
    dt=1 / 120,
    ladder=(1 / 60, 1 / 120, 1 / 240),
)


@dataclass(frozen=True, kw_only=True)
class Made(Adapter):
    """An engine whose errors and costs are formulas."""

    name: str = "made"
    title: str = "Made"
    distribution: str = "none"
    features: Feature = Feature.NONE
    tracks: dict[str, Settings] = field(default_factory=lambda: {"default": Settings(), "tuned": Settings(integrator="good")})
    knobs: dict[str, tuple[Any, ...]] = field(
        default_factory=lambda: {
            "integrator": ("bad", "good", "best"),
            "iterations": (1, 2, 4),
            "options.colour": ("red", "blue"),
        }
    )

    def version(self) -> str:
        """Always the same."""
        return "1"

    def build(self, scene: Scene, settings: Settings) -> Simulation:
        """Never called here."""
        raise NotImplementedError


def answer(trial: Trial) -> Record:
    """Order 1 or 2 by integrator, 'best' ten times better for twice the cost; iterations only cost; colour is idle."""
    settings = trial.settings
    integrator = settings.integrator or "bad"
    error = {"bad": settings.dt, "good": settings.dt**2, "best": settings.dt**2 / 10}[integrator]
    cost = {"bad": 1.0, "good": 1.0, "best": 2.0}[integrator] * (1 + 0.1 * (settings.iterations or 1)) * 1e-6 / settings.dt
    return Record(
        trial=trial.trial,
        study="s",
        experiment="e",
        case=trial.case,
        parameters={},
        engine=trial.engine,
        engine_version="1",
        track=trial.track,
        dt=settings.dt,
        settings=settings.plain(),
        resolved={"integrator": integrator, "iterations": settings.iterations or 1, "options": {"colour": "red"}},
        status="passed",
        reason="",
        trajectory_hash=f"{settings.dt} {integrator} {settings.iterations or 1}",
        rough_cost=cost,
        measurements=(Measurement(metric=position_error_max.name, value=error, unit="m"),),
    )


def exact(trial: Trial, noise: random.Random) -> Record:
    """No error at any step, at a cost that is told wrong by up to a half."""
    told = answer(trial)
    nothing = (Measurement(metric=position_error_max.name, value=0.0, unit="m"),)
    assert told.rough_cost is not None
    return replace(told, measurements=nothing, rough_cost=told.rough_cost * noise.uniform(0.67, 1.5))


def unfolded(
    sweep: int, records: dict[str, Record] | None = None, answer: Callable[[Trial], Record] = answer, case: Case = CASE
) -> tuple[list[Trial], dict[str, Record]]:
    """All trials of a study of this one case and engine, rounds and all, with their records."""
    study = Study(name="s", experiments=(Experiment(name="e", dt="ladder", sweep=sweep),))
    cases, adapters = {case.name: case}, {"made": Made()}
    trials, known = list(study.trials(cases, adapters, {"made": "1"})), dict(records or {})
    known |= {trial.trial: answer(trial) for trial in trials}
    while more := next_trials(trials, known, cases, adapters):
        assert not {trial.trial for trial in more} & {trial.trial for trial in trials}
        known |= {trial.trial: answer(trial) for trial in more}
        trials += more
    return trials, known


def settings_of(trials: Iterable[Trial]) -> set[str]:
    """The distinct groups of settings."""
    return {repr(replace(trial.settings, source="").plain()) for trial in trials}


def test_what_takes_long_is_neither_refined_nor_turned() -> None:
    """A million times dearer, every run takes more than four seconds; its screening stays, since nothing is known before."""

    def dear(trial: Trial) -> Record:
        told = answer(trial)
        assert told.rough_cost is not None
        return replace(told, rough_cost=1e6 * told.rough_cost)

    assert max(trial.round for trial in unfolded(40)[0]) > 1
    assert max(trial.round for trial in unfolded(40, answer=dear)[0]) == 1


def test_it_finds_the_better_knob_and_the_finer_step() -> None:
    """The best integrator at the finest step allowed, a quarter of the ladder's, is reached from neighbours alone."""
    trials, known = unfolded(sweep=200)
    best = min(trials, key=lambda trial: known[trial.trial].measurements[0].value)
    assert (best.settings.integrator, best.settings.dt) == ("best", 1 / 960)
    assert max(trial.settings.dt for trial in trials) == 4 / 60


def test_an_idle_knob_is_turned_twice_and_no_settings_twice() -> None:
    """The colour leaves the trajectory as it was, first at the case's own step and then at the finest."""
    trials, _ = unfolded(sweep=200)
    turned = [trial.settings for trial in trials if trial.settings.options.get("colour") is not None]
    assert [settings.dt for settings in turned] == [1 / 120, 1 / 240]
    assert len(settings_of(trials)) == len(trials)


def test_a_knob_that_a_track_is_known_to_leave_idle_is_never_turned_there() -> None:
    """The engine resolves both colours as one, at the steps of the ladder; elsewhere nobody has asked it."""

    def surveyed(trial: Trial) -> Record:
        idle = tuple(("options.colour", colour) for colour in ("red", "blue"))
        return replace(answer(trial), idle=idle if trial.round == 0 else ())

    trials, _ = unfolded(sweep=200, answer=surveyed)
    screened = [trial for trial in trials if trial.round <= SCREENING]
    assert not [trial for trial in screened if "colour" in trial.settings.options]
    assert [trial for trial in unfolded(sweep=200)[0] if trial.round <= SCREENING and "colour" in trial.settings.options]


def test_knobs_that_were_turned_where_the_engine_errs_least_do_not_end_the_search() -> None:
    """There all knobs have been turned once where the case has one step alone: nothing is left to screen, all to explore."""
    trials, _ = unfolded(20, case=replace(CASE, dt=1 / 240, ladder=(1 / 240,)))
    assert max(trial.round for trial in trials) > SCREENING


def test_a_knob_that_is_felt_at_fine_steps_alone_is_turned_on() -> None:
    """A slop, say: at the step that knobs are first turned at the error is larger than what it takes away."""

    def sloppy(trial: Trial) -> Record:
        told, colour = answer(trial), trial.settings.options.get("colour")
        if trial.settings.dt > 1 / 240 * (1 + 1e-9):
            return told
        error = told.measurements[0].value + (0.0 if colour == "blue" else 5e-6)
        found = replace(told.measurements[0], value=error)
        return replace(told, trajectory_hash=f"{told.trajectory_hash} {colour or 'red'}", measurements=(found,))

    trials, known = unfolded(200, answer=sloppy, case=replace(CASE, dt=1 / 60))
    best = min(trials, key=lambda trial: known[trial.trial].measurements[0].value)
    assert best.settings.options == {"colour": "blue"}
    assert best.settings.dt < 1 / 240


@pytest.mark.parametrize(("moved", "steps"), [(1e-12, [1 / 120]), (1e-6, [1 / 120, 1 / 240])])
def test_a_knob_that_moves_the_answer_by_rounding_alone_is_turned_once(moved: float, steps: Sequence[float]) -> None:
    """Many knobs of an engine do nothing but round otherwise: turning them again would give it more tries than others."""

    def rounded(trial: Trial) -> Record:
        told, blue = answer(trial), trial.settings.options.get("colour") == "blue"
        found = replace(told.measurements[0], value=told.measurements[0].value + blue * moved)
        return replace(told, trajectory_hash=f"{told.trajectory_hash} {blue}", measurements=(found,))

    trials, _ = unfolded(1, answer=rounded)
    turned = [t.settings.dt for t in trials if t.settings.options.get("colour") is not None and t.round <= SCREENING]
    assert turned == steps


def test_it_ends_by_itself_and_within_its_number_of_points() -> None:
    """With room to spare it stops when the front does; without, at the number given."""
    free, _ = unfolded(sweep=10_000)
    assert 6 < len(free) < 200
    few, known = unfolded(sweep=7)
    assert [sum(trial.round == number for trial in few) for number in (0, 1, 2)] == [6, 3, 1]
    answers = [{known[t.trial].trajectory_hash for t in few if (t.round > SCREENING) == late} for late in (False, True)]
    assert len(answers[True] - answers[False]) == 7
    none, _ = unfolded(sweep=0)
    assert len(none) == 6


def test_the_same_records_give_the_same_trials() -> None:
    """So that a run that was stopped goes on where it stood."""
    trials, known = unfolded(sweep=40)
    again, _ = unfolded(sweep=40, records=known)
    assert [trial.trial for trial in again] == [trial.trial for trial in trials]


SEEDS = [*range(3), *(pytest.param(seed, marks=pytest.mark.slow) for seed in range(3, 8))]


@pytest.mark.parametrize("seed", SEEDS)
def test_an_exact_answer_is_followed_to_the_coarsest_step_whatever_the_noise_of_rough_costs(seed: int) -> None:
    noise = random.Random(seed)
    trials, known = unfolded(40, answer=lambda trial: exact(trial, noise))
    coarsest = max(trial.settings.dt for trial in trials)
    assert coarsest == pytest.approx(4 / 60)
    due = due_for_clock(trials, known, {CASE.name: CASE})
    assert coarsest in {trial.settings.dt for trial in trials if trial.trial in due}


@pytest.mark.parametrize("seed", SEEDS)
@pytest.mark.parametrize(("least", "most", "ratios"), [(0.96, 1.04, False), (0.67, 1.5, True)])
def test_the_search_goes_the_same_way_whatever_the_noise_of_rough_costs(
    seed: int, least: float, most: float, ratios: bool
) -> None:
    """Costs told wrong by up to 4 %, or by up to a half beside ratios that are right, as on a machine that slows down now and
    then: nothing else is tried, and nothing else is clocked."""
    noise = random.Random(seed)

    def disturbed(trial: Trial) -> Record:
        told = answer(trial)
        assert told.rough_cost is not None
        cost = told.rough_cost * noise.uniform(least, most)
        return replace(told, rough_cost=cost, rough_ratio=told.rough_cost / 3e-4 if ratios else None)

    plain, found = unfolded(20), unfolded(20, answer=disturbed)
    assert [trial.trial for trial in plain[0]] == [trial.trial for trial in found[0]]
    assert due_for_clock(*plain, {CASE.name: CASE}) == due_for_clock(*found, {CASE.name: CASE})


def test_labels_name_track_and_what_was_turned() -> None:
    """A reader finds the settings by the track's name."""
    trials, _ = unfolded(sweep=200)
    words = {trial.track for trial in trials if trial.round}
    assert {"tuned, integrator best", "tuned, iterations 2", "tuned, colour blue"} <= words
    assert all(word.split(",")[0] in ("default", "tuned") for word in words)


def test_a_refused_knob_is_left_alone() -> None:
    """A record without a trajectory says that the adapter would not have it."""
    study = Study(name="s", experiments=(Experiment(name="e", dt="ladder", sweep=200),))
    cases, adapters = {CASE.name: CASE}, {"made": Made()}
    trials = list(study.trials(cases, adapters, {"made": "1"}))
    known = {trial.trial: answer(trial) for trial in trials}
    while more := next_trials(trials, known, cases, adapters):
        for trial in more:
            refused = trial.settings.iterations is not None
            known[trial.trial] = replace(
                answer(trial),
                status="failed" if refused else "passed",
                trajectory_hash=None if refused else answer(trial).trajectory_hash,
                measurements=() if refused else answer(trial).measurements,
            )
        trials += more
    assert sum(trial.settings.iterations is not None for trial in trials) == 2


def test_only_what_lies_near_the_front_is_clocked() -> None:
    """And both tracks at the case's own step; more iterations cost and bring nothing, so none of them is."""
    trials, known = unfolded(sweep=200)
    due = due_for_clock(trials, known, {CASE.name: CASE})
    chosen = [trial for trial in trials if trial.trial in due]
    assert {trial.track for trial in chosen if trial.settings.dt == CASE.dt} >= {"default", "tuned"}
    assert not any((trial.settings.iterations or 1) > 2 for trial in chosen)
    assert min(trial.settings.dt for trial in chosen) == 1 / 960


def test_turning_keeps_the_rest() -> None:
    """Options are added one by one."""
    settings = Settings(iterations=5, options={"cone": "elliptic"})
    assert turned(settings, "options.colour", "red").options == {"cone": "elliptic", "colour": "red"}
    assert turned(settings, "iterations", 9).options == {"cone": "elliptic"}
