"""Limits that moved, determinism that was lost, scenes of one's own that are agreed on no more: which way each change goes."""

from dataclasses import replace
from typing import Any, cast

import pytest

from plumbline.harness.findings.agreement.values import Agreement, Side
from plumbline.harness.findings.changes.studied import changed_words, lost_and_won, moved_limits
from plumbline.harness.findings.limits_found import Search, Signs
from plumbline.harness.findings.tables.determinism import Repetition

SEARCH = Search(
    experiment="towers", case="stack_tower", where="", beside=(), engine="dart", track="tuned", dt=0.01, axis="height",
    unit="1", easy=2.0, extreme=40.0, held=10.0, broke=12.0,
    share=0.0, signs=Signs(counts=(("collapse", 4),)), verdict="limit", reason="",
    members=4, values=5, cost=None, reach=0.5, trial_held="aa", trial_broke="bb",
)  # fmt: skip


@pytest.mark.parametrize(
    ("held", "broke", "verdict", "sense"),
    [
        (12.0, 14.0, "limit", "better"),
        (8.0, 10.0, "limit", "worse"),
        (11.0, 13.0, "limit", "within tolerance"),
        (10.0, 11.0, "limit", "within tolerance"),
        (40.0, None, "beyond the extreme", "better"),
        (None, 2.0, "not even the easiest", "worse"),
        (10.0, None, "stopped", "worse"),
        (None, None, "unavailable", "neither"),
    ],
)
def test_a_limit_moves_where_brackets_do_not_meet(held: float | None, broke: float | None, verdict: str, sense: str) -> None:
    after = replace(SEARCH, held=held, broke=broke, verdict=verdict)
    assert [row.sense for row in moved_limits([SEARCH], [after])] == [sense]
    assert list(moved_limits([SEARCH], [SEARCH])) == []


def test_an_axis_that_is_harder_downwards_is_read_the_other_way() -> None:
    thin = replace(SEARCH, axis="thickness", unit="m", easy=0.1, extreme=0.001, held=0.02, broke=0.01)
    (row,) = moved_limits([thin], [replace(thin, held=0.05, broke=0.03)])
    assert (row.sense, row.before, row.after, row.ratio) == ("worse", 0.02, 0.05, 2.5)


def test_a_repetition_that_gives_other_bits_now_is_lost_and_a_nudge_is_none() -> None:
    same = Repetition(
        case="stack_tower", engine="dart", track="tuned", way="again", must=True, hash_first="1", hash="1", steps=9,
        first_step=None,
        farthest=0.0, doubles_in=None, verdict="bit-identical", reason="", trial="aa", trial_first="bb",
    )  # fmt: skip
    differs = replace(same, verdict="differs", first_step=3)
    (row,) = lost_and_won({"cell": same}, {"cell": differs})
    assert (row.sense, row.regression, row.detail) == ("worse", True, "from step 3 on")
    assert [row.sense for row in lost_and_won({"cell": differs}, {"cell": same})] == ["better"]
    assert not list(lost_and_won({"cell": same}, {"cell": replace(differs, must=False)}))


def test_an_engine_that_agrees_no_more_is_worse_and_where_nothing_is_agreed_it_is_no_fault() -> None:
    side = Side(engine="dart", track="tuned", ours=False, word="agrees", why="", limit=cast(Any, None))
    agreed = Agreement(
        case="scene:/a/robot.toml",
        where="",
        duration=1.0,
        scale=cast(Any, None),
        granted=0.01,
        sides=(side, replace(side, track="default")),
        differences=(),
    )
    elsewhere = replace(side, word="converges elsewhere"), replace(side, track="default", word="converges")
    rows = list(changed_words([agreed], [replace(agreed, case="scene:/b/robot.toml", sides=elsewhere)]))
    assert [(row.track, row.sense, row.before, row.after) for row in rows] == [
        ("tuned", "worse", "agrees", "converges elsewhere"),
        ("default", "neither", "agrees", "converges"),
    ]
    assert not list(changed_words([agreed], [agreed]))
