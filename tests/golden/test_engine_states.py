"""The reference engine still does what it did: to rounding on every machine, to the bit on those it knows, on any threads."""

import platform

import numpy as np
import pytest

from engine.compile.jit import jit_is_off
from tests.golden.engine_states import (
    COMPARED,
    STEPS,
    WORLDS,
    compared_state,
    fuses,
    known,
    last_state,
    last_state_on,
    machine,
    tolerance,
)  # fmt: skip


@pytest.mark.parametrize("name", WORLDS)
def test_a_world_comes_to_the_state_it_always_came_to(name: str) -> None:
    """On every machine, within a hundred times what another rounding was measured to make of it."""
    found, stored = compared_state(name), np.array(known()["states"][name])
    assert found.shape == stored.shape
    assert np.abs(found - stored).max() <= tolerance(name)


@pytest.mark.parametrize("name", WORLDS)
def test_the_tolerance_sees_a_thousandth_of_gravity(name: str) -> None:
    """All bodies are of 1 kg; in the heap of all shapes, where roundings have grown, it takes a hundredth."""
    world, share = WORLDS[name](1), 0.01 if name == "pile" else 0.001
    force = np.zeros((len(world.state()), 3))
    force[:, 2] = share * 9.81
    world.set_load(force, np.zeros_like(force))
    world.step(COMPARED.get(name, STEPS))
    assert np.abs(world.state() - np.array(known()["states"][name])).max() > tolerance(name)


@pytest.mark.parametrize("name", WORLDS)
def test_a_world_ends_in_the_state_it_always_ended_in(name: str) -> None:
    """Bit for bit where this machine's hashes are known; elsewhere nothing holds its bits but that they repeat."""
    hashes = known()["hashes"].get(machine(), {})
    assert last_state(name, 1) == hashes.get(name, last_state(name, 1))


@pytest.mark.compiler
@pytest.mark.skipif(
    jit_is_off() or platform.machine() != "x86_64" or not fuses(), reason="asks x86 code with fused multiply-add"
)
@pytest.mark.parametrize(
    "name", ["free_box", "tree", *(pytest.param(name, marks=pytest.mark.slow) for name in ("stack", "pile"))]
)
@pytest.mark.parametrize("processor", ["haswell", pytest.param("skylake-avx512", marks=pytest.mark.slow)])
def test_code_for_another_processor_ends_in_the_same_state(name: str, processor: str) -> None:
    """Bit for bit: which products and sums are rounded as one is said by the text, not by what a processor is quick at."""
    assert last_state_on(processor, "+avx2,+fma", name) == last_state(name, 1)


@pytest.mark.parametrize("name", WORLDS)
def test_a_world_ends_in_the_same_state_on_any_number_of_threads(name: str) -> None:
    """On every machine."""
    assert len({last_state(name, threads) for threads in (1, 2, 4)}) == 1
