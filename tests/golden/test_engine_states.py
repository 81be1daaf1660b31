"""The reference engine still does exactly what it did, and on any number of threads."""

import pytest

from tests.golden.engine_states import FILE, WORLDS, known, last_state, machine


@pytest.mark.parametrize("name", WORLDS)
def test_a_world_ends_in_the_state_it_always_ended_in(name: str) -> None:
    """Bit for bit, on a machine whose hashes are known."""
    hashes = known().get(machine())
    if hashes is None:
        pytest.skip(f"{FILE.name} knows no hashes for {machine()}, only for {'; '.join(known())}")
    assert last_state(name, 1) == hashes[name]


@pytest.mark.parametrize("name", WORLDS)
def test_a_world_ends_in_the_same_state_on_any_number_of_threads(name: str) -> None:
    """On every machine."""
    assert len({last_state(name, threads) for threads in (1, 2, 4)}) == 1
