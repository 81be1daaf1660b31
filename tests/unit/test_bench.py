"""The bench: what is inside the clock and what is not, counted on simulations that count; no time is asserted."""

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from plumbline.harness.adapter import Settings
from plumbline.harness.case import Clocks
from plumbline.harness.run.timing_protocol import summarise
from plumbline.harness.store.record import Sample
from plumbline.harness.study import plugins
from plumbline.harness.study.experiment import Experiment
from plumbline.harness.study.foreseen_cost import scene_at
from plumbline.harness.study.trial import Trial
from plumbline.harness.trajectory import State
from plumbline.harness.trial.bench import (
    TOGETHER,
    Bench,
    NotClocked,
    Sampling,
    calibrate,
    caster,
    rough_cost,
    rough_cost_beside,
)  # fmt: skip

DT = 1 / 240
SOUND_START = Bench.start
PILE = plugins.case("stack_pile")


class Counting:
    """Counts what is asked of it."""

    def __init__(self, told: list[tuple[str, int]]) -> None:
        self.told = told
        told.append(("build", 1))

    def step(self, count: int = 1) -> None:
        self.told.append(("step", count))

    def state(self, out: Any) -> None:
        self.told.append(("state", id(out)))

    def wrench(self, *of: Any) -> None:
        self.told.append(("wrench", 1))

    def cast(self, origins: Any, directions: Any, max_range: float) -> None:
        self.told.append(("cast", len(origins)))

    def close(self) -> None:
        self.told.append(("close", 1))


class Maker:
    """An adapter that makes counting simulations, and batches of them."""

    def __init__(self) -> None:
        self.told: list[tuple[str, int]] = []

    def build(self, scene: object, settings: object) -> Counting:
        return Counting(self.told)

    def build_batch(self, scene: object, settings: object, count: int) -> Counting:
        self.told.append(("worlds", count))
        return Counting(self.told)


def bench(case: Any, clocks: Clocks = "work", **parameters: Any) -> tuple[Bench, Maker]:
    maker = Maker()
    trial = Trial(
        trial="t",
        study="s",
        experiment=Experiment(name="e"),
        case=case.name,
        parameters=dict(case.parameters) | parameters,
        engine="x",
        engine_version="1",
        track="tuned",
        settings=Settings(dt=DT),
        seed=0,
        clocks=clocks,
    )
    return Bench(case, maker, trial), maker  # type: ignore[arg-type]


def steps(told: list[tuple[str, int]]) -> list[int]:
    return [count for what, count in told if what == "step"]


def test_a_steady_case_is_clocked_from_its_steady_time_to_its_end() -> None:
    made, maker = bench(PILE, n=4)
    before, whole = round(PILE.steady * 240), round((PILE.duration - PILE.steady) * 240)  # type: ignore[operator]
    assert not made.endless
    assert made.whole == whole
    made.clock(50)
    made.clock(50)
    assert steps(maker.told) == [before, 50, 50]
    made.clock(50)  # the run ends after 20 of them
    assert steps(maker.told)[3:] == [whole - 100, before, 150 - whole]
    assert [what for what, _ in maker.told].count("build") == 2
    trial = made._trial
    unsettled = Bench(PILE, maker, trial, settled=False)  # type: ignore[arg-type]
    maker.told.clear()
    unsettled.clock(50)
    assert steps(maker.told) == [50]
    assert unsettled.whole == before + whole


def test_another_case_is_clocked_from_its_start_in_whole_runs() -> None:
    made, maker = bench(plugins.case("flight_box"))
    assert not made.endless
    made.clock(2 * made.whole)
    assert steps(maker.told) == [made.whole, made.whole]
    assert [what for what, _ in maker.told if what != "step"] == ["build", "close", "build"]


def test_worlds_are_stepped_together_a_few_steps_at_a_time() -> None:
    made, maker = bench(PILE, n=4, worlds=7)
    assert made.units == 7
    made.clock(2 * TOGETHER + 1)
    assert ("worlds", 7) in maker.told
    assert steps(maker.told)[1:] == [TOGETHER, TOGETHER, 1]


