"""Steps of uneven lengths: the recorded sequence, honest times, closed forms under it, and what refuses it."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from plumbline.harness.adapter import Feature, Settings, SettingsError, Unsupported
from plumbline.harness.case.forces import Control, Controlled
from plumbline.harness.metric import Metric, NotMeasurable
from plumbline.harness.scene import Body, Scene
from plumbline.harness.study import plugins
from plumbline.harness.study.experiment import StudyError, Variant
from plumbline.harness.study.study import load_study
from plumbline.harness.study.trial import Trial
from plumbline.harness.trajectory import State, Trajectory
from plumbline.harness.trajectory.pace import PACES, Pace
from plumbline.harness.trial.accuracy import run_trial
from plumbline.harness.trial.answer import answer_of
from plumbline.harness.trial.equivalent_runs import paced
from plumbline.harness.trial.simulate import simulate

DT, G = 1 / 240, 9.81
FALL = plugins.case("flight_projectile")


def test_the_mean_step_is_dt_and_a_cycle_takes_as_long_as_even_steps() -> None:
    pace, count = Pace.of("loaded", DT), len(PACES["loaded"])
    lengths = np.array([pace.length(k) for k in range(2 * count)])
    assert lengths.mean() == pytest.approx(DT, rel=1e-15)
    assert (lengths[:count] == lengths[count:]).all()
    assert pace.time(2 * count) == pytest.approx(2 * count * DT, rel=1e-15)
    assert pace.longest == lengths.max() > 2 * DT > DT > 2 * DT / 3 > lengths.min()
    assert lengths[:count] / DT == pytest.approx(np.array(PACES["loaded"]) / np.mean(PACES["loaded"]), rel=1e-15)


def test_times_are_the_sums_of_the_lengths_and_lead_back_to_their_steps() -> None:
    pace = Pace.of("loaded", DT)
    ends = np.cumsum([pace.length(k) for k in range(1100)])
    for steps in (1, 2, 479, 480, 481, 1100):
        assert pace.time(steps) == pytest.approx(ends[steps - 1], rel=1e-12)
        assert pace.steps(pace.time(steps)) == steps
        assert pace.since(steps).length(3) == pace.length(steps + 3)
    assert pace.span(470, 20) == pytest.approx(ends[489] - ends[469], rel=1e-12)


def test_even_steps_keep_their_bits() -> None:
    pace = Pace(DT)
    for steps in (0, 1, 7, 481, 100_003):
        assert (pace.time(steps), pace.span(5, steps), pace.length(steps)) == (steps * DT, steps * DT, DT)
    assert pace.since(9) is pace
    assert paced(None, pace) is None  # type: ignore[arg-type]
    assert "pace" not in Settings().plain()


def test_a_pace_that_there_is_not_is_refused_by_name() -> None:
    with pytest.raises(SettingsError, match="pace 'slow', expected one of loaded"):
        Settings(pace="slow")


def _trial(engine: str, **settings: Any) -> Trial:
    (experiment, *_) = load_study("uneven_steps").experiments
    adapter = plugins.adapter(engine)
    return Trial(
        study="s", experiment=experiment, case=FALL.name, parameters=dict(FALL.parameters), engine=engine, engine_version="",
        track="default", settings=replace(adapter.tracks["default"], **settings), seed=0,
    ).named()  # fmt: skip


SUBSTEPS = {"reference": 4, "mujoco": 1, "bullet": 1, "dart": 1}


@pytest.mark.parametrize("engine", SUBSTEPS)
def test_free_fall_is_the_explicit_sum_of_semi_implicit_euler(engine: str) -> None:
    """v_n = -g t_n and z_n = -g sum_k h_k t_k, exactly; in s sub-steps a step adds h t_{k-1} + h^2 (s + 1)/(2 s)."""
    adapter = plugins.adapter(engine)
    if plugins.version_of(adapter)[1] is not None:
        pytest.skip(f"{engine} is not installed")
    scene, pace, s = Scene(bodies=(Body(name="body"),)), Pace.of("loaded", DT), SUBSTEPS[engine]
    options = {"damping": "scene"} if engine == "bullet" else {}
    simulation = adapter.build(scene, replace(adapter.tracks["default"], options=options))
    steps = 600  # more than one cycle
    run, broke = simulate(
        paced(simulation, pace), scene, pace=pace, duration=steps * DT, sample_interval=0.0, with_contacts=False, seed=0
    )
    simulation.close()
    h = np.array([pace.length(k) for k in range(steps)])
    t = np.concatenate(([0.0], np.cumsum(h)))
    z = -G * np.concatenate(([0.0], np.cumsum(h * t[:-1] + h * h * (s + 1) / (2 * s))))
    assert broke is None
    assert not run.even
    assert run.time == pytest.approx(t, abs=1e-12)
    # Each step rounds a sum of the size of the values once.
    assert run.v_WB[:, 0, 2] == pytest.approx(-G * t, abs=steps * 2.0**-52 * G * t[-1])
    assert run.p_WB[:, 0, 2] == pytest.approx(z, abs=steps * 2.0**-52 * abs(z[-1]) * 2)


@pytest.mark.parametrize("engine", SUBSTEPS)
def test_the_same_uneven_run_again_gives_the_same_bits_and_others_than_the_even_one(engine: str) -> None:
    if plugins.version_of(plugins.adapter(engine))[1] is not None:
        pytest.skip(f"{engine} is not installed")
    adapter = plugins.adapter(engine)
    even, uneven = _trial(engine), _trial(engine, pace="loaded")
    assert even.trial != uneven.trial
    runs = [answer_of(trial, trial.problem(FALL), adapter) for trial in (uneven, uneven, even)]
    assert runs[0].actual.p_WB.tobytes() == runs[1].actual.p_WB.tobytes() != runs[2].actual.p_WB.tobytes()
    assert runs[0].steps == runs[2].steps == round(FALL.duration / DT)
    assert runs[0].resolved["pace"] == "loaded"
    assert "pace" not in runs[2].resolved
    assert runs[0].sim_seconds == runs[0].actual.time[-1]


def test_an_engine_without_the_feature_is_not_asked() -> None:
    adapter = plugins.adapter("reference")
    deaf = replace(adapter, features=adapter.features & ~Feature.STEP_LENGTHS)
    record = run_trial(_trial("reference", pace="loaded"), FALL, deaf, None)
    assert record.status == "unsupported"
    assert "steps at the pace 'loaded'" in record.reason


def test_what_reckons_with_even_steps_is_not_measurable() -> None:
    metric = Metric(name="m", unit="1", source="s", measure=lambda *_: 1.0, even=True)
    run = Trajectory.of(np.arange(3.0), 1)
    scene = Scene(bodies=(Body(name="body"),))
    assert metric(scene, run) == 1.0
    with pytest.raises(NotMeasurable, match="those of this run are uneven"):
        metric(scene, replace(run, even=False))
    assert replace(metric, even=False)(scene, replace(run, even=False)) == 1.0


def test_sensors_refuse_uneven_steps() -> None:
    case = plugins.case("sensor_imu_rest")
    scene = case.scene(case.parameters)
    with pytest.raises(Unsupported, match="sensors under uneven steps"):
        simulate(
            None, scene, pace=Pace.of("loaded", DT), duration=1.0, sample_interval=0.0, with_contacts=False, seed=0  # type: ignore[arg-type]
        )  # fmt: skip


class _Listening:
    """Takes no steps and remembers when it was told a force."""

    force_lead = 0.5

    def __init__(self) -> None:
        self.lengths: list[float] = []

    def retime(self, dt: float) -> None:
        self.lengths.append(dt)

    def step(self, count: int = 1) -> None:
        assert count == 1

    def state(self, out: State) -> None:
        out.p_WB[:] = out.v_WB[:] = out.w_WB[:] = 0.0

    def wrench(self, f_B_W: Any, tau_B_W: Any) -> None:
        pass


def test_a_law_of_forces_is_asked_at_the_true_times() -> None:
    asked: list[float] = []

    def law(time: float, _state: State) -> tuple[Any, Any]:
        asked.append(time)
        return np.zeros((1, 3)), np.zeros((1, 3))

    pace, inner = Pace.of("loaded", DT), _Listening()
    Controlled(paced(inner, pace), Control(wrench=law), pace, 1).step(500)  # type: ignore[arg-type]
    assert inner.lengths == [pace.length(k) for k in range(500)]
    assert asked == pytest.approx([pace.time(k) + pace.length(k) / 2 for k in range(500)], rel=1e-12)


def test_a_study_that_would_clock_uneven_steps_is_refused() -> None:
    study = load_study("uneven_steps")
    timed = replace(study, experiments=(replace(study.experiments[0], timing=True),))
    cases, adapters = {FALL.name: FALL}, {"reference": plugins.adapter("reference")}
    with pytest.raises(StudyError, match="pace 'loaded', expected timing = false"):
        list(timed.trials(cases, adapters, {"reference": "1"}))
    tracks = {trial.track for trial in study.trials(cases, adapters, {"reference": "1"})}
    assert tracks == {"default", "tuned", "uneven", "uneven one stiffness", "uneven tuned"}
    assert Variant(pace="loaded").over(adapters["reference"].tracks).pace == "loaded"
