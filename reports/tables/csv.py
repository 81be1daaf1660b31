"""A table as comma-separated values, with no cell that a spreadsheet takes for a formula."""

import csv
import io
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from plumbline.harness.intake.safe_text import csv_cell


def sheet(columns: Sequence[str], rows: Iterable[Mapping[str, Any]]) -> str:
    """A line of headings and one for each row; None is an empty cell."""
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow([csv_cell(name) for name in columns])
    writer.writerows([csv_cell(row[name]) for name in columns] for row in rows)
    return text.getvalue()