def test_rays_are_cast_instead_of_steps_and_counted_one_by_one() -> None:
    case = plugins.case("system_rays")
    made, maker = bench(case, thin=64)
    rays = case.rays(case.at(pattern="lidar", thin=64))  # type: ignore[misc]
    assert made.units == len(rays.origins) == 32 * 1024 // 64
    made.clock(3)
    assert [count for what, count in maker.told if what == "cast"] == [made.units] * 3
    assert steps(maker.told) == []


def test_reading_takes_single_steps_and_reads_into_the_same_arrays_after_each() -> None:
    made, maker = bench(PILE, "reading", n=4)
    assert (made.units, made.endless) == (1, False)
    made.clock(3)
    told = maker.told[2:]  # after building and the way to where the clock starts
    assert [what for what, _ in told] == ["step", "state"] * 3
    assert [count for what, count in told if what == "step"] == [1, 1, 1]
    assert len({out for what, out in told if what == "state"}) == 1


def test_reading_under_a_control_leaves_the_law_outside_the_clock(monkeypatch: pytest.MonkeyPatch) -> None:
    made, maker = bench(plugins.case("system_scaling"), "reading", n=2)
    made.clock(1)
    clocked: list[str] = []

    def clock(call: Any, count: int) -> tuple[float, float]:
        before = len(maker.told)
        for _ in range(count):
            call()
        clocked.extend(what for what, _ in maker.told[before:])
        return 0.0, 0.0

    monkeypatch.setattr("plumbline.harness.trial.bench.clock_calls", clock)
    made.start()
    begun = len(maker.told)
    made.clock(9)
    assert clocked == ["step", "state"] * 9
    # The control reads the state once for itself each time that it tells the forces.
    outside = len(maker.told) - begun - 18
    assert outside == 2 * [what for what, _ in maker.told[begun:]].count("wrench") > 0


def test_an_empty_call_takes_no_step_and_never_ends_a_run(monkeypatch: pytest.MonkeyPatch) -> None:
    made, maker = bench(plugins.case("flight_box"), "call")
    made.clock(1000)
    made.clock(1000)
    assert steps(maker.told) == [0] * 2000
    assert [what for what, _ in maker.told if what != "step"] == ["build"]
    start = Bench.start

    def slow(self: Bench) -> None:
        start(self)
        self.starting = 10.0

    monkeypatch.setattr(Bench, "start", slow)
    monkeypatch.setattr(Bench, "clock", lambda _, count: (1e-6 * count, 1e-6 * count))
    assert made.endless
    assert calibrate(made, 0.01) == Sampling(10_000)  # built once, so building cuts no sample short


@pytest.mark.parametrize("engine", ["bullet", "dart", "mujoco", "reference"])
@pytest.mark.parametrize("case", ["flight_box", "stack_pile"])
def test_a_call_without_a_step_changes_no_bit_of_what_comes(engine: str, case: str) -> None:
    adapter, scene = plugins.adapter(engine), scene_at(plugins.case(case), {})
    if (reason := plugins.version_of(adapter)[1]) is not None:
        pytest.skip(reason)
    ends = []
    for empty in (0, 3):
        simulation, out = adapter.build(scene, adapter.tracks["default"]), State.empty(len(scene.bodies))
        simulation.step(4)
        simulation.state(out)
        before = out.p_WB.copy()
        for _ in range(empty):
            simulation.step(0)
        simulation.state(out)
        np.testing.assert_array_equal(out.p_WB, before)
        simulation.step(4)
        simulation.state(out)
        assert (out.p_WB != before).any()
        ends.append([getattr(out, name).tobytes() for name in ("p_WB", "q_WB", "v_WB", "w_WB")])
        simulation.close()
    assert ends[0] == ends[1]


