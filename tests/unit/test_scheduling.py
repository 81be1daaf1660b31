"""The order of the test files: what is said to be dear is there, goes first, and what shares a fixture goes together."""

from pathlib import Path

from tests.scheduling import DEAREST, SHARED, order, unit_of

ROOT = Path(__file__).parents[2]


def test_every_file_that_is_named_is_there_and_once() -> None:
    for file in (*DEAREST, *SHARED, *SHARED.values()):
        assert (ROOT / file).is_file(), file
    assert len(set(DEAREST)) == len(DEAREST)


def test_the_dearest_go_first_and_the_others_by_the_number_of_their_tests() -> None:
    tests = {"tests/a.py": 1, "tests/b.py": 3, DEAREST[1]: 1, DEAREST[0]: 1}
    units = {file: {f"{file}::test[{k}]": False for k in range(count)} for file, count in tests.items()}
    assert order(units) == [DEAREST[0], DEAREST[1], "tests/b.py", "tests/a.py"]


def test_files_that_share_a_fixture_are_one_unit() -> None:
    for file, other in SHARED.items():
        assert unit_of(f"{file}::test_a[x::y]") == unit_of(f"{other}::test_b") == other
