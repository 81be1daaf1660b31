"""Many worlds: they all advance, each is read by itself, and a world that goes its own way is seen."""

import math
from dataclasses import replace

import numpy as np
import pytest

from plumbline.harness.adapter import Adapter
from plumbline.harness.adapter.many_worlds import Turns, WorldOf, spread
from plumbline.harness.study import plugins
from plumbline.harness.trajectory import State

CASE = plugins.case("stack_pile")
SCENE = CASE.scene(CASE.at(n=4))
BODIES = len(SCENE.bodies)


def batch(worlds: int) -> Turns:
    adapter = plugins.adapter("mujoco")
    # As any engine can go: MuJoCo's own batch is tested beside its adapter.
    made = Adapter.build_batch(adapter, SCENE, adapter.tracks["default"], worlds)
    assert isinstance(made, Turns)
    return made


def test_all_worlds_advance_and_stay_equal_to_a_simulation_of_its_own() -> None:
    adapter = plugins.adapter("mujoco")
    together, alone = batch(3), adapter.build(SCENE, adapter.tracks["default"])
    together.step(20)
    alone.step(20)
    mine, theirs = State.empty(BODIES), State.empty(BODIES)
    alone.state(mine)
    for world in range(together.worlds):
        together.state(world, theirs)
        np.testing.assert_array_equal(theirs.p_WB, mine.p_WB)
    assert spread(together, BODIES) == 0.0
    together.close()
    alone.close()


def test_a_world_that_took_one_step_more_is_seen() -> None:
    together = batch(3)
    together.step(5)
    together._simulations[1].step(1)
    assert spread(together, BODIES) > 0.0


def test_a_world_without_numbers_is_seen() -> None:
    together = batch(2)
    together._simulations[1].state = lambda out: out.p_WB.fill(math.nan)  # type: ignore[method-assign]
    assert math.isnan(spread(together, BODIES))


def test_one_world_looked_at_steps_them_all() -> None:
    together = batch(2)
    WorldOf(together, 1).step(3)
    assert spread(together, BODIES) == 0.0
    state = State.empty(BODIES)
    WorldOf(together, 0).state(state)
    assert not np.array_equal(state.v_WB, State.initial(SCENE).v_WB)


def test_a_batch_that_cannot_be_finished_closes_what_it_began(monkeypatch: pytest.MonkeyPatch) -> None:
    adapter = plugins.adapter("mujoco")
    closed, made = [], []

    def build(self: object, scene: object, settings: object) -> object:
        if len(made) == 2:
            raise MemoryError
        made.append(len(made))
        number = made[-1]
        return type("World", (), {"close": lambda _: closed.append(number)})()

    monkeypatch.setattr(type(adapter), "build", build)
    with pytest.raises(MemoryError):
        Adapter.build_batch(adapter, SCENE, adapter.tracks["default"], 5)
    assert closed == [0, 1]


@pytest.mark.parametrize(("options", "own"), [({}, True), ({"threads": 2}, False)])
def test_the_reference_engine_steps_its_worlds_together_with_the_bits_of_one_alone(options: dict[str, int], own: bool) -> None:
    """Its own batch where it has one for these settings, and turns otherwise."""
    adapter = plugins.adapter("reference")
    settings = replace(adapter.tracks["default"], options=options)
    together, alone = adapter.build_batch(SCENE, settings, 3), adapter.build(SCENE, settings)
    assert isinstance(together, Turns) != own
    assert together.worlds == 3
    assert together.resolved == alone.resolved
    together.step(20)
    alone.step(20)
    mine, theirs = State.empty(BODIES), State.empty(BODIES)
    alone.state(mine)
    for world in range(3):
        together.state(world, theirs)
        for name in ("p_WB", "q_WB", "v_WB", "w_WB"):
            np.testing.assert_array_equal(getattr(theirs, name), getattr(mine, name))
    together.close()
    alone.close()