class Clockwork:
    """Time that passes by what is done: steps at a price that may change on the way, and building."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch, step: Callable[[int], float], building: float = 0.0) -> None:
        """Args: step: seconds of the k-th step of a run, from 0. building [s]: of each start."""
        self.step, self.clocked, self.starts = step, 0, 0
        begin = SOUND_START

        def start(bench: Bench) -> None:
            begin(bench)
            self.starts += 1
            bench.starting = building

        def advance(bench: Bench, count: int) -> tuple[float, float]:
            spent = sum(self.step(k) for k in range(bench._here, bench._here + count))
            self.clocked += count
            return spent, spent

        monkeypatch.setattr(Bench, "start", start)
        monkeypatch.setattr(Bench, "_step", advance)


@pytest.mark.parametrize("case", [plugins.case("flight_box"), PILE], ids=lambda case: case.name)
def test_a_sample_is_of_whole_runs_however_long_one_takes(monkeypatch: pytest.MonkeyPatch, case: Any) -> None:
    made, _ = bench(case)
    for cost in (1e-7, 1e-5, 1e-3, 1e-1):
        Clockwork(monkeypatch, lambda _, cost=cost: cost)  # type: ignore[misc]
        sampling = calibrate(made, 0.01)
        assert sampling.run == made.whole
        assert sampling.steps % made.whole == 0
        assert sampling.steps * cost >= min(0.01, made.whole * cost) * (1 - 1e-9)
        # A run of ten samples' length is long: three of them will do.
        assert sampling.most == (3 if made.whole * cost > 0.1 else None)


def test_a_price_is_that_of_a_whole_run_where_steps_get_ten_times_cheaper_half_way(monkeypatch: pytest.MonkeyPatch) -> None:
    """A body that slides costs 1 ms a step, and one that lies still .1 ms; a run is of half as many steps of each."""
    made, _ = bench(plugins.case("flight_box"))
    half = made.whole // 2
    clockwork = Clockwork(monkeypatch, lambda k: 1e-3 if k < half else 1e-4)
    sampling = calibrate(made, 0.001)
    assert clockwork.clocked < half, "its dear half alone was seen before the clock"
    made.start()
    cost = made.clock(sampling.steps)[0] / sampling.steps
    assert cost == pytest.approx((1e-3 * half + 1e-4 * (made.whole - half)) / made.whole, rel=1e-12)
    assert rough_cost(bench(plugins.case("flight_box"))[0], 1e-4) * DT == pytest.approx(cost, rel=1e-9)
    own, beside = (bench(plugins.case("flight_box"))[0] for _ in range(2))
    assert rough_cost_beside(own, beside, 1e-4) == pytest.approx((cost / DT, 1.0), rel=1e-9)


def test_a_run_that_does_not_fit_its_deadline_is_not_clocked_and_never_in_part(monkeypatch: pytest.MonkeyPatch) -> None:
    made, _ = bench(plugins.case("flight_box"))
    Clockwork(monkeypatch, lambda _: 0.01)
    run = 0.01 * made.whole
    assert calibrate(made, 0.01, 3.1 * run).most == 3
    assert calibrate(made, 0.01, 2.9 * run).most == 1
    assert calibrate(made, 0.01, 1.1 * run) == Sampling(made.whole, made.whole, 1)
    with pytest.raises(NotClocked, match=r"a whole run does not fit the 1 s of a trial: 0 s to build and .* of 240 steps"):
        calibrate(made, 0.01, 1.0)
    Clockwork(monkeypatch, lambda _: 0.001, building=2.0)
    with pytest.raises(NotClocked, match="2 s to build"):
        calibrate(made, 0.01, 1.0)


def test_a_run_whose_steps_get_dearer_is_warmed_up_over_all_of_it_where_it_may_not_fit(monkeypatch: pytest.MonkeyPatch) -> None:
    made, _ = bench(plugins.case("flight_box"))
    half = made.whole // 2
    Clockwork(monkeypatch, lambda k: 1e-3 if k < half else 1e-2)
    with pytest.raises(NotClocked):
        calibrate(made, 0.001, 0.3)  # its beginning foretells .24 s, it takes 1.3


def test_runs_that_cost_more_to_build_than_to_clock_make_shorter_samples(monkeypatch: pytest.MonkeyPatch) -> None:
    """A run of 240 microseconds that takes 10 ms to build: 0.1 s of clock would be 4.2 s of building, 0.3 s are granted."""
    short, _ = bench(plugins.case("flight_box"))
    Clockwork(monkeypatch, lambda _: 1e-6, building=0.01)
    # The first step of the run that is timed before goes by unclocked.
    runs = int(3 * 0.1 / (0.01 + (short.whole - 1) * 1e-6))
    assert calibrate(short, 0.1) == Sampling(runs * short.whole, short.whole)
    assert calibrate(short, 1e-4) == Sampling(short.whole, short.whole)


def test_a_price_is_that_of_one_ray_or_one_world() -> None:
    trial = Trial(
        trial="t", study="s", experiment=Experiment(name="e"), case="c", parameters={}, engine="x", engine_version="1",
        track="tuned", settings=Settings(dt=0.01), seed=0,
    )  # fmt: skip
    sample = Sample(process=0, block=0, steps=100, units=50, cpu=0.5, wall=1.0, canary=0.001, switches=0)
    rays = summarise(trial, [sample] * 3, unit="ray")
    assert rays.cpu_per_unit == pytest.approx(1e-4)
    assert rays.cpu_per_sim_s is None
    worlds = summarise(trial, [sample] * 3, unit="world-step")
    assert worlds.cpu_per_unit == pytest.approx(1e-4)
    assert worlds.cpu_per_sim_s == pytest.approx(1e-2)
    read = summarise(trial, [replace(sample, units=1)] * 3, unit="read-step")
    assert read.cpu_per_unit == pytest.approx(5e-3)
    assert read.cpu_per_sim_s is None  # the price of a simulated second is that of stepping alone
    alone = summarise(trial, [replace(sample, units=1)] * 3)
    assert alone.unit == "step"
    assert alone.cpu_per_unit == pytest.approx(alone.cpu_per_sim_s * 0.01)  # type: ignore[operator]


@pytest.mark.parametrize("engine", ["mujoco", "bullet"])
def test_rays_cast_into_arrays_made_beforehand_hit_what_other_rays_hit(engine: str) -> None:
    case, adapter = plugins.case("system_rays"), plugins.adapter(engine)
    rays = case.rays(case.at(pattern="lidar", thin=16))  # type: ignore[misc]
    simulation = adapter.build(case.scene(case.parameters), adapter.tracks["tuned"])
    usual = simulation.cast(rays.origins, rays.directions, rays.max_range)
    cast = caster(simulation, rays)
    assert getattr(cast, "func", None) is None, "the adapter offers a call of its own"
    first, second = cast(), cast()
    if engine == "mujoco":
        geom, distance, _ = second  # type: ignore[misc]
        found = np.where((geom >= 0) & (distance <= rays.max_range), distance, np.inf)
    else:
        hits = [hit for part in second for hit in part]  # type: ignore[attr-defined]
        found = np.array([hit[2] * rays.max_range if hit[0] >= 0 else np.inf for hit in hits])
        assert first == second
    np.testing.assert_allclose(found, usual.distance, rtol=1e-12)
    simulation.close()


def test_a_rough_ratio_holds_on_a_machine_that_slows_down_for_a_while(monkeypatch: pytest.MonkeyPatch) -> None:
    """A step of 3 us at 1/240 s beside one of 2 us at 1/120 s: three times the cost of a second, whatever the machine does."""
    own, _ = bench(PILE, n=4)
    beside, _ = bench(PILE, n=4)
    beside.dt = 2 * own.dt
    now = [0.0]

    def clock(self: Bench, count: int) -> tuple[float, float]:
        slow = 1.0 + 0.9 * (now[0] > 0.004)
        spent = (3e-6 if self is own else 2e-6) * count * slow
        now[0] += spent
        return spent, spent

    monkeypatch.setattr(Bench, "clock", clock)
    cost, ratio = rough_cost_beside(own, beside)
    assert ratio == pytest.approx(3.0, rel=1e-12)
    assert 3e-6 / own.dt <= cost * (1 + 1e-12) <= 1.9 * 3e-6 / own.dt


class _Broken(Exception):
    """A clock that raises."""


@pytest.mark.parametrize("broken", [0, 1])
def test_benches_are_stopped_where_a_rough_clock_raises(monkeypatch: pytest.MonkeyPatch, broken: int) -> None:
    """Whichever of two it is; what they built would stay alive beside the one that is tried next."""
    sides = [bench(PILE, n=4)[0] for _ in range(2)]
    sound = Bench.clock

    def clock(self: Bench, count: int) -> tuple[float, float]:
        if self is sides[broken]:
            raise _Broken
        return sound(self, count)

    monkeypatch.setattr(Bench, "clock", clock)
    with pytest.raises(_Broken):
        rough_cost_beside(sides[0], sides[1])
    assert [side._simulation for side in sides] == [None, None]
    with pytest.raises(_Broken):
        rough_cost(sides[broken])
    assert sides[broken]._simulation is None
