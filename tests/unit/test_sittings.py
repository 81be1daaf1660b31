"""Which questions the clock takes in one sitting."""

from types import SimpleNamespace
from typing import Any

from plumbline.harness.run.campaign import _sittings
from plumbline.harness.study.experiment import Experiment

EACH = {f"{case}{k}": 10.0 for case in "abc" for k in range(2)}
"""Seconds of the clock, by trial."""
FIRST, SECOND = Experiment(name="first"), Experiment(name="second")


def question(case: str, experiment: Experiment = FIRST) -> Any:
    """Two trials of it."""
    return tuple(SimpleNamespace(trial=f"{case}{k}", experiment=experiment) for k in range(2))


def test_a_sitting_holds_whole_questions_of_one_experiment_for_as_long_as_it_may_take() -> None:
    a, b, c = question("a"), question("b"), question("c")
    assert list(_sittings([a, b, c], 40.0, EACH)) == [a + b, c]
    assert list(_sittings([a, b, c], 60.0, EACH)) == [a + b + c]
    assert list(_sittings([a, b, c], 0.0, EACH)) == [a, b, c]
    other = question("b", SECOND)
    assert list(_sittings([a, other, c], 60.0, EACH)) == [a, other, c]
    assert list(_sittings([], 60.0, EACH)) == []
