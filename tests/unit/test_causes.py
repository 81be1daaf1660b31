"""Failures with one cause are one finding, read off notices, findings and declarations; margins, against division by hand."""

import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import pandas as pd
import pytest

from plumbline.harness.findings.causes import CaseResult, Margin, causes, margins
from plumbline.harness.findings.vendor_findings import Finding
from plumbline.harness.store.record import StoredNotice
from plumbline.harness.store.store import Store
from plumbline.reports.tables.verdicts import margin_words
from plumbline.reports.words.text import TIMES
from tests.run_folder import row

DAMPED = tuple(
    StoredNotice(text=f"{name} stays", kind="surplus", effect=name) for name in ("angular_damping", "linear_damping")
)
TURNS = StoredNotice(text="the term stays", kind="surplus", effect="gyroscopic")
TRAP = Finding(
    name="bullet/damping", engine="bullet", kind="trap", title="Every body is damped", seen=("3.2.7",), documented="so",
    sources=(), mend="say 0", cases=(), requires=(), script=Path("damping.py"), text="", tracks=("default",),
    effects=("linear_damping", "angular_damping"), cause="hidden damping of 0.04/s",
)  # fmt: skip


class Noted(Store):
    """A store of trials with these notices: two tracks of one engine in four cases."""

    def __init__(self, notices: dict[str, tuple[StoredNotice, ...]], emulated: tuple[dict[str, Any], ...] = ()) -> None:
        self.folder = Path("noted")
        trials = [row(c, "bullet", t, 0.01, trial=f"{c}-{t}") for c in "abcd" for t in ("default", "tuned")]
        columns = ["trial", "metric", "value", "unit", "at_most", "passed", "because"]
        self.__dict__["_read"] = {
            "trials": pd.DataFrame(trials),
            "measurements": pd.DataFrame([], columns=columns),
            "samples": pd.DataFrame({"trial": [], "process": [], "block": []}),
        }
        cases = {c: {"name": c, "features": ["springs"], "checks": [], "parameters": {}, "dt": 0.01} for c in "abcd"}
        tracks: dict[str, Any] = {"default": {}, "tuned": {}}
        self.__dict__["catalogue"] = {"cases": cases, "engines": {"bullet": {"tracks": tracks, "emulated": list(emulated)}}}
        self.__dict__["notices"] = notices
        self.__dict__["machine"] = self.__dict__["study"] = {}


def answers(**statuses: tuple[str, str]) -> list[CaseResult]:
    """The status of each case on default and on tuned."""
    return [
        CaseResult(case, "bullet", track, f"{case}-{track}", status)
        for case, pair in statuses.items()
        for track, status in zip(("default", "tuned"), pair, strict=True)
    ]


def test_cases_that_fail_by_one_effect_are_one_finding_that_says_which_of_them_another_track_passes() -> None:
    store = Noted({f"{case}-default": (*DAMPED, TURNS) for case in "abc"} | {f"{case}-tuned": (TURNS,) for case in "abc"})
    asked = answers(a=("failed", "passed"), b=("failed", "passed"), c=("passed", "passed"), d=("failed", "failed"))
    first, *rest = causes(store, asked, [TRAP])
    assert (first.by, first.effects, first.finding) == ("effect", ("angular_damping", "linear_damping"), TRAP)
    assert [answer.case for answer in first.failures] == list(first.cured) == ["a", "b"]
    # A term that the passing track has as well is no cause; d has no notice, and nobody says why it fails on either track.
    assert [(cause.track, cause.by, cause.cured) for cause in rest] == [
        ("default", "unexplained", ()),
        ("tuned", "unexplained", ()),
    ]


def test_an_effect_that_no_other_track_does_without_is_not_called_a_cause() -> None:
    store = Noted({f"a-{track}": DAMPED for track in ("default", "tuned")})
    (cause, other) = causes(store, answers(a=("failed", "failed")), [TRAP])
    assert {cause.by, other.by} == {"unexplained"}


def test_a_finding_is_a_cause_where_it_says_so_on_its_tracks_and_in_its_cases() -> None:
    cone = replace(TRAP, name="bullet/cone", cases=("a", "b"), effects=(), cause="friction as a box")
    silent = replace(cone, name="bullet/silent", cause="")
    found = causes(Noted({}), answers(a=("failed", "failed"), b=("diverged", "passed"), c=("failed", "passed")), [silent, cone])
    assert [(cause.by, cause.track, len(cause.failures)) for cause in found] == [
        ("finding", "default", 2),
        ("unexplained", "tuned", 1),
        ("unexplained", "default", 1),
    ]
    assert found[0].finding == cone


def test_what_fails_by_a_law_of_the_adapter_is_put_down_to_the_adapter() -> None:
    made = {"feature": "springs", "how": "torques", "where": "", "tracks": ["tuned"]}
    found = causes(Noted({}, (made,)), answers(a=("failed", "failed")), [])
    assert {(cause.track, cause.by, cause.features) for cause in found} == {
        ("default", "unexplained", ()),
        ("tuned", "emulated", ("springs",)),
    }


def test_what_an_engine_cannot_express_is_no_failure() -> None:
    assert causes(Noted({}), answers(a=("unsupported", "passed"), b=("", "passed")), [TRAP]) == ()


def test_the_margin_of_a_trial_is_that_of_its_worst_check_and_of_more_is_better_the_other_way_round() -> None:
    store = Noted({})
    table = store.__dict__["_read"]["measurements"]
    rows = [
        ("a-default", "e", 0.5, 1.0, True),
        ("a-default", "held", 0.25, 0.5, False),
        ("a-tuned", "e", -0.5, 1.0, True),
        ("a-tuned", "gap", math.nan, math.nan, None),
        ("b-default", "e", math.inf, 1.0, False),
    ]
    store.__dict__["_read"]["measurements"] = pd.DataFrame(
        [dict(zip(table.columns, (t, m, v, "m", bound, passed, ""), strict=True)) for t, m, v, bound, passed in rows]
    )
    store.catalogue["cases"]["a"]["checks"] = [{"metric": "held", "better": "higher"}]
    found = margins(store)
    assert {trial: (margin.metric, margin.times) for trial, margin in found.items()} == {
        "a-default": ("held", 2.0),
        "a-tuned": ("e", 0.5),
        "b-default": ("e", math.inf),
    }


@pytest.mark.parametrize(
    ("times", "words"),
    [
        (34.4, "34x"),
        (5954.0, "6000x"),
        (1.004, "1.004x"),
        (0.3, "0.3x"),
        (0.97, "0.97x"),
        (1e-9, "<0.001x"),
        (math.inf, "no number"),
    ],
)
def test_a_margin_in_words(times: float, words: str) -> None:
    assert margin_words(Margin(times, "e", times, 1.0, "m")) == words.replace("x", TIMES)


def test_where_nothing_is_allowed_a_margin_is_the_value_itself() -> None:
    assert margin_words(Margin(math.inf, "missed", 3.0, 0.0, "1")) == "3 > 0"
    assert margin_words(Margin(math.inf, "sink", 0.0123, 0.0, "m/s2")) == "0.012 m/s² > 0"
