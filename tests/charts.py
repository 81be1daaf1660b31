"""Do the charts on pages follow the schema of Vega-Lite? A report leaves that out, for it takes as long as drawing them."""

import json
import re
from collections.abc import Iterable

__all__ = ["checked"]

SPEC = re.compile(r'<script type="application/json" class="spec">(.*?)</script>', re.DOTALL)


def checked(pages: Iterable[str]) -> int:
    """How many charts the pages show, all of them by the schema.

    Raises:
        jsonschema.ValidationError: where one is not.
    """
    import altair as alt  # late: two files of all that are collected use it

    specs = [json.loads(text) for page in pages for text in SPEC.findall(page)]
    for spec in specs:
        del spec["config"]["legend"]["layout"]  # Vega's own: Vega-Lite hands it on, and its schema does not know it
        alt.LayerChart.from_dict(spec, validate=True)
    return len(specs)
