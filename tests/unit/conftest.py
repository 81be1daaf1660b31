"""The engine's tests as plain Python: each gets a share of time, so that a run without the compiler ends.

With NUMBA_DISABLE_JIT=1 a kernel runs some hundred times slower, and the tests would take hours. Such a run is there so that
Python sees the lines of every kernel and checks the bounds of every array; hours of stepping show hardly a line that seconds do
not. All parameters of a test share a few seconds, and what one of them leaves is for those after it. A test that is cut short
is skipped and says so: it has not passed. Compiled runs are as they were.
"""

import os
import signal
import time
from collections import Counter
from collections.abc import Callable, Generator, Iterator
from pathlib import Path
from types import FrameType
from typing import Any

import pytest

from tests.forks import NUMBA, Fork, forks

PLAIN = os.environ.get("NUMBA_DISABLE_JIT") == "1"
SECONDS, LEAST = 3.5, 0.3
"""Processor time [s] for all parameters of a test together, and the least for each: a quarter of an hour at most for all."""

AGAIN = 0.02
"""Processor time [s] from one signal to the next where the first could not cut a test short."""
OURS = tuple(str(Path(__file__).parents[2] / folder) for folder in ("engine", "tests"))
"""Where a test may be cut short."""

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
    share, begun = max(left[name] / waiting[name], LEAST), time.process_time()

    def cut(number: int, frame: FrameType | None) -> None:
        # Elsewhere, in a measurement of coverage say, a lock may be held that would stay so: the signal comes again.
        if frame is not None and frame.f_code.co_filename.startswith(OURS):
            pytest.skip(f"as plain Python it takes more than its share of {share:.1f} s")

    before = signal.signal(signal.SIGVTALRM, cut)
    signal.setitimer(signal.ITIMER_VIRTUAL, share, AGAIN)
    try:
        return (yield)
    finally:
        signal.setitimer(signal.ITIMER_VIRTUAL, 0.0)
        signal.signal(signal.SIGVTALRM, before)
        waiting[name] -= 1
        left[name] -= time.process_time() - begun


@pytest.fixture(params=["maximal", "automatic"])
def both_coordinates(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> str:
    """Worlds whose options do not say which coordinates get bodies' own, then those that trees of joints leave."""
    from plumbline import engine

    defaults = engine.Options.__init__.__kwdefaults__
    assert defaults is not None
    monkeypatch.setitem(defaults, "coordinates", request.param)
    chosen: str = request.param
    return chosen


@pytest.fixture(scope="session")
def fork() -> Iterator[Fork]:
    """Programs in processes of their own, with room for four threads, however many cores there are."""
    with forks("import os; os.environ['NUMBA_NUM_THREADS'] = '4'; " + NUMBA) as run:
        yield run


@pytest.fixture(scope="module")
def solids_found_once() -> Iterator[None]:
    """Worlds of the same bodies are built again and again: what equal hulls and triangles are made of is worked out once."""
    import numpy as np

    from plumbline.engine.build import solids

    def once(work: Callable[..., Any]) -> Callable[..., Any]:
        found = dict[tuple[object, ...], Any]()

        def kept(*given: Any) -> Any:
            key = tuple((one.dtype.str, one.shape, one.tobytes()) if isinstance(one, np.ndarray) else one for one in given)
            if key not in found:
                found[key] = work(*given)
            return found[key]

        return kept

    with pytest.MonkeyPatch.context() as patch:
        for name in ("hull_polyhedron", "inner_edges", "_triangle"):
            patch.setattr(solids, name, once(getattr(solids, name)))
        yield


def name_of(test: pytest.Item) -> str:
    """The name of a test without its parameters."""
    return test.nodeid.partition("[")[0]
