"""When a run is better than another: checks at the looser of both bounds, errors above a floor, no check lost."""

import math
from typing import Any

import pytest

from plumbline.harness.adapter.trade_off import TradeOff, check_named
from plumbline.harness.search.dominance import Question, RunFigures, compared, run_of

QUESTION = Question("error", 1.0, frozenset({"height"}))


def run(*checks: tuple[str, float, float], status: str = "passed", off: float = 0.0) -> RunFigures:
    """A run by its checks: metric, value and bound."""

    def row(metric: str, value: float, bound: float) -> dict[str, Any]:
        return {"metric": metric, "value": value, "at_most": bound, "passed": True, "truth_error": off}

    return run_of(QUESTION, status, [row(*check) for check in checks])


@pytest.mark.parametrize(
    ("track", "change", "more", "fewer"),
    [
        ((1.0, 2.0), (3.0, 2.0), False, True),
        ((3.0, 2.0), (1.0, 2.0), True, False),
        ((3.0, 2.0), (3.0, 2.0), False, False),
    ],
)
def test_more_checks_are_those_of_the_track_and_another(
    track: tuple[float, float], change: tuple[float, float], more: bool, fewer: bool
) -> None:
    beside = compared(QUESTION, run(("speed", *track)), run(("speed", *change)))
    assert beside is not None
    assert (beside.more, beside.fewer) == (more, fewer)


def test_one_check_won_and_another_lost_is_a_trade() -> None:
    beside = compared(QUESTION, run(("a", 1.0, 2.0), ("b", 3.0, 2.0)), run(("a", 3.0, 2.0), ("b", 1.0, 2.0)))
    assert beside is not None
    assert (beside.held, beside.more, beside.fewer) == ((1, 1), False, True)


def test_both_are_held_to_the_looser_bound() -> None:
    """A track of eight sub-steps is left with a quarter of what one step may have: that alone makes it no worse."""
    beside = compared(QUESTION, run(("speed", 0.9, 0.25)), run(("speed", 0.9, 1.0)))
    assert beside is not None
    assert (beside.held, beside.more) == ((1, 1), False)
    high = compared(QUESTION, run(("height", 0.8, 0.9)), run(("height", 0.8, 0.7)))
    assert high is not None
    assert (high.held, high.more) == ((1, 1), False)


@pytest.mark.parametrize(
    ("track", "change", "off", "as_good", "errs_less"),
    [
        (1.0, 1.09, 0.0, True, False),
        (1.0, 1.11, 0.0, False, False),
        (1.11, 1.0, 0.0, True, True),
        (0.0, 0.099, 0.0, True, False),
        (0.0, 0.12, 0.0, False, False),
        (0.0, 0.9, 1.0, True, False),
        (math.nan, 1.0, 0.0, True, True),
    ],
)
def test_errors_are_alike_within_a_tenth_and_below_the_floor(
    track: float, change: float, off: float, as_good: bool, errs_less: bool
) -> None:
    """The bound is 10, so that the floor is .1, unless the truth is off by more."""
    beside = compared(QUESTION, run(("error", track, 10.0), off=off), run(("error", change, 10.0), off=off))
    assert beside is not None
    if not math.isnan(track):
        assert (beside.as_good, beside.errs_less) == (as_good, errs_less)
    else:
        assert beside.more


def test_what_gave_no_answer_is_not_compared_and_beaten_by_what_did() -> None:
    answered, lost = run(("error", 1.0, 2.0)), run(("error", 1.0, 2.0), status="timeout")
    assert compared(QUESTION, answered, lost) is None
    beside = compared(QUESTION, lost, answered)
    assert beside is not None
    assert beside.more


@pytest.mark.parametrize(
    "wrong",
    [
        {"cases": ()},
        {"why": " "},
        {"at": ()},
        {"values": (1,)},
        {"knob": "iterations", "at": ("ladder",)},
    ],
)
def test_a_trade_off_says_which_knob_where_and_why(wrong: dict[str, Any]) -> None:
    TradeOff(cases=("a",), why="so")
    with pytest.raises(ValueError, match="expected"):
        TradeOff(**{"cases": ("a",), "why": "so"} | wrong)


@pytest.mark.parametrize(("knob", "values"), [("itreations", ()), ("iterations", (3,))])
def test_a_trade_off_names_a_knob_and_values_that_there_are(knob: str, values: tuple[int, ...]) -> None:
    knobs = {"iterations": (1, 2)}
    check_named("made", [TradeOff(cases=("a",), why="so", knob="iterations", values=(2,))], knobs)
    with pytest.raises(ValueError, match="'made': trade-off in a: "):
        check_named("made", [TradeOff(cases=("a",), why="so", knob=knob, values=values)], knobs)
