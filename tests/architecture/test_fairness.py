"""The page on fairness: its false findings have dates, and each is kept from coming back by tests that there are."""

import fnmatch
import re
from datetime import date
from pathlib import Path

import pytest

from plumbline.harness.findings.vendor_findings import shelf
from plumbline.harness.study import plugins
from plumbline.harness.study.study import load_study
from plumbline.reports.words.known_findings import TABLE, read

ROOT = Path(__file__).parents[2]
PAGE = ROOT / "docs" / "fairness.md"


def rows() -> list[list[str]]:
    """The cells of the table of false findings."""
    lines = PAGE.read_text(encoding="utf-8").split("## False findings")[1].splitlines()
    return [[cell.strip() for cell in line.strip("|").split("|")] for line in lines if re.match(r"\| \d", line)]


def test_every_false_finding_says_when_what_was_published_what_is_true_and_what_was_wrong() -> None:
    assert rows()
    for found, *told in rows():
        assert date.fromisoformat(found)
        assert len(told) == 4
        assert all(told)


@pytest.mark.parametrize("row", rows(), ids=lambda row: row[1][:60])
def test_every_false_finding_is_kept_from_coming_back_by_tests(row: list[str]) -> None:
    named = re.findall(r"`(tests/[\w/]+\.py)`", row[-1])
    assert named
    assert [path for path in named if not (ROOT / path).is_file()] == []


@pytest.mark.parametrize("page", ["README.md", "docs/architecture.md", "docs/method.md"])
def test_the_page_is_linked(page: str) -> None:
    assert "fairness.md)" in (ROOT / page).read_text(encoding="utf-8")


WITHOUT = "no vendor's script: "
"""What a row says before the reason for which a script in a vendor's words has no meaning."""


@pytest.mark.parametrize("row", rows(), ids=lambda row: row[1][:60])
def test_every_false_finding_has_a_script_in_the_vendor_s_words_or_says_why_not(row: list[str]) -> None:
    assert bool(re.search(r"`tests/vendor/test_\w+\.py`", row[-1])) != (WITHOUT in row[-1])
    assert WITHOUT not in row[-1] or row[-1].partition(WITHOUT)[2].strip()


def test_what_is_disputed_is_of_engines_cases_axes_and_studies_that_there_are() -> None:
    for one in read(TABLE):
        assert one.engine in plugins.adapters()
        case = plugins.case(one.case)
        assert one.axis in ("", *case.parameters)
        assert not one.study or load_study(one.study).name == one.study


def tried() -> dict[str, tuple[str, str]]:
    """What was tried against each claim, and what came of it, by the finding's name or the case."""
    lines = (
        PAGE.read_text(encoding="utf-8")
        .split("## Claims as their vendor's advocate tried them")[1]
        .split("\n## ")[0]
        .splitlines()
    )
    cells = [[cell.strip() for cell in line.strip("|").split("|")] for line in lines if line.startswith("| `")]
    assert all(len(row) == 3 for row in cells)
    return {name.strip("`"): (attempt, outcome) for name, attempt, outcome in cells}


def test_no_finding_and_no_limit_is_without_a_row_of_what_its_vendor_s_advocate_tried() -> None:
    searched = [
        case
        for experiment in load_study("limits").experiments
        if experiment.limit is not None
        for pattern in experiment.cases
        for case in fnmatch.filter(plugins.names("cases"), pattern)
    ]
    claims = {finding.name for finding in shelf()} | set(searched)
    assert claims - tried().keys() == set()
    assert tried().keys() - claims == set(), "a claim that is made no more"
    assert all(attempt and outcome for attempt, outcome in tried().values())
