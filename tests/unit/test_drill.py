"""The drill: its planted engine has the two faults and no other, and both nights end as they must."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from plumbline.harness.adapter import Settings
from plumbline.harness.history import drill
from plumbline.harness.study import plugins
from plumbline.harness.trajectory import State

CASE = "friction_stop"


def sliding(engine: str, friction: float, rougher: float = 1.0) -> np.ndarray:
    """Where the bodies of the case end on the wrapped engine, in a scene whose surfaces are so much rougher."""
    case, inner = plugins.case(CASE), plugins.adapter(engine)
    scene = case.scene(case.parameters)
    surfaces = [
        replace(s, static_friction=rougher * s.static_friction, kinetic_friction=rougher * s.kinetic_friction)
        for s in scene.surfaces
    ]
    world = replace(scene, surfaces=tuple(surfaces))
    simulation = drill.planted(inner, time=1.0, friction=friction).build(world, Settings(dt=1 / 240))
    try:
        simulation.step(120)
        end = State.empty(len(world.bodies))
        simulation.state(end)
    finally:
        simulation.close()
    return end.p_WB


@pytest.mark.parametrize("engine", ["bullet", "mujoco"])
def test_the_planted_engine_is_the_engine_but_for_its_friction(engine: str) -> None:
    as_it_is, rougher = sliding(engine, 1.0), sliding(engine, drill.FRICTION)
    assert not np.array_equal(as_it_is, rougher)
    np.testing.assert_array_equal(rougher, sliding(engine, 1.0, rougher=drill.FRICTION))


def test_a_step_of_the_planted_engine_lasts_as_many_times_as_long(monkeypatch: pytest.MonkeyPatch) -> None:
    clock, steps = [0.0], []

    class Inner:
        def step(self, count: int) -> None:
            steps.append(count)
            clock[0] += 10.0

    def thread_time() -> float:
        clock[0] += 0.25
        return clock[0]

    monkeypatch.setattr(drill, "thread_time", thread_time)
    drill._Slower(Inner(), 1.2).step(3)  # type: ignore[arg-type]
    assert steps == [3]
    assert clock[0] == pytest.approx(12.0, abs=1.0)


@pytest.mark.slow
def test_the_second_night_names_the_friction_and_the_first_names_nothing(tmp_path: Path) -> None:
    """Whether the time is named hangs on the machine's noise: that is what the drill tells its user."""
    (first, nothing), (second, named) = drill.nights(tmp_path, "bullet")
    assert first.returncode == 0, first.stderr
    assert nothing["1.05 times the friction"] == ""
    assert second.returncode == 1, second.stderr
    assert "friction_stop on drill" in named["1.05 times the friction"]
