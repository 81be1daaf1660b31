"""How a ladder goes on, against engines made of formulas: down to a finest step, beyond it where it helps, within a budget."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
import pytest

from plumbline.harness.adapter import Adapter, Feature, Settings, Simulation
from plumbline.harness.case import Case
from plumbline.harness.case.alteration import TURNED, Alteration
from plumbline.harness.case.starts import perturbed
from plumbline.harness.findings.agreement.setting_causes import Turned, cause_words
from plumbline.harness.findings.agreement.values import Agreement
from plumbline.harness.findings.agreement.words import length
from plumbline.harness.scene import Body, Effect, Scene, sphere_inertia
from plumbline.harness.search.refined_ladder import candidates, next_trials, start_name
from plumbline.harness.store.record import Record, StoredNotice
from plumbline.harness.study.experiment import Experiment, Refinement
from plumbline.harness.study.one_knob import differing
from plumbline.harness.study.study import Study
from plumbline.harness.study.trial import Trial
from plumbline.harness.trajectory.parting import extent
from plumbline.harness.trial.accuracy import outcome

SCENE = Scene(bodies=(Body(name="ball", inertia=sphere_inertia(1.0, 0.1)),))
CASE = Case(
    name="scene:made",
    title="",
    question="",
    source="",
    truth="agreed limit",
    scene=lambda _: SCENE,
    checks=(),
    duration=1.0,
    ladder=(1 / 240, 1 / 480, 1 / 960),
)
TIME = np.arange(61) / 60
Law = Callable[[float], np.ndarray | None]
"""From a time step [s] to where the ball is at each sample [m]; None where it diverges."""


@dataclass(frozen=True, kw_only=True)
class Made(Adapter):
    """An engine whose answers are formulas."""

    distribution: str = "somebody's"
    features: Feature = Feature.NONE
    tracks: Mapping[str, Settings] = field(default_factory=lambda: {"default": Settings(), "tuned": Settings(iterations=9)})

    def version(self) -> str:
        """Always the same."""
        return "1"

    def build(self, scene: Scene, settings: Settings) -> Simulation:
        """Never called here."""
        raise NotImplementedError


class Kept:
    """The trajectories of a run folder, made when they are asked for."""

    def __init__(self) -> None:
        self.made: dict[str, np.ndarray] = {}

    def trajectory(self, name: str, only: Sequence[str] = ()) -> dict[str, Any]:
        """As `Store.trajectory`."""
        p_WB = np.zeros((len(TIME), 1, 3))
        p_WB[:, 0, 0] = self.made[name]
        q_WB = np.zeros((len(TIME), 1, 4))
        q_WB[..., 0] = 1.0
        return {"time": TIME, "p_WB": p_WB, "q_WB": q_WB, "v_WB": 0 * p_WB, "w_WB": 0 * p_WB}


def first_order(dt: float) -> np.ndarray:
    return TIME + 3 * dt * TIME


def chaotic(dt: float) -> np.ndarray:
    """A difference of dt grows by e^12 in a second and folds back: known for a part of it only, at whatever step."""
    return np.sin(10 * dt * np.exp(12 * TIME))


def explodes_when_coarse(dt: float) -> np.ndarray | None:
    return None if dt > 1 / 3000 else first_order(dt)


def carried_out(
    laws: Mapping[str, Law],
    refine: Refinement,
    cost: float = 0.1,
    ours: str = "",
    tracks: Mapping[str, Settings] | None = None,
    off: Callable[[Settings], float] = lambda _: 0.0,
    wanted: Callable[[Trial], bool] = lambda _: True,
) -> tuple[list[Trial], Mapping[str, Record]]:
    """All trials of the search, with their records; a run costs `cost` CPU seconds at 1/240 s, twice that at half the step.

    Args: tracks: of each engine. off: what settings move its ball aside [m/s].
    """
    experiment = Experiment(name="ladder", dt="ladder", refine=refine, timing=False)
    adapters: dict[str, Adapter] = {
        name: Made(
            name=name,
            title=name,
            **({"distribution": "plumbline"} if name == ours else {}),
            **({} if tracks is None else {"tracks": tracks}),
        )
        for name in laws
    }
    study = Study(name="made", experiments=(experiment,))
    trials = list(study.trials({CASE.name: CASE}, adapters, dict.fromkeys(laws, "1")))
    kept, records = Kept(), {}
    for _ in range(20):
        for trial in trials:
            if trial.trial not in records:
                answer = laws[trial.engine](trial.settings.dt)
                if answer is not None:
                    kept.made[trial.trial] = answer + off(trial.settings) * TIME
                status = "diverged" if answer is None else "passed"
                records[trial.trial] = replace(
                    outcome(trial, status, ""),
                    trajectory_hash=None if answer is None else trial.trial,
                    substep=trial.settings.dt,
                    rough_cost=cost * (1 / 240) / trial.settings.dt,
                )
        cases: Any = {CASE.name: CASE}
        more = next_trials(trials, records, cases, adapters, store=kept, wanted=wanted)  # type: ignore[arg-type]
        if not more:
            return trials, records
        trials += more
    raise AssertionError("the search does not end")


def steps(trials: Sequence[Trial], engine: str, track: str = "tuned") -> list[int]:
    mine = [t for t in trials if (t.engine, t.track) == (engine, track) and not t.alteration.start]
    return sorted(round(1 / trial.settings.dt) for trial in mine)


def starts(trials: Sequence[Trial], engine: str) -> list[str]:
    return [trial.alteration.name for trial in trials if trial.engine == engine and trial.alteration.start]


def test_every_ladder_goes_down_to_the_finest_step_and_no_further_where_it_is_known() -> None:
    trials, _ = carried_out({"a": first_order, "b": first_order}, Refinement())
    for engine in ("a", "b"):
        for track in ("default", "tuned"):
            assert steps(trials, engine, track) == [240, 480, 960, 1920, 3840]
    assert not starts(trials, "a")
    assert len({trial.trial for trial in trials}) == len(trials)


def test_an_engine_that_explodes_when_coarse_is_given_finer_steps() -> None:
    trials, _ = carried_out({"a": first_order, "b": explodes_when_coarse}, Refinement())
    assert steps(trials, "b") == [240, 480, 960, 1920, 3840, 7680, 15360]
    assert steps(trials, "a")[-1] == 3840


def test_chaos_is_run_further_and_then_from_perturbed_starts() -> None:
    trials, _ = carried_out({"a": chaotic, "b": chaotic}, Refinement(members=3))
    assert steps(trials, "a")[-1] == 15360
    assert starts(trials, "a") == 2 * ["start 1", "start 2", "start 3"]  # on both tracks
    assert {round(1 / t.settings.dt) for t in trials if t.alteration.start} == {960}


def test_our_own_engine_is_no_second_one_whose_limit_is_known() -> None:
    laws: Mapping[str, Law] = {"a": chaotic, "b": first_order, "c": first_order}
    assert not starts(carried_out(laws, Refinement(members=2))[0], "a")
    assert starts(carried_out(laws, Refinement(members=2), ours="c")[0], "a")


def test_a_budget_ends_every_ladder_at_its_share() -> None:
    """Two engines on two tracks share 4 s: one each. Runs cost .1, .2, .4 s, .7 in all; the next would cost .8 more."""
    trials, records = carried_out({"a": first_order, "b": first_order}, Refinement(budget=4.0))
    assert steps(trials, "a") == [240, 480, 960]
    spent = sum(record.rough_cost * CASE.duration for record in records.values())
    assert spent <= 4.0
    trials, _ = carried_out({"a": first_order, "b": first_order}, Refinement(budget=7.0))
    assert steps(trials, "a") == [240, 480, 960, 1920]


def test_perturbed_starts_are_paid_for_by_what_a_ladder_left_or_by_a_third_of_its_share() -> None:
    """Runs at 1/240, 1/480 and 1/960 s take .1, .2 and .4 s, and the next one would take .8. Of a share of 1.4 s, .7 are left:
    three starts would take 1.2 at 1/960 s and .6 at 1/480 s. Of .925 s, .225 are left, but .308 are reserved: .3 at 1/240 s."""
    for budget, rate in ((4 * 1.4, 480), (4 * 0.925, 240)):
        trials, _ = carried_out({"a": chaotic, "b": chaotic}, Refinement(members=3, budget=budget))
        assert {round(1 / t.settings.dt) for t in trials if t.alteration.start} == {rate}


def test_perturbed_starts_differ_from_the_scene_and_from_each_other_and_are_the_same_again() -> None:
    """Off their places by a ten-thousandth of their width at most, on ground that is level to a ten-thousandth."""
    other, again, third = (Alteration(name=start_name(k), start=k).of(SCENE) for k in (1, 1, 2))
    assert other == again == perturbed(SCENE, 1)
    assert len({other.gravity, third.gravity, SCENE.gravity}) == 3
    tilt = np.arccos(np.dot(other.gravity, SCENE.gravity) / np.dot(SCENE.gravity, SCENE.gravity))
    assert tilt == pytest.approx(1e-4, rel=1e-3)
    assert Alteration.from_plain(Alteration(name="start 2", start=2).plain()) == Alteration(name="start 2", start=2)


TRACKS = {
    "default": Settings(iterations=5, options={"cone": "pyramid", "damping": 0.04}),
    "tuned": Settings(iterations=9, solver="newton", options={"cone": "round", "damping": 0.0, "steps": 2.0}),
}


def turned(trials: Sequence[Trial], engine: str = "a") -> list[str]:
    return [trial.track for trial in trials if trial.engine == engine and trial.alteration.name == TURNED]


def test_settings_are_turned_one_by_one_where_the_tracks_of_an_engine_end_apart() -> None:
    def off(settings: Settings) -> float:
        return 0.5 * (settings.options["cone"] == "pyramid")

    trials, _ = carried_out({"a": first_order, "b": first_order}, Refinement(), tracks=TRACKS, off=off)
    names = ["cone round", "damping 0.0", "iterations 9", "solver newton", "steps 2.0"]
    assert sorted(turned(trials)) == [f"default, {name}" for name in names]
    one_turned = [trial for trial in trials if trial.alteration.name == TURNED]
    assert {trial.settings.dt for trial in one_turned} == {1 / 960}
    assert not any(trial.alteration.clocked for trial in one_turned)
    for trial in one_turned:
        assert len(differing(TRACKS["default"], trial.settings)) == 1
    few, _ = carried_out({"a": first_order, "b": first_order}, Refinement(turns=2), tracks=TRACKS, off=off)
    assert len(turned(few)) == 2


def test_settings_are_turned_too_where_there_is_no_time_for_finer_steps() -> None:
    laws: Mapping[str, Law] = {"a": first_order, "b": first_order}
    off: Callable[[Settings], float] = lambda settings: 0.5 * (settings.options["cone"] == "pyramid")  # noqa: E731
    trials, _ = carried_out(laws, Refinement(), tracks=TRACKS, off=off, wanted=lambda _: False)
    assert steps(trials, "a") == [240, 480, 960]
    assert len(turned(trials)) == 5


def test_nothing_is_turned_where_the_tracks_end_alike() -> None:
    trials, _ = carried_out({"a": first_order, "b": first_order}, Refinement(), tracks=TRACKS)
    assert turned(trials) == []


def test_turns_are_paid_for_by_the_share_of_their_side() -> None:
    """A share of 1 s has .3 left after .1, .2 and .4 s; a third of it is reserved, and no run at 1/960 s takes less than .4."""
    trials, _ = carried_out(
        {"a": first_order, "b": first_order},
        Refinement(budget=4.0),
        tracks=TRACKS,
        off=lambda settings: 0.5 * (settings.options["cone"] == "pyramid"),
    )
    assert turned(trials) == []


def test_what_an_engine_adds_and_what_acts_on_the_scene_come_first() -> None:
    adapter = Made(
        name="a", title="a", tracks=TRACKS, knobs={"options.steps": (2.0,), "options.cone": ("pyramid", "round")},
        acts_on={"options.cone": Effect.CONTACT, "options.steps": Effect.GRAVITY},
    )  # fmt: skip
    base, target = (
        Trial(
            study="s", experiment=Experiment(name="e"), case=CASE.name, parameters={}, engine="a", engine_version="1",
            track=track, settings=TRACKS[track], seed=0,
        )
        for track in ("default", "tuned")
    )  # fmt: skip
    record = replace(outcome(base, "passed", ""), warnings=(StoredNotice("it damps", "surplus", "linear_damping"),))
    order = [turn.name for turn in candidates(base, target, record, CASE, adapter)]
    assert order[:2] == ["damping", "steps"]
    assert "cone" not in order  # nothing touches here


def turn(setting: str, closes: float | None, cause: bool = False) -> Turned:
    return Turned(
        case="c", where="", engine="a", track="default", setting=setting, value="round", towards="tuned", dt=1e-3, before=0.5,
        after=None if closes is None else 0.5 * (1 - closes), why="", closes=closes, cause=cause, trial="t",
    )  # fmt: skip


def test_a_cause_is_named_where_it_closes_the_distance_and_no_single_one_elsewhere() -> None:
    agreement = Agreement(case="c", where="", duration=1.0, scale=extent(SCENE), granted=0.0, sides=(), differences=())
    (named,) = cause_words([turn("cone", 0.97, True), turn("steps", 0.1)], agreement, {"a": "Engine A"})
    away = f"Engine A, default, ends {length(0.5, agreement)} from its tuned track"
    assert named == f"{away}: 'cone' turned to round alone closes 97 % of that."
    (none,) = cause_words([turn("steps", 0.797), turn("steps", 0.2), turn("cone", None)], agreement, {})
    assert "no single setting closes 80 % of that, of 3 turns tried (steps and cone); 'steps' closes most, 79 %." in none
