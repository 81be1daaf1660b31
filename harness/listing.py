"""Rows on standard output: as a table for people, as JSON for programs, as CSV for spreadsheets, as Markdown for notes.

Text of engines and files may be hostile: control characters never reach a terminal, nor a formula a spreadsheet.
"""

import csv
import json
import math
import sys
from collections.abc import Sequence
from typing import Any

__all__ = ["print_csv", "print_json", "print_markdown", "print_table"]


def print_json(rows: Sequence[dict[str, Any]]) -> None:
    """One JSON array of flat rows; numbers that are not finite become null."""

    def plain(value: Any) -> Any:
        if isinstance(value, float) and not math.isfinite(value):
            return None
        if isinstance(value, dict):
            return {key: plain(part) for key, part in value.items()}
        if isinstance(value, list | tuple):
            return [plain(part) for part in value]
        return value

    print(json.dumps([plain(row) for row in rows], indent=1, allow_nan=False, default=str))


def print_table(title: str, columns: Sequence[str], rows: Sequence[Sequence[object]]) -> None:
    """A table with a title, as wide as the terminal or 160 characters."""
    from rich.console import Console
    from rich.table import Table
    from rich.text import Text

    table = Table(title=title, title_justify="left", header_style="bold")
    for column in columns:
        table.add_column(column, overflow="fold")
    for row in rows:
        table.add_row(*(Text("".join(c if c.isprintable() or c == "\n" else "?" for c in str(cell))) for cell in row))
    width = None if sys.stdout.isatty() else 160
    Console(width=width).print(table)


def _guard_cell(cell: object) -> str:
    """A CSV cell that no spreadsheet takes for a formula."""
    text = str(cell)
    return f"'{text}" if text[:1] in {"=", "+", "@", "\t", "\r"} or (text[:1] == "-" and not text[1:2].isdigit()) else text


def print_csv(columns: Sequence[str], rows: Sequence[dict[str, Any]]) -> None:
    """Comma-separated values with a header."""
    writer = csv.writer(sys.stdout)
    writer.writerow(columns)
    writer.writerows([_guard_cell(row[column]) for column in columns] for row in rows)


def print_markdown(columns: Sequence[str], rows: Sequence[dict[str, Any]]) -> None:
    """A table in Markdown."""
    print("| " + " | ".join(columns) + " |")
    print("|---" * len(columns) + "|")
    for row in rows:
        cells = (str(row[column]).replace("|", "\\|").replace("\n", " ").replace("<", "&lt;") for column in columns)
        print("| " + " | ".join(cells) + " |")
