"""A figure: one Vega-Lite specification with its static SVG, its words and the table of what it draws."""

import json
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

from reports.still_legend import with_legend

__all__ = ["POINTS", "Figure", "thin"]

POINTS = 2000
"""Most points of one series that are drawn."""

VEGA_LITE = "6.4"
"""The version that altair writes, vl-convert draws and the page's bundle reads."""

LIGHT: dict[str, Any] = {
    "background": "#ffffff",
    "font": "system-ui, 'Segoe UI', Roboto, 'DejaVu Sans', sans-serif",
    "view": {"stroke": "#d5d9e0"},
    "axis": {
        "gridColor": "#e9ecf1",
        "domainColor": "#9aa3b0",
        "tickColor": "#9aa3b0",
        "labelColor": "#4a5361",
        "titleColor": "#1d232c",
        "titleFontWeight": 500,
        "labelFontSize": 11,
        "titleFontSize": 12,
    },
    "legend": {"labelColor": "#1d232c", "titleColor": "#4a5361", "titleFontWeight": 500, "labelFontSize": 12},
}
"""Colours and fonts of static charts; the page's script has the same for the dark scheme."""


@dataclass(frozen=True)
class Figure:
    """A chart on a page.

    Terms:
        name: the file `charts/<name>.svg`, unique in the report. title, caption: in words, what is drawn, in two lines at most;
        how: how to read it, behind a fold; '' without.
        spec: Vega-Lite with its data inside. columns: headings of the table below it; rows: its cells, as drawn.
    """

    name: str
    title: str
    caption: str
    spec: dict[str, Any]
    columns: Sequence[str]
    rows: Sequence[Sequence[Any]]
    how: str = ""

    @property
    def path(self) -> str:
        """The static picture, relative to the report."""
        return f"charts/{self.name}.svg"

    def _finished(self, width: int) -> dict[str, Any]:
        spec: dict[str, Any] = with_legend(json.loads(json.dumps(self.spec)) | {"width": width}, width)
        spec["config"] = LIGHT | {"legend": LIGHT["legend"] | spec.get("config", {}).get("legend", {})}
        return spec

    @cached_property
    def svg(self) -> str:
        """The static picture, drawn without a browser; stands in for the chart in print and where scripts are off."""
        import vl_convert  # late: it brings a JavaScript engine

        drawn: str = vl_convert.vegalite_to_svg(self._finished(640), vl_version=VEGA_LITE, allowed_base_urls=[])
        return drawn

    def drawn(self, form: str, width: int = 640) -> bytes:
        """The static picture as the bytes of a file. Args: form: svg, pdf or png, at twice the resolution of a screen."""
        import vl_convert

        spec = self._finished(width)
        if form == "svg":
            text: str = vl_convert.vegalite_to_svg(spec, vl_version=VEGA_LITE, allowed_base_urls=[])
            return text.encode()
        if form == "pdf":
            return bytes(vl_convert.vegalite_to_pdf(spec, vl_version=VEGA_LITE, allowed_base_urls=[]))
        return bytes(vl_convert.vegalite_to_png(spec, vl_version=VEGA_LITE, allowed_base_urls=[], scale=2.0))


def thin(rows: Sequence[dict[str, Any]], x: str, y: str, limit: int = POINTS) -> list[dict[str, Any]]:
    """At most `limit` rows that draw the same outline: smallest and largest y of each of limit / 2 stretches along x."""
    if len(rows) <= limit:
        return list(rows)
    ordered = sorted(rows, key=lambda row: (row[x], row[y]))
    stretches = limit // 2
    kept: list[dict[str, Any]] = []
    for k in range(stretches):
        stretch = ordered[k * len(ordered) // stretches : (k + 1) * len(ordered) // stretches]
        low, high = min(stretch, key=lambda row: row[y]), max(stretch, key=lambda row: row[y])
        kept += [low] if low is high else sorted((low, high), key=lambda row: (row[x], row[y]))
    return kept
