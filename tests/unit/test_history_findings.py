"""Findings over nights: one that is gone or back is told once, at its night."""

import math

from plumbline.harness.findings.vendor_findings import SECONDS, Finding, ScriptAnswer, ScriptVerdict, shelf
from plumbline.harness.history.changes_since import asked_again, turned
from plumbline.harness.history.sentences import summary

EVERY = shelf()
NAME = "bullet/damping_by_default"


def night(verdict: ScriptVerdict, version: str, left: float = math.inf) -> list[dict[str, str]]:
    """What a night keeps in whose engines that one finding has this verdict, all others being there."""

    def answer(finding: Finding) -> ScriptAnswer:
        return ScriptAnswer(finding, verdict if finding.name == NAME else "still there", "1.449 m", version, 0.3)

    return asked_again(EVERY, ("bullet", "dart"), lambda: left, answer)


def test_a_night_asks_of_its_engines_alone_and_not_beyond_its_budget() -> None:
    assert {row["name"].partition("/")[0] for row in night("still there", "1")} == {"bullet", "dart"}
    assert night("still there", "1", left=SECONDS) == []


def test_one_that_is_gone_is_told_once_and_again_when_it_is_back() -> None:
    nights = [night("still there", "3.2.7"), night("gone", "3.3.0"), night("gone", "3.3.0"), night("still there", "3.3.1")]
    heard = []
    for k, rows in enumerate(nights):
        plans = [{"findings": earlier} for earlier in nights[:k]]
        heard.append([text.partition(": ")[0] for text in turned(EVERY, rows, plans)])
    assert heard == [[], [f"{NAME} is gone (3.2.7 -> 3.3.0)"], [], [f"{NAME} is back (3.3.0 -> 3.3.1)"]]


def test_a_night_without_an_answer_neither_turns_one_nor_hides_the_turn_after_it() -> None:
    nights = [night("still there", "3.2.7"), night("failed", "3.2.7"), night("unavailable", ""), night("gone", "3.3.0")]
    last = turned(EVERY, nights[-1], [{"findings": rows} for rows in nights[:-1]])
    assert ["is gone (3.2.7 -> 3.3.0)" in text for text in last] == [True]
    assert not turned(EVERY, nights[1], [{"findings": nights[0]}])


def test_the_summary_tells_of_it() -> None:
    plan = {
        "stamp": "20260101T000000Z", "seconds": {"whole": 1.0}, "budget": None, "answers": 1, "recalled": 0, "computed": 1,
        "again": 0, "disagreements": 0, "clocked": 0, "bytes": {"night": 0, "pool": 0}, "left_out": [],
        "memory_mb": {"own": 1.0, "largest_child": 1.0},
    }  # fmt: skip
    text = summary(None, plan, (), ["bullet/x is gone (1 -> 2): a title; 0 m"])
    assert "## Findings about engines\n\n* bullet/x is gone" in text
    assert "## Findings" not in summary(None, plan, ())
