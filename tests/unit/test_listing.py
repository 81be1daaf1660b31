"""Listings: whatever a name or an error text holds, it stays text."""

import csv
import io
import json

import pytest

from plumbline.harness.cli.listing import print_csv, print_json, print_markdown, print_table
from plumbline.harness.findings.columns import Span

HOSTILE = (
    "<script>alert(1)</script>",
    "=cmd()|' /C calc'!A0",
    "\x1b[31mred",
    "a|b\nc",
    "\u202eright to left",
    "@sum",
    "-x",
    "+x",
)
ROWS = [{"name": text, "value": 1.5} for text in HOSTILE]


def test_no_control_character_reaches_a_terminal(capsys: pytest.CaptureFixture[str]) -> None:
    print_table("t", ("name",), [(text,) for text in HOSTILE])
    shown = capsys.readouterr().out
    assert "\x1b" not in shown
    assert "\u202e" not in shown
    assert "red" in shown


def test_no_cell_is_a_formula(capsys: pytest.CaptureFixture[str]) -> None:
    print_csv(("name", "value"), [*ROWS, {"name": "n", "value": -1.5}])
    rows = list(csv.DictReader(io.StringIO(capsys.readouterr().out)))
    assert len(rows) == len(HOSTILE) + 1
    assert not any(row["name"].startswith(("=", "+", "-", "@")) for row in rows)
    assert rows[-1]["value"] == "-1.5"


def test_markdown_keeps_one_row_a_line_and_no_markup(capsys: pytest.CaptureFixture[str]) -> None:
    print_markdown(("name", "value"), [tuple(row.values()) for row in ROWS])
    lines = capsys.readouterr().out.splitlines()
    assert len(lines) == 2 + len(HOSTILE)
    assert all(line.replace("\\|", "").count("|") == 3 for line in lines)
    assert "<script>" not in "".join(lines)


def test_json_is_strict_and_a_number_that_is_not_finite_is_null(capsys: pytest.CaptureFixture[str]) -> None:
    print_json([*ROWS, {"name": "n", "value": float("nan"), "parts": [float("inf"), {"x": -float("inf")}]}])
    rows = json.loads(capsys.readouterr().out, parse_constant=lambda name: pytest.fail(name))
    assert [row["name"] for row in rows[:-1]] == list(HOSTILE)
    assert rows[-1] == {"name": "n", "value": None, "parts": [None, {"x": None}]}


def test_numbers_in_markdown_have_three_digits_and_stand_flush_right(capsys: pytest.CaptureFixture[str]) -> None:
    print_markdown(("name", "cost", "from"), [("a", 0.000319074, Span(1.0, 2.5e6)), ("b", None, None), ("c", 12, None)])
    assert capsys.readouterr().out.splitlines() == [
        "| name | cost | from |",
        "|---|--:|--:|",
        "| a | 0.000319 | 1 to 2.5e+06 |",
        "| b | - | - |",
        "| c | 12 | - |",
    ]
