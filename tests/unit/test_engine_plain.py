"""Kernels that other tests come to only after many steps, run as plain Python for a few."""

import os
from typing import Any

import numpy as np
import pytest

from plumbline import engine
from tests.unit.test_engine_islands import stacks

pytestmark = pytest.mark.skipif(os.environ.get("NUMBA_DISABLE_JIT") != "1", reason="compiled, longer tests come to them")


@pytest.mark.parametrize("apart", [{"sleeping": True, "sleep_time": 1e6}, {"threads": 2}], ids=["one thread", "two threads"])
@pytest.mark.parametrize("tied", [False, True], ids=["free", "tied"])
def test_two_islands_apart_end_with_the_bits_of_both_together(tied: bool, apart: dict[str, Any]) -> None:
    together, alone = stacks(2, 0.4, tied), stacks(2, 0.4, tied, **apart)
    together.step(3)
    alone.step(3)
    assert np.array_equal(together.state(), alone.state())


def test_worlds_on_two_threads_end_with_the_bits_they_have_alone() -> None:
    worlds = [stacks(1, 0.4) for _ in range(3)]
    batch = engine.Batch(worlds, 2)
    batch.step(3)
    for number, world in enumerate(worlds):
        world.step(3)
        assert np.array_equal(batch.state()[number], world.state())
