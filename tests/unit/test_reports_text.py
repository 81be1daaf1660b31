"""Strings and numbers as the report shows them."""

import csv
import io
import math

import pytest

from plumbline.harness.intake.safe_text import csv_cell
from plumbline.reports.html.template import cite
from plumbline.reports.words.text import (
    amount,
    formula,
    join_words,
    knobs,
    plural,
    powers,
    settings_text,
    slug,
    unit_text,
    visible,
)
from tests.run_folder import HOSTILE


@pytest.mark.parametrize(
    ("value", "shown"),
    [
        (0.0, "0"),
        (1 / 240, "0.00417"),
        (12.0, "12"),
        (1234.5, "1230"),
        (-0.5, "-0.5"),
        (0.1, "0.1"),
        (100.4, "100"),
        (1e-7, "10⁻⁷"),
        (1.5e-7, "1.5\N{MULTIPLICATION SIGN}10⁻⁷"),
        (2e12, "2\N{MULTIPLICATION SIGN}10¹²"),
        (7, "7"),
        (math.nan, "NaN"),
        (math.inf, "∞"),
        (-math.inf, "\N{MINUS SIGN}∞"),
        (None, "\N{EN DASH}"),
        (True, "\N{EN DASH}"),
    ],
)
def test_numbers_are_shown_with_three_digits(value: float | None, shown: str) -> None:
    assert amount(value) == shown


@pytest.mark.parametrize(
    ("text", "shown"),
    [
        ("tolerance 1e-8, armature 2.5e12", "tolerance 10⁻⁸, armature 2.5\N{MULTIPLICATION SIGN}10¹²"),
        ("by .7 % (at e = .3)", "by 0.7 % (at e = 0.3)"),
        ("version 4.0.1, sec. 3.2, file.3, t.7", "version 4.0.1, sec. 3.2, file.3, t.7"),
        ("0.2 % in 0.5 s at 1e-3.", "0.2 % in 0.5 s at 10⁻³."),
        ("it rests.", "it rests."),
    ],
)
def test_numbers_in_prose_are_written_as_in_tables(text: str, shown: str) -> None:
    assert powers(text) == shown


def test_units_in_prose_are_raised_and_names_that_look_like_one_are_not() -> None:
    assert powers("armature of .004 kg m2") == "armature of 0.004 kg m\N{SUPERSCRIPT TWO}"
    assert powers("9.81 m/s2") == "9.81 m/s\N{SUPERSCRIPT TWO}"
    assert powers("joint m2 of arm/m/s2x") == "joint m2 of arm/m/s2x"


def test_units_formulas_and_knobs_have_one_notation_for_powers() -> None:
    assert [unit_text(unit) for unit in ("m/s2", "kg m2", "rad/s", "1", "N m", "s-1")] == [
        "m/s²",
        "kg m²",
        "rad/s",
        "1",
        "N m",
        "s⁻¹",
    ]
    assert formula("mass / 3 (b^2 + c^2), R^T f, h^-1, a^b") == "mass / 3 (b² + c²), Rᵀ f, h⁻¹, a^b"
    assert knobs("tuned, split_impulse True, tolerance 1e-07") == "tuned, split impulse on, tolerance 10⁻⁷"


def test_a_number_that_rounds_up_to_the_next_power_keeps_its_size() -> None:
    assert amount(0.9999) in ("1", "1.00")
    assert amount(99.96) == "100"
    assert amount(9.9996e-4) in ("10⁻³",)


def test_controls_and_direction_marks_are_spelled_out() -> None:
    assert visible("\u202egnp.exe") == "\\u202egnp.exe"
    assert visible("\x1b[31mred") == "\\u001b[31mred"
    assert visible("a\nb\tc, ü 汉") == "a\nb\tc, ü 汉"


def test_a_megabyte_is_cut_and_says_so() -> None:
    shown = visible("x" * 1_000_000)
    assert len(shown) < 2100
    assert shown.endswith("(998000 characters more)")


@pytest.mark.parametrize("start", ["=", "+", "-", "@", "\t", "\r"])
def test_no_cell_of_a_csv_starts_a_formula(start: str) -> None:
    text = io.StringIO()
    csv.writer(text).writerow([csv_cell(f"{start}1+1")])
    (cell,) = next(csv.reader(io.StringIO(text.getvalue())))
    assert cell.startswith("'")


def test_numbers_in_a_csv_stay_numbers() -> None:
    assert csv_cell(-1.5) == -1.5


@pytest.mark.parametrize("name", [*HOSTILE, "../../etc/passwd", "", ".", "a b", "ü"])
def test_any_name_gives_a_plain_file_name(name: str) -> None:
    made = slug(name)
    assert made
    assert len(made) <= 80
    assert all(c.isascii() and (c.isalnum() or c in "_-") for c in made)


def test_two_names_with_the_same_letters_get_two_files() -> None:
    assert slug("a b") != slug("a/b")
    assert slug("joint_pendulum") == "joint_pendulum"


def test_a_source_links_web_addresses_only() -> None:
    linked = str(cite("see https://example.org/a?b=1&c=2. Or javascript:alert(1) <b>"))
    assert 'href="https://example.org/a?b=1&amp;c=2"' in linked
    assert linked.count("<a ") == 1
    assert "&lt;b&gt;" in linked
    assert str(cite('https://example.org/"onload="x')).count('"') == 4  # the four quotes of two attributes


def test_settings_are_flattened_without_their_source() -> None:
    told = settings_text('{"dt": 0.01, "options": {"cone": "elliptic", "warm": true}, "source": "guide"}')
    assert told == "dt 1/100 s, cone elliptic, warm on"
    assert settings_text("not json") == "not json"


def test_words_are_joined_and_counted() -> None:
    assert [join_words(list("abc")[:k]) for k in range(4)] == ["", "a", "a and b", "a, b and c"]
    assert [plural(k, "case") for k in (0, 1, 2)] == ["0 cases", "1 case", "2 cases"]
