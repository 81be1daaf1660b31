"""The order of test files: what is said to be dear is there and goes first; what shares a fixture or a clock goes together.

And what is said of a test: all that went wrong with it, and how long it took.
"""

from collections.abc import Sequence
from pathlib import Path
from typing import Literal

import pytest

from tests.scheduling import APART, CLOCK, DEAREST, SHARED, WAITING, file_of, order, telling, unit_of

ROOT = Path(__file__).parents[2]


def test_every_file_that_is_named_is_there_and_once() -> None:
    for file in (*DEAREST, *SHARED, *SHARED.values(), *CLOCK, *WAITING):
        assert (ROOT / file).is_file(), file
    assert len(set(DEAREST)) == len(DEAREST)


def test_the_dearest_go_first_and_the_others_by_the_number_of_their_tests() -> None:
    tests = {"tests/a.py": 1, "tests/b.py": 3, DEAREST[1]: 1, DEAREST[0]: 1}
    units = {file: {f"{file}::test[{k}]": False for k in range(count)} for file, count in tests.items()}
    assert order(units) == [DEAREST[0], DEAREST[1], "tests/b.py", "tests/a.py"]


def test_what_takes_minutes_for_each_parameter_is_a_unit_for_each_and_goes_first() -> None:
    long = f"{APART[0]}[bullet]"
    assert unit_of(long) == long
    assert order({DEAREST[0]: {}, long: {}}) == [long, DEAREST[0]]
    file, _, name = APART[0].partition("::")
    assert f"def {name}(" in (ROOT / file).read_text()


def test_files_that_share_a_fixture_are_one_unit() -> None:
    for file, other in SHARED.items():
        assert unit_of(f"{file}::test_a[x::y]") == unit_of(f"{other}::test_b")
        assert other in WAITING or unit_of(f"{other}::test_b") == other


def test_files_with_a_clock_on_are_one_unit_and_marked_and_those_that_wait_go_with_them(request: pytest.FixtureRequest) -> None:
    assert {unit_of(f"{file}::test") for file in (*CLOCK, *WAITING)} == {CLOCK[0]} == {DEAREST[0]}
    assert not {*SHARED, *SHARED.values()} & {*CLOCK}
    assert not {*DEAREST[1:]} & {*CLOCK, *WAITING, *SHARED}
    for item in request.session.items:
        assert (item.get_closest_marker("clock") is not None) == (file_of(item.nodeid) in CLOCK), item.nodeid


Outcome = Literal["passed", "failed", "skipped"]
PROPERTY = [("what", "said")]


def of_a_test(*outcomes: Outcome, said: Sequence[tuple[str, object]] = ()) -> list[pytest.TestReport]:
    """Of setup, call and teardown, each a second; without a call where the setup did not pass. Terms: said: by the last."""
    whens: tuple[Literal["setup", "call", "teardown"], ...] = ("setup", "call", "teardown")
    told = whens if len(outcomes) == len(whens) else (whens[0], whens[-1])
    return [
        pytest.TestReport(
            "f::t", ("f", 1, "t"), {}, outcome, None, when, (), 1.0, user_properties=said if when == told[-1] else ()
        )
        for outcome, when in zip(outcomes, told, strict=True)
    ]


@pytest.mark.parametrize(
    ("reports", "left"),
    [
        (of_a_test("passed", "passed", "passed"), ["call"]),
        (of_a_test("passed", "failed", "passed"), ["call"]),
        (of_a_test("passed", "skipped", "passed"), ["call"]),
        (of_a_test("passed", "passed", "failed"), ["call", "teardown"]),
        (of_a_test("passed", "passed", "passed", said=PROPERTY), ["call", "teardown"]),
        (of_a_test("failed", "passed"), ["setup"]),
        (of_a_test("skipped", "passed"), ["setup"]),
        (of_a_test("failed", "failed"), ["setup", "teardown"]),
    ],
)
def test_of_a_test_is_told_what_its_call_and_whatever_went_wrong_says_and_all_its_time(
    reports: list[pytest.TestReport], left: list[str]
) -> None:
    took = sum(report.duration for report in reports)
    told = telling(reports)
    assert [report.when for report in told] == left
    assert sum(report.duration for report in told) == took
