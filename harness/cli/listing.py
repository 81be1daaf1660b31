"""Rows on standard output: as a table for people, as JSON for programs, as CSV for spreadsheets, as Markdown for notes.

Text of engines and files may be hostile: control characters never reach a terminal, nor a formula a spreadsheet.
"""

import csv
import json
import math
import sys
from collections.abc import Sequence
from typing import Any

from harness.intake.safe_text import LONGEST, csv_cell, markdown_cell, one_line

__all__ = ["print_csv", "print_json", "print_markdown", "print_table"]


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


def print_table(title: str, columns: Sequence[str], rows: Sequence[Sequence[object]]) -> None:
    """A table with a title, as wide as the terminal or 160 characters."""
    from rich.console import Console
    from rich.table import Table
    from rich.text import Text

    def plain(text: object) -> Text:
        return Text(one_line(str(text), LONGEST))

    table = Table(title=plain(title), title_justify="left", header_style="bold")
    for column in columns:
        table.add_column(plain(column), overflow="fold")
    for row in rows:
        table.add_row(*map(plain, row))
    width = None if sys.stdout.isatty() else 160
    Console(width=width).print(table)


def print_csv(columns: Sequence[str], rows: Sequence[dict[str, Any]]) -> None:
    """Comma-separated values with a header."""
    writer = csv.writer(sys.stdout)
    writer.writerow([csv_cell(column) for column in columns])
    writer.writerows([csv_cell(row[column]) for column in columns] for row in rows)


def print_markdown(columns: Sequence[str], rows: Sequence[dict[str, Any]]) -> None:
    """A table in Markdown."""
    print("| " + " | ".join(map(markdown_cell, columns)) + " |")
    print("|---" * len(columns) + "|")
    for row in rows:
        print("| " + " | ".join(markdown_cell(row[column]) for column in columns) + " |")
