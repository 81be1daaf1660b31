"""The engine's tests as plain Python: each gets a share of time, so that a run without the compiler ends.

With NUMBA_DISABLE_JIT=1 a kernel runs some hundred times slower, and the tests would take hours. Such a run is there so that
Python sees the lines of every kernel and checks the bounds of every array; hours of stepping show hardly a line that seconds do
not. All parameters of a test share a few seconds, and what one of them leaves is for those after it. A test that is cut short
is skipped and says so: it has not passed. Compiled runs are as they were.
"""

import os
import signal
from collections import Counter
from collections.abc import Generator
from types import FrameType

import pytest

PLAIN = os.environ.get("NUMBA_DISABLE_JIT") == "1"
SECONDS, LEAST = 3.5, 0.3
"""Processor time [s] for all parameters of a test together, and the least for each: a quarter of an hour at most for all."""

waiting: Counter[str] = Counter()
"""How many parameters of a test have still to run."""
left: dict[str, float] = {}
"""Processor time [s] that they may take."""


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    if not PLAIN:
        return
    for test in items:
        if test.get_closest_marker("compiler"):
            test.add_marker(pytest.mark.skip(reason="about the compiler, and nothing is compiled"))
        else:
            waiting[name_of(test)] += 1
    left.update({name: max(SECONDS, LEAST * count) for name, count in waiting.items()})


@pytest.hookimpl(wrapper=True)
def pytest_runtest_call(item: pytest.Item) -> Generator[None, None, None]:
    name = name_of(item)
    if not PLAIN or "/test_engine_" not in name:
        return (yield)
    share = max(left[name] / waiting[name], LEAST)

    def cut(number: int, frame: FrameType | None) -> None:
        pytest.skip(f"as plain Python it takes more than its share of {share:.1f} s")

    before = signal.signal(signal.SIGVTALRM, cut)
    # Raised in a callback whose errors are dropped, the first signal would be lost: it comes again.
    signal.setitimer(signal.ITIMER_VIRTUAL, share, LEAST)
    try:
        return (yield)
    finally:
        spare, _ = signal.setitimer(signal.ITIMER_VIRTUAL, 0.0)
        signal.signal(signal.SIGVTALRM, before)
        waiting[name] -= 1
        # Where the share ran out, what remains on the timer is of its second turn.
        left[name] -= share if spare <= LEAST else share - spare


def name_of(test: pytest.Item) -> str:
    """The name of a test without its parameters."""
    return test.nodeid.partition("[")[0]
