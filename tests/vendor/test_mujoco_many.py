"""Many balls and many worlds in MuJoCo, in its own words: what its guess of memory is, and how worlds share a model.

Source: MuJoCo, XML reference, size/memory; "Simulation", state and control (mjSTATE_INTEGRATION).
"""

import time
from typing import Any

import numpy as np
import pytest

from tests.vendor.mujoco_world import load, mujoco

pytestmark = pytest.mark.mujoco

DT, R = 1 / 240, 0.05


def balls(count: int, more: str = "", option: str = 'solver="CG"') -> tuple[Any, Any]:
    """Layers of ten by ten balls over a floor, a tenth of a millimetre apart."""
    pitch = 2 * R + 1e-4
    world = '<geom type="box" size="5 5 .5" pos="0 0 -.5"/>'
    for k in range(count):
        place = f"{pitch * (k % 10)!r} {pitch * (k // 10 % 10)!r} {R + pitch * (k // 100)!r}"
        world += f'<body pos="{place}"><freejoint/><geom type="sphere" size="{R}" mass="1"/></body>'
    return load(world, DT, option=option, more=more)


def test_the_guess_of_memory_grows_by_the_square_and_far_less_is_enough() -> None:
    guesses = [int(balls(count)[0].narena) for count in (500, 1000)]
    assert guesses[1] > 1e9
    assert guesses[1] / guesses[0] > 3
    model, data = balls(1000, '<size memory="100M"/>')
    mujoco.mj_step(model, data, 20)
    assert not data.warning.number.any()
    # What follows is of the pairs that may touch, 4 bytes a square, and of contacts.
    assert data.maxuse_arena < 3e7
    assert float(data.qpos[2::7].min()) > 0.9 * R


@pytest.mark.parametrize("option", ["", 'solver="CG"'])
def test_worlds_that_share_a_model_and_its_data_go_bit_for_bit_as_those_with_their_own(option: str) -> None:
    worlds, steps, kind = 64, 4, mujoco.mjtState.mjSTATE_INTEGRATION
    model, shared = balls(10, option=option)
    own = [balls(10, option=option) for _ in range(worlds)]
    states = [np.empty(mujoco.mj_stateSize(model, kind)) for _ in range(worlds)]
    for state in states:
        mujoco.mj_getState(model, shared, state, kind)
    taken = np.zeros(2)
    for _ in range(10):
        begun = time.process_time()
        for each, data in own:
            mujoco.mj_step(each, data, steps)
        taken[0] += time.process_time() - begun
        begun = time.process_time()
        for state in states:
            mujoco.mj_setState(model, shared, state, kind)
            mujoco.mj_step(model, shared, steps)
            mujoco.mj_getState(model, shared, state, kind)
        taken[1] += time.process_time() - begun
    own_us, shared_us = 1e6 * taken / (40 * worlds)
    print(f"a step of a world {own_us:.1f} us with data of its own, {shared_us:.1f} shared")
    alone = np.empty_like(states[0])
    for (each, data), state in zip(own, states, strict=True):
        mujoco.mj_getState(each, data, alone, kind)
        np.testing.assert_array_equal(state, alone)
