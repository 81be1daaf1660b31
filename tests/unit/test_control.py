"""Forces from outside: when the law is asked, what it is shown, and what each engine makes of a force that is held."""

from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from plumbline.harness.adapter import Adapter, Settings, Unavailable
from plumbline.harness.case.forces import Control, Controlled, wrench_after
from plumbline.harness.scene import Body, Scene, sphere_inertia
from plumbline.harness.study import plugins
from plumbline.harness.study.experiment import Experiment
from plumbline.harness.study.study import Study
from plumbline.harness.study.trial import Trial
from plumbline.harness.trajectory import Floats, State
from plumbline.harness.trial.accuracy import run_trial
from plumbline.harness.trial.bench import Bench

DT = 0.01
BALL = Scene(bodies=(Body(name="ball", mass=2.0, inertia=sphere_inertia(2.0, 0.1)),), gravity=(0.0, 0.0, 0.0))


class Noted:
    """A simulation that notes what it is told and stands at x = 1 m, moving at 3 m/s, turning at 2 rad/s about z."""

    def __init__(self, lead: float | None = None) -> None:
        self.told: list[tuple[str, float]] = []
        if lead is not None:
            self.force_lead = lead

    def state(self, out: State) -> None:
        out.p_WB[:], out.v_WB[:], out.w_WB[:] = (1.0, 0.0, 0.0), (3.0, 0.0, 0.0), (0.0, 0.0, 2.0)
        out.q_WB[:] = (1.0, 0.0, 0.0, 0.0)

    def wrench(self, f_B_W: Floats, tau_B_W: Floats) -> None:
        self.told.append(("wrench", float(f_B_W[0, 0])))

    def step(self, count: int = 1) -> None:
        self.told.append(("step", count))


def _of_time(time: float, state: State) -> tuple[Floats, Floats]:
    return np.full((1, 3), time), np.zeros((1, 3))


def _controlled(simulation: Noted, control: Control) -> Controlled:
    return Controlled(simulation, control, DT, 1)  # type: ignore[arg-type]


def test_a_law_is_told_before_each_step_or_held_for_its_interval() -> None:
    each = Noted()
    _controlled(each, Control(wrench=_of_time)).step(2)
    assert each.told == [("wrench", 0.0), ("step", 1), ("wrench", DT), ("step", 1)]
    held = Noted()
    control = _controlled(held, Control(wrench=_of_time, interval=4 * DT))
    control.step(3)
    control.step(6)
    assert held.told == [
        ("wrench", 0.0), ("step", 3), ("step", 1), ("wrench", pytest.approx(4 * DT)), ("step", 4),
        ("wrench", pytest.approx(8 * DT)), ("step", 1),
    ]  # fmt: skip


def test_a_law_is_shown_the_state_as_it_is_or_where_the_engine_wants_its_force() -> None:
    seen: list[tuple[float, float, float]] = []

    def law(time: float, state: State) -> tuple[Floats, Floats]:
        seen.append((time, state.p_WB[0, 0], 2 * np.arctan2(state.q_WB[0, 3], state.q_WB[0, 0])))
        return np.zeros((1, 3)), np.zeros((1, 3))

    for lead in (None, 0.5):
        _controlled(Noted(lead), Control(wrench=law)).step()
    assert seen[0] == (0.0, 1.0, 0.0)
    assert seen[1] == pytest.approx((DT / 2, 1.0 + 3.0 * DT / 2, 2.0 * DT / 2), rel=1e-12)


def test_a_law_of_time_is_asked_at_the_start_of_its_interval_whatever_the_engine() -> None:
    held = Noted(lead=0.5)
    _controlled(held, Control(wrench=_of_time, interval=DT)).step(2)
    assert held.told == [("wrench", 0.0), ("step", 1), ("wrench", DT), ("step", 1)]


def _engines() -> Iterator[tuple[Adapter, str, Settings]]:
    for name in ("reference", "mujoco", "bullet", "dart"):
        adapter = plugins.adapter(name)
        for track in ("default", "tuned"):
            yield adapter, track, adapter.tracks[track]
    ours, theirs = plugins.adapter("reference"), plugins.adapter("mujoco")
    for integrator in ("explicit_euler", "velocity_verlet", "implicit_midpoint", "splitting_4"):
        yield ours, integrator, replace(ours.tracks["default"], integrator=integrator)
    for cut in (theirs, plugins.adapter("bullet")):
        yield cut, "4 sub-steps", replace(cut.tracks["default"], substeps=4)


@pytest.mark.parametrize(("adapter", "track", "settings"), [pytest.param(*e, id=f"{e[0].name}-{e[1]}") for e in _engines()])
def test_an_engine_says_where_in_a_step_a_force_that_it_holds_belongs(adapter: Adapter, track: str, settings: Settings) -> None:
    try:
        simulation = adapter.build(BALL, settings.with_dt(DT))
    except Unavailable as reason:
        pytest.skip(str(reason))
    try:
        simulation.wrench(np.array([[2.0, 0.0, 0.0]]), np.zeros((1, 3)))
        simulation.step()
        end = State.empty(1)
        simulation.state(end)
        # From rest under 1 m/s2: x = c dt^2. Damping of 0.04/s, where a default has it, takes 4e-4 of that.
        assert 1.0 - end.p_WB[0, 0] / DT**2 == pytest.approx(getattr(simulation, "force_lead", 0.0), abs=1e-3)
    finally:
        simulation.close()


def _trial(case: Any, adapter: Adapter, dt: float) -> Trial:
    study = Study(name="s", experiments=(Experiment(name="e", cases=(case.name,), tracks=("tuned",), dt=(dt,), timing=False),))
    return next(iter(study.trials({case.name: case}, {adapter.name: adapter}, {adapter.name: "1"})))


def test_a_trial_and_its_clock_run_under_the_control_and_its_name_depends_on_it() -> None:
    case, adapter = replace(plugins.case("orbit_kepler"), duration=1.0), plugins.adapter("reference")
    trial = _trial(case, adapter, 1 / 240)
    record = run_trial(trial, case, adapter, None)
    measured = {m.metric: m.value for m in record.measurements}
    # Force-free the planet would leave in a straight line, metres away after one turn.
    assert measured["position_error_final"] < 0.01
    bench = Bench(case, adapter, trial)
    bench.clock(240)
    end = State.empty(1)
    bench._simulation.state(end)
    assert np.linalg.norm(end.p_WB[0] - case.scene(case.parameters).bodies[0].p_WB) < 0.01
    bench.stop()
    weaker = replace(case, control=lambda _: Control(wrench=_of_time))
    assert _trial(weaker, adapter, 1 / 240).trial != trial.trial
    start = State.initial(case.scene(case.parameters))
    assert wrench_after(case.control(case.at(eccentricity=0.5)), start) != wrench_after(Control(wrench=_of_time), start)  # type: ignore[misc]
