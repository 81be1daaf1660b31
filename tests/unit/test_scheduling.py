"""The order of test files: what is said to be dear is there and goes first; what shares a fixture or a clock goes together."""

from pathlib import Path

import pytest

from tests.scheduling import CLOCK, DEAREST, SHARED, order, unit_of

ROOT = Path(__file__).parents[2]


def test_every_file_that_is_named_is_there_and_once() -> None:
    for file in (*DEAREST, *SHARED, *SHARED.values(), *CLOCK):
        assert (ROOT / file).is_file(), file
    assert len(set(DEAREST)) == len(DEAREST)


def test_the_dearest_go_first_and_the_others_by_the_number_of_their_tests() -> None:
    tests = {"tests/a.py": 1, "tests/b.py": 3, DEAREST[1]: 1, DEAREST[0]: 1}
    units = {file: {f"{file}::test[{k}]": False for k in range(count)} for file, count in tests.items()}
    assert order(units) == [DEAREST[0], DEAREST[1], "tests/b.py", "tests/a.py"]


def test_files_that_share_a_fixture_are_one_unit() -> None:
    for file, other in SHARED.items():
        assert unit_of(f"{file}::test_a[x::y]") == unit_of(f"{other}::test_b") == other


def test_files_with_a_clock_on_are_one_unit_and_marked(request: pytest.FixtureRequest) -> None:
    assert {unit_of(f"{file}::test") for file in CLOCK} == {CLOCK[0]}
    assert not {*SHARED, *SHARED.values()} & {*CLOCK}
    for item in request.session.items:
        assert (item.get_closest_marker("clock") is not None) == (unit_of(item.nodeid) == CLOCK[0]), item.nodeid
