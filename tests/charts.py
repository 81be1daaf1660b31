"""Do the charts on pages follow the schema of Vega-Lite? A report leaves that out, for it takes as long as drawing them."""

import json
import re
from collections.abc import Iterable
from typing import Any

__all__ = ["checked", "rows_of"]

SPEC = re.compile(r'<script type="application/json" class="spec">(.*?)</script>', re.DOTALL)


def rows_of(table: Any) -> list[dict[str, Any]]:
    """The rows of a table that travels by columns, as the page's script reads it."""
    if isinstance(table, list):
        return table
    fields = {
        field: values if isinstance(values, list) else [values["words"][k] for k in values["of"]]
        for field, values in table["columns"].items()
    }
    return [{field: values[k] for field, values in fields.items()} for k in range(table["count"])]


def checked(pages: Iterable[str]) -> int:
    """How many charts the pages show, all of them by the schema.

    Raises:
        jsonschema.ValidationError: where one is not.
    """
    import altair as alt  # late: two files of all that are collected use it

    specs = [json.loads(text) for page in pages for text in SPEC.findall(page)]
    for spec in specs:
        spec["datasets"] = {name: rows_of(table) for name, table in spec["datasets"].items()}
        del spec["config"]["legend"]["layout"]  # Vega's own: Vega-Lite hands it on, and its schema does not know it
        alt.LayerChart.from_dict(spec, validate=True)
    return len(specs)
