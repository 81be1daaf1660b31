"""Which share of what a bench clocks is the adapter's own: laws that it works out in each step, because the engine lacks them.

It is measured apart from the samples, in a run of its own, so that no sample is disturbed: the functions that the adapter names
as its laws are called under a clock there, with whatever they ask of the engine.
"""

import contextlib
import importlib
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import wraps
from typing import Any

from plumbline.harness.trial.bench import Bench


@dataclass(slots=True)
class Spent:
    """What laws took: CPU seconds, in how many calls. Terms: within: does one run now? Those that it calls are a part of it."""

    cpu: float = 0.0
    calls: int = 0
    within: bool = False


def emulated_share(bench: Bench, laws: Sequence[str], seconds: float) -> float:
    """The share (0 to 1) of the clocked CPU time, over a whole run or its first `seconds` [s] of them; the bench is stopped.

    Args: laws: as in `harness.adapter.Adapter`.
    """
    if not laws or bench.endless:
        return 0.0
    done, count, whole = 0, 1, 0.0
    bench.start()
    try:
        with stopwatch(laws) as spent:
            while done < bench.whole and whole < seconds:
                count = min(count, bench.whole - done)
                whole += bench.clock(count)[0]
                done, count = done + count, 2 * count
                if not spent.calls:
                    break
    finally:
        bench.stop()
    return min(1.0, spent.cpu / whole) if whole > 0 else 0.0


@contextlib.contextmanager
def stopwatch(laws: Sequence[str]) -> Iterator[Spent]:
    """While this lasts, what these functions take is counted."""
    spent, kept = Spent(), []
    try:
        for law in laws:
            owner, name = _place(law)
            work = getattr(owner, name)
            kept.append((owner, name, work))
            setattr(owner, name, _timed(work, spent))
        yield spent
    finally:
        for owner, name, work in reversed(kept):
            setattr(owner, name, work)


def _place(law: str) -> tuple[Any, str]:
    """Where a function stands, and its name there."""
    module, path = law.split(":")
    owner: Any = importlib.import_module(module)
    *within, name = path.split(".")
    for part in within:
        owner = getattr(owner, part)
    return owner, name


def _timed(work: Callable[..., Any], spent: Spent) -> Callable[..., Any]:
    @wraps(work)
    def timed(*args: Any, **kwargs: Any) -> Any:
        if spent.within:
            return work(*args, **kwargs)
        spent.within, begun = True, time.process_time()
        try:
            return work(*args, **kwargs)
        finally:
            spent.cpu += time.process_time() - begun
            spent.within, spent.calls = False, spent.calls + 1

    return timed
