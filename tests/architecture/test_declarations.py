"""The page on fairness has a row for whatever is said against an engine, and none for what is said no more."""

import re
from pathlib import Path

import pytest

from plumbline.harness.findings.vendor_findings import shelf
from tests.claims_made import ENGINES, PAGE, claims, plain

ROOT = Path(__file__).parents[2]
OUTCOMES = ("stands", "narrowed", "reworded", "mended", "withdrawn", "untried", "of no engine")
"""What a row's outcome begins with; the last is of sentences that name an engine and say nothing against it."""


def rows() -> list[tuple[list[str], str, str]]:
    """(the beginnings of the claims, what was tried, what came of it) of each row."""
    section = PAGE.read_text(encoding="utf-8").split("## Declarations as their vendor's advocate tried them")[1]
    lines = [line for line in section.split("\n## ")[0].splitlines() if line.startswith("| `")]
    cells = [[cell.strip() for cell in line.strip("|").split(" | ")] for line in lines]
    assert [row for row in cells if len(row) != 3] == []
    return [(re.findall("`([^`]+)`", made), tried, outcome) for made, tried, outcome in cells]


def test_every_claim_has_one_row() -> None:
    told = [beginning for made, _, _ in rows() for beginning in made]
    assert sorted({beginning for beginning in told if told.count(beginning) > 1}) == []
    covering = {claim: [t for t in told if claim.startswith(plain(t))] for claim in claims()}
    assert sorted(claim for claim, found in covering.items() if not found) == [], "said without a row"
    assert {claim: found for claim, found in covering.items() if len(found) > 1} == {}


def test_every_row_is_of_a_claim_that_is_made() -> None:
    told = [beginning for made, _, _ in rows() for beginning in made]
    assert [t for t in told if not any(claim.startswith(plain(t)) for claim in claims())] == []


@pytest.mark.parametrize("row", rows(), ids=lambda row: row[0][0][:60])
def test_a_row_tells_the_outcome_and_the_script_or_the_finding_that_shows_it(row: tuple[list[str], str, str]) -> None:
    """Or says, in words, why none can: `no script: ...`."""
    made, tried, outcome = row
    assert outcome.startswith(OUTCOMES)
    named = re.findall(r"`(test_\w+\.py)`", tried)
    found = re.findall(rf"`((?:{'|'.join(ENGINES)})/\w+)`", tried)
    assert bool(named or found) != ("no script: " in tried)
    assert [name for name in named if not [*ROOT.glob(f"tests/*/{name}")]] == []
    assert [name for name in found if name not in {finding.name for finding in shelf()}] == []
    assert outcome.startswith("of no engine") or any(len(beginning) > 8 for beginning in made)
