"""Inside the clock is the engine and nothing of the harness: watched call by call and byte by byte; no time is asserted."""

from collections import Counter
from typing import Any

import pytest

from plumbline.harness.adapter import Adapter, Settings, Simulation
from plumbline.harness.scene import Scene
from plumbline.harness.study import plugins
from plumbline.harness.trajectory import State
from tests.conformance.clocked_loop import Called, clocked_calls, growth, made
from tests.planted_faults.planting import plant

READING = {"state", "contacts", "cast", "render", "save", "warnings", "resolved"}
"""What the harness asks of a simulation beside `step`."""
TELLING = {"builtins.print", "builtins.open", "posix.write"}
TOWER = plugins.case("stack_tower")


def installed(name: str) -> Adapter:
    adapter = plugins.adapter(name)
    if reason := plugins.version_of(adapter)[1]:
        pytest.skip(f"{name}: {reason}")
    return adapter


def trespassers(calls: Counter[Called]) -> set[str]:
    """Functions of the harness, of reading and of logging."""
    return {
        called.name
        for called in calls
        if called.file.startswith("harness/")
        or (called.file.startswith("adapters/") and called.name.rpartition(".")[2] in READING)
        or "logging" in called.file
        or called.name in TELLING
    }


class Chatty:
    """A simulation that keeps its state at every step."""

    def __init__(self, inner: Simulation, bodies: int) -> None:
        self.inner, self.bodies, self.log = inner, bodies, list[State]()

    def step(self, count: int = 1) -> None:
        for _ in range(count):
            self.inner.step(1)
            self.log.append(State.empty(self.bodies))
            self.inner.state(self.log[-1])

    def close(self) -> None:
        self.inner.close()


def chatty(adapter: Adapter) -> Adapter:
    def wrap(inner: Simulation, adapter: Adapter, scene: Scene, settings: Settings) -> Any:
        return Chatty(inner, len(scene.bodies))

    return plant(adapter, simulation=wrap)


@pytest.mark.parametrize("engine", ["mujoco", "reference", "bullet", "dart"])
def test_between_two_readings_of_the_clock_only_the_engines_step_runs(engine: str) -> None:
    one = made(TOWER, installed(engine))
    one.clock(50)
    calls = clocked_calls(one, 50)
    one.stop()
    assert trespassers(calls) == set()
    ((called, times),) = ((called, times) for called, times in calls.items() if called.by.startswith("harness/"))
    assert (called.by, times) == ("harness/trial/bench.py", 1)
    assert called.file in (f"adapters/{engine}.py", f"adapters/{engine}/simulation.py")
    assert called.name.endswith(".step")


@pytest.mark.parametrize("engine", ["mujoco", "reference"])
def test_an_engine_that_steps_in_one_native_call_runs_no_more_python_in_ten_times_as_many_steps(engine: str) -> None:
    one = made(TOWER, installed(engine))
    one.clock(50)
    few, many = clocked_calls(one, 50), clocked_calls(one, 500)
    one.stop()
    assert few == many


@pytest.mark.parametrize("engine", ["mujoco", "reference"])
def test_nothing_of_ours_grows_with_the_steps(engine: str) -> None:
    """What is kept once a step takes a byte at least, and a reference eight."""
    one = made(TOWER, installed(engine))
    one.clock(50)
    few, many = growth(lambda: one.clock(50)), growth(lambda: one.clock(550))
    one.stop()
    assert many - few < 500


def test_rays_and_worlds_are_clocked_without_the_harness_but_for_the_plain_way_from_world_to_world() -> None:
    rays, pile = plugins.case("system_rays"), plugins.case("stack_pile")
    for engine, between in (("mujoco", set[str]()), ("bullet", {"Turns.step"}), ("reference", set[str]())):
        casting = made(rays, installed(engine), thin=256)
        casting.clock(2)
        calls = clocked_calls(casting, 5)
        casting.stop()
        assert {called.name for called in calls if called.file.startswith("harness/")} == set()
        worlds = made(pile, installed(engine), n=4, worlds=3)
        worlds.clock(8)
        calls = clocked_calls(worlds, 9)
        worlds.stop()
        assert trespassers(calls) == between


def test_the_law_of_forces_from_outside_stays_outside() -> None:
    case = plugins.case("orbit_kepler")
    assert case.control is not None
    one = made(case, installed("mujoco"))
    one.clock(8)
    calls = clocked_calls(one, 8)
    one.stop()
    assert trespassers(calls) == set()
    assert sum(times for called, times in calls.items() if called.by.startswith("harness/")) > 0


def test_an_engine_that_reads_and_keeps_its_state_inside_the_clock_is_seen() -> None:
    one = made(TOWER, chatty(installed("mujoco")))
    one.clock(50)
    calls = clocked_calls(one, 50)
    assert trespassers(calls) == {"State.empty", "MujocoSimulation.state", "check_state"}
    assert calls[Called("tests/conformance/test_clocked_loop.py", "harness/trajectory/trajectory.py", "State.empty")] == 50
    few, many = growth(lambda: one.clock(50)), growth(lambda: one.clock(550))
    one.stop()
    assert many - few > 500 * 8
