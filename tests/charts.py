"""Do the charts on pages follow the schema of Vega-Lite? A report leaves that out, for it takes as long as drawing them."""

import json
import re
from collections.abc import Iterable, Sequence
from typing import Any

__all__ = ["checked", "rows_of", "specs"]

FIGURE = re.compile(
    r'<figure class="chart" id="([^"]+)">(?:(?!<figure).)*?<script type="application/json" class="spec">(.*?)</script>',
    re.DOTALL,
)


def rows_of(table: Any, words: Sequence[str]) -> list[dict[str, Any]]:
    """The rows of a table that travels by columns, as the page's script reads it. Args: words: said by the page so far."""
    if isinstance(table, list):
        return table
    fields = {
        field: values if isinstance(values, list) else [words[k] for k in values["words"]]
        for field, values in table["columns"].items()
    }
    return [{field: values[k] for field, values in fields.items()} for k in range(table["count"])]


def specs(page: str) -> list[dict[str, Any]]:
    """The charts of a page, their tables by rows."""
    said: dict[str, list[str]] = {}
    read = []
    for name, text in FIGURE.findall(page):
        spec = json.loads(text)
        said[name] = [*said.get(spec.pop("after", ""), []), *spec.pop("words")]
        spec["datasets"] = {table: rows_of(columns, said[name]) for table, columns in spec["datasets"].items()}
        read.append(spec)
    return read


def checked(pages: Iterable[str]) -> int:
    """How many charts the pages show, all of them by the schema.

    Raises:
        jsonschema.ValidationError: where one is not.
    """
    import altair as alt  # late: two files of all that are collected use it

    charts = [spec for page in pages for spec in specs(page)]
    for spec in charts:
        del spec["config"]["legend"]["layout"]  # Vega's own: Vega-Lite hands it on, and its schema does not know it
        alt.LayerChart.validate(spec)  # objects are not made of it: that would validate every part of it again
    return len(charts)
