"""Rows on standard output: as a table for people, as JSON for programs, as CSV for spreadsheets, as Markdown for notes.

Text of engines and files may be hostile: control characters never reach a terminal, nor a formula a spreadsheet.
"""

import csv
import json
import math
import sys
from collections.abc import Callable, Sequence
from typing import Any

from plumbline.harness.findings.columns import Span
from plumbline.harness.intake.safe_text import LONGEST, csv_cell, latex_cell, markdown_cell, one_line

MOST_ROWS = 1000
"""That a table for people shows: each costs a millisecond."""


def print_json(rows: Sequence[dict[str, Any]]) -> None:
    """One JSON array of flat rows in printable ASCII; numbers that are not finite become null."""

    def plain(value: Any) -> Any:
        if isinstance(value, float) and not math.isfinite(value):
            return None
        if isinstance(value, dict):
            return {key: plain(element) for key, element in value.items()}
        if isinstance(value, list | tuple):
            return [plain(element) for element in value]
        return value

    text = json.dumps([plain(row) for row in rows], indent=1, allow_nan=False, default=str)
    print(text.replace("\x7f", "\\u007f"))


def print_table(
    title: str, columns: Sequence[str], rows: Sequence[Any], cells: Callable[[Any], Sequence[object]] = list
) -> None:
    """A table with a title, as wide as the terminal or 160 characters; of a long one the first `MOST_ROWS` rows.

    cells: what is shown of a row.
    """
    from rich.console import Console
    from rich.table import Table
    from rich.text import Text

    def plain(text: object) -> Text:
        return Text(one_line(str(text), LONGEST))

    table = Table(title=plain(title), title_justify="left", header_style="bold")
    for column in columns:
        table.add_column(plain(column), overflow="fold")
    for row in rows[:MOST_ROWS]:
        table.add_row(*map(plain, cells(row)))
    width = None if sys.stdout.isatty() else 160
    Console(width=width).print(table)
    if len(rows) > MOST_ROWS:
        print(f"and {len(rows) - MOST_ROWS} more rows; --format json prints all {len(rows)}")


def print_csv(columns: Sequence[str], rows: Sequence[dict[str, Any]]) -> None:
    """Comma-separated values with a header."""
    writer = csv.writer(sys.stdout)
    writer.writerow([csv_cell(column) for column in columns])
    writer.writerows([csv_cell(row[column]) for column in columns] for row in rows)


def print_markdown(columns: Sequence[str], rows: Sequence[Sequence[object]]) -> None:
    """A table in Markdown, numbers to three digits, columns of numbers flush right."""
    print("| " + " | ".join(map(markdown_cell, columns)) + " |")
    print("|" + "".join("--:|" if number else "---|" for number in _numeric(columns, rows)))
    for row in rows:
        print("| " + " | ".join(_value(cell, "-", " to ", f"{{:.{DIGITS}g}}".format, markdown_cell) for cell in row) + " |")


DIGITS = 3
"""Of a number in a paper or a note."""


def print_latex(columns: Sequence[str], rows: Sequence[Sequence[object]], source: Sequence[tuple[str, str]]) -> None:
    """A table for LaTeX with the package booktabs, numbers to three digits, columns of numbers flush right.

    Args: source: what it was made from, as comments above it.
    """
    numeric = _numeric(columns, rows)
    for name, value in source:
        print(f"% {one_line(name, LONGEST)}: {one_line(value, LONGEST)}")
    print(r"% \usepackage{booktabs}")
    print(rf"\begin{{tabular}}{{@{{}}{''.join('r' if number else 'l' for number in numeric)}@{{}}}}")
    print(r"\toprule")
    print(" & ".join(map(latex_cell, columns)) + r" \\")
    print(r"\midrule")
    for row in rows:
        print(" & ".join(_value(cell, "--", "--", _latex_number, latex_cell) for cell in row) + r" \\")
    print(r"\bottomrule")
    print(r"\end{tabular}")


def _numeric(columns: Sequence[str], rows: Sequence[Sequence[object]]) -> list[bool]:
    """Which columns hold numbers alone, and gaps."""
    return [bool(rows) and all(_is_number(row[k]) or row[k] in (None, "") for row in rows) for k in range(len(columns))]


def _is_number(value: object) -> bool:
    return isinstance(value, int | float | Span) and not isinstance(value, bool)


def _value(value: object, gap: str, to: str, number: Callable[[float], str], text: Callable[[object], str]) -> str:
    """A cell of a paper or a note. Args: gap: where there is nothing. to: between the ends of a span."""
    match value:
        case None:
            return gap
        case Span(low, high):
            return f"{number(low)}{to}{number(high)}"
        case float():
            return number(value)
        case _:
            return text(value)


def _latex_number(number: float) -> str:
    """To three digits: with its zeros, so that columns of one size line up; powers of ten
    below 1e-3, from 1e4 on, and of what is one."""
    if not math.isfinite(number):
        return "--" if math.isnan(number) else r"$\infty$" if number > 0 else r"$-\infty$"
    mantissa, _, exponent = f"{number:.{DIGITS - 1}e}".partition("e")
    power = int(exponent)
    if number != 0 and (not -3 <= power <= 3 or (power < 0 and number == 10.0**power)):
        factor = "" if float(mantissa) in (1.0, -1.0) else rf"{mantissa} \times "
        sign = "-" if float(mantissa) == -1.0 else ""
        return rf"${sign}{factor}10^{{{power}}}$"
    return f"${number:.{max(0, DIGITS - 1 - power)}f}$" if number else "$0$"
