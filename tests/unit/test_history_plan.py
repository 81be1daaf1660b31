"""In which order a night goes through its blocks, and what its budget leaves out."""

from dataclasses import replace
from pathlib import Path

from plumbline.harness.history.blocks import Block, NightSight, Plan, Seen
from plumbline.harness.history.folder import Night
from tests.unit.test_campaign import trials


def block(case: str) -> Block:
    """A block of one trial that is of that name."""
    return Block("plain", case, (replace(trials()[0], trial=case, case=case),))


def seen(case: str, stamp: str, seconds: float, *, changed: bool = False, troubled: bool = False) -> Seen:
    """A block that took so long to compute, half as long to clock."""
    sight = NightSight(
        experiment="plain",
        case=case,
        digest="another" if changed else block(case).digest,
        answers=1,
        computed=1,
        answer_seconds=seconds,
        clock_seconds=seconds / 2,
    )
    return Seen(night=Night(stamp, Path(stamp)), sight=sight, of_all=seconds, troubled=troubled)


NIGHTS = "20261101T010000Z", "20261102T010000Z"


def test_what_changed_goes_first_then_trouble_then_what_was_seen_longest_ago() -> None:
    blocks = [block(case) for case in ("seen late", "new", "troubled", "changed", "seen early")]
    known = {
        ("plain", "seen late"): seen("seen late", NIGHTS[1], 1.0),
        ("plain", "seen early"): seen("seen early", NIGHTS[0], 1.0),
        ("plain", "troubled"): seen("troubled", NIGHTS[1], 1.0, troubled=True),
        ("plain", "changed"): seen("changed", NIGHTS[1], 1.0, changed=True),
    }
    assert [b.case for b in Plan(blocks, known, {}).waiting] == ["changed", "troubled", "seen early", "seen late", "new"]


def test_a_budget_is_filled_by_what_fits_and_the_rest_is_named() -> None:
    """Each takes what the nights before took: the clock goes by that."""
    costs = {"a": 40.0, "b": 100.0, "c": 30.0, "d": 1.0}
    known = {("plain", case): seen(case, NIGHTS[0], seconds, changed=True) for case, seconds in costs.items()}
    plan, left = Plan([block(case) for case in costs], known, {("plain", case): 1.0 for case in costs}), [120.0]
    carried: list[str] = []
    for batch in plan.batches(lambda: left[0]):
        for one in batch:
            carried.append(one.case)
            left[0] -= 1.5 * costs[one.case]
    assert carried == ["a", "c", "d"]
    (out,) = (plan.left_out(one, "it is foreseen to take longer than was left") for one in plan.waiting)
    assert (out["case"], out["foreseen"], out["last_seen"]) == ("b", 150.0, NIGHTS[0])


def _carried(plan: Plan, budget: float, takes: float) -> list[str]:
    """The cases in their order, each of which takes so long. Args: budget, takes [s]."""
    left, carried = [budget], list[str]()
    for batch in plan.batches(lambda: left[0]):
        for one in batch:
            carried.append(one.case)
            plan.taken[one.key] = takes
            left[0] -= takes
    return carried


def test_trouble_shares_a_budget_with_the_rest_until_that_is_done() -> None:
    """Else what is noisy every night would keep out all that is not."""
    known = {("plain", case): seen(case, NIGHTS[0], 20.0, troubled=True) for case in "abcd"}
    known |= {("plain", "e"): seen("e", NIGHTS[0], 20.0)}
    plan = Plan([block(case) for case in "abcde"], known, {("plain", case): 1.0 for case in "abcde"})
    assert _carried(plan, 100.0, 30.0) == ["a", "e", "b"]


def test_while_something_was_never_seen_it_shares_the_budget_with_what_was() -> None:
    """A night has something to compare with what earlier ones saw, and comes to the end of its study all the same."""
    known = {("plain", case): seen(case, NIGHTS[0], 20.0) for case in "abcd"}
    due = {("plain", case): 1.0 for case in "abcdefg"}
    assert _carried(Plan([block(case) for case in "efgabcd"], known, due), 100.0, 30.0) == ["a", "e", "b"]
    assert _carried(Plan([block(case) for case in "abcde"], known, due), 200.0, 30.0) == [*"aebcd"]
    assert _carried(Plan([block(case) for case in "abcd"], known, due), 100.0, 30.0) == [*"abc"]


def test_what_an_unknown_block_takes_is_learnt_from_the_first_of_its_experiment() -> None:
    plan, left = Plan([block(case) for case in "abcd"], {}, {("plain", case): 1.0 for case in "abcd"}), [100.0]
    carried: list[str] = []
    for batch in plan.batches(lambda: left[0]):
        for one in batch:
            carried.append(one.case)
            plan.taken[one.key] = 45.0
            left[0] -= 45.0
    assert carried == ["a", "b"]
    assert [one.case for one in plan.waiting] == ["c", "d"]
