"""A figure: one Vega-Lite specification with its static SVG, its words and the table of what it draws.

The legend of a still one is as a live one has it: engines by shape and colour, then tracks, in as few lines as fit.
"""

import hashlib
import json
import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import suppress
from copy import deepcopy
from dataclasses import dataclass
from functools import cached_property
from importlib.metadata import version
from operator import itemgetter
from pathlib import Path
from textwrap import wrap
from typing import Any

from markupsafe import Markup

from plumbline.reports.charts.compact import new_words, shown_rows, shown_spec
from plumbline.reports.words.text import amount

SIGN, LETTER, BETWEEN = 24.0, 6.0, 12.0
"""Widths [px] of a symbol with its room, of a letter of the legend, and between two entries."""
WIDE, SHORT = 7.5, 240.0
"""Widths [px] of a letter at most, and of names that no legend cuts, and that need no measuring."""
BESIDE, NAMED = 60, 110
"""What the axis takes of the width of a chart [px], and what it takes where lanes are named: the legend begins at the frame."""
INK = "#1d232c"


def with_legend(spec: dict[str, Any], width: int) -> dict[str, Any]:
    """The chart with its legends above all that it draws, at the left; hollow and filled signs tell tracks as on the page."""
    encodings = [layer.get("encoding", {}) for layer in spec.get("layer", [spec])]
    lanes = [row["lane"] for rows in spec.get("datasets", {}).values() for row in rows if "lane" in row]
    above, room = 8 - min(lanes, default=0), width - (NAMED if lanes else BESIDE)
    for encoding in encodings:
        for channel in ("color", "stroke", "shape"):
            if "scale" in encoding.get(channel, {}):
                encoding[channel]["legend"] = _laid(encoding[channel]["scale"]["domain"], room, above)
    fillings: dict[str, Any] = next(
        (encoding["fillOpacity"]["scale"] for encoding in encodings if "fillOpacity" in encoding), {}
    )
    tracks = _by_filling(fillings.get("domain", ()), fillings.get("range", ()))
    if "layer" in spec and len(tracks) > 1:
        for encoding in encodings:
            if "strokeDash" in encoding:
                encoding["strokeDash"]["legend"] = None
        spec["layer"].append(_tracks(tracks, room, above))
    return spec


def _by_filling(tracks: Sequence[str], fillings: Sequence[float]) -> dict[str, str]:
    """What the legend calls tracks that are drawn alike, to the colour of their sign; 'others' are several."""
    names: dict[float, list[str]] = {}
    for track, filling in zip(tracks, fillings, strict=True):
        names.setdefault(filling, []).append(track)
    red, green, blue = (int(INK[k : k + 2], 16) for k in (1, 3, 5))
    return {
        listed[0] if len(listed) == 1 else "others": f"rgba({red},{green},{blue},{filling:g})"
        for filling, listed in names.items()
    }


def _tracks(tracks: Mapping[str, str], room: float, above: float) -> dict[str, Any]:
    """A layer that draws nothing and has the legend of tracks: a legend knows no filling, one of dashes draws lines."""
    legend = _laid(list(tracks), room, above) | {"symbolType": "circle", "symbolStrokeColor": INK, "values": list(tracks)}
    fill = {
        "field": "filling",
        "type": "nominal",
        "title": None,
        # The other way round than the dashes' domain: legends of one domain are made one, and theirs is put away.
        "scale": {"domain": list(tracks)[::-1], "range": list(tracks.values())[::-1]},
        "legend": legend,
    }
    return {
        "data": {"values": [{"filling": track} for track in tracks]},
        "mark": {"type": "point", "opacity": 0},
        "encoding": {"x": {"value": 0}, "y": {"value": 0}, "fill": fill},
    }


def _laid(names: Sequence[str], room: float, above: float) -> dict[str, Any]:
    """As many entries in a line as fit, in columns as wide as their widest."""
    widths = [SIGN + LETTER * len(str(name)) + BETWEEN for name in names]
    columns = next(
        (count for count in range(len(widths), 1, -1) if sum(max(widths[k::count]) for k in range(count)) <= room), 1
    )
    legend = {"columns": columns, "title": None, "offset": above, "gridAlign": "each"}
    widest = WIDE * max((len(str(name)) for name in names), default=0)
    return legend | ({"labelLimit": 0} if widest < min(SHORT, room - BESIDE) else {})


POINTS = 2000
"""Most points of one series that are drawn."""

VEGA_LITE = "6.4"
"""The version that charts are said in, vl-convert draws and the page's bundle reads."""

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
        "labelSeparation": 5,
    },
    "legend": {"labelColor": "#1d232c", "titleColor": "#4a5361", "titleFontWeight": 500, "labelFontSize": 12},
}
"""Colours and fonts of static charts; the page's script has the same for the dark scheme."""

LETTER = 0.6 * LIGHT["axis"]["titleFontSize"]
"""Pixels of a letter of a title: in the widest of the titles of all metrics one takes 0.598 of the size of the letters."""


@dataclass(frozen=True)
class Figure:
    """A chart on a page.

    Terms:
        name: the file `charts/<name>.svg`, unique in the report. title, caption: in words, what is drawn, in two lines at most;
        how: how to read it, behind a fold; '' without.
        spec: Vega-Lite with its data inside. columns: headings of the table below it; rows: its cells, as drawn. after: the
        figure before it on the same page whose trials it shows too, and whose words it does not say again.
    """

    name: str
    title: str
    caption: str
    spec: dict[str, Any]
    columns: Sequence[str]
    rows: Sequence[Sequence[Any]]
    how: str = ""
    after: "Figure | None" = None

    @property
    def path(self) -> str:
        """The static picture, relative to the report."""
        return f"charts/{self.name}.svg"

    @property
    def shown(self) -> Markup:
        """The specification as the page's script reads it."""
        return shown_spec(self.spec) if self.after is None else shown_spec(self.spec, self.after._said, self.after.name)

    @cached_property
    def _said(self) -> Sequence[str]:
        """The words that a page has once it has shown this and what it comes after."""
        known = self.after._said if self.after is not None else ()
        return (*known, *new_words(self.spec, known))

    def _finished(self, width: int) -> dict[str, Any]:
        """The specification for a picture that nobody hovers over, and whose words stand beside it."""
        shown = _still(self.spec) | {"width": width}
        if "layer" in shown:
            shown["layer"] = [_still(layer) for layer in shown["layer"]]
        rows = shown_rows(shown)
        spec = with_legend(
            deepcopy({key: value for key, value in shown.items() if key != "datasets"}) | {"datasets": rows}, width
        )
        # Numbers are cut nowhere. What has no limit is not measured: here and in the legend together a seventh of a drawing.
        still = {"axis": LIGHT["axis"] | {"labelLimit": 0}, "aria": False}
        config = LIGHT | still | {"legend": LIGHT["legend"] | self.spec.get("config", {}).get("legend", {})}
        return spec | {"config": config}

    @cached_property
    def svg(self) -> str:
        """The static picture, drawn without a browser; stands in for the chart in print and where scripts are off."""
        import vl_convert  # late: it brings a JavaScript engine

        drawn: str = vl_convert.vegalite_to_svg(self._finished(640), vl_version=VEGA_LITE, allowed_base_urls=[])
        return _numbered(drawn) + self._mark

    @cached_property
    def _mark(self) -> str:
        """What a picture ends with: by what it was drawn, and a digest of all that it shows."""
        drawn = json.dumps([version("vl-convert-python"), VEGA_LITE, "frames by number", self._finished(640)], sort_keys=True)
        return f"<!-- {hashlib.sha256(drawn.encode()).hexdigest()[:20]} -->"

    def standing(self, report: Path) -> str | None:
        """The same picture in an earlier report of the folder, where it is whole."""
        with suppress(OSError, UnicodeDecodeError):
            text = (report / self.path).read_bytes().decode()
            if text.endswith(self._mark):
                return text
        return None

    def kept(self, report: Path) -> str:
        """The standing picture, else the one drawn now."""
        return self.standing(report) or self.svg

    def drawn(self, form: str, width: int = 640) -> bytes:
        """The static picture as the bytes of a file. Args: form: svg, pdf or png, at twice the resolution of a screen."""
        import vl_convert

        spec = _fitted(self._finished(width), width)
        if form == "svg":
            text: str = vl_convert.vegalite_to_svg(spec, vl_version=VEGA_LITE, allowed_base_urls=[])
            return _numbered(text).encode()
        if form == "pdf":
            return bytes(vl_convert.vegalite_to_pdf(spec, vl_version=VEGA_LITE, allowed_base_urls=[]))
        return bytes(vl_convert.vegalite_to_png(spec, vl_version=VEGA_LITE, allowed_base_urls=[], scale=2.0))


def tabled(
    rows: Iterable[Mapping[str, Any]], *columns: str | tuple[str, Callable[[Mapping[str, Any]], str]]
) -> tuple[list[str], list[list[Any]]]:
    """Headings and cells of the table below a chart: numbers in the digits of tables, counts and words as they are.

    Args: columns: a field, or 'heading=field' where it is called otherwise, or a heading with what makes its cells.
    """

    def cell(value: Any) -> Any:
        return amount(value) if value is None or isinstance(value, float) else value

    columns_of: list[tuple[str, Callable[[Mapping[str, Any]], Any]]] = []
    for column in columns:
        heading, _, field = column.partition("=") if isinstance(column, str) else (column[0], "", "")
        columns_of.append((heading, itemgetter(field or heading) if isinstance(column, str) else column[1]))
    return [heading for heading, _ in columns_of], [[cell(make(row)) for _, make in columns_of] for row in rows]


CLIP = re.compile(r'(?<=id="clip)\d+|(?<=url\(#clip)\d+')


def _numbered(svg: str) -> str:
    """A picture with its frames numbered by itself: they come numbered by what the process had drawn before."""
    numbers: dict[str, int] = {}
    return CLIP.sub(lambda found: str(numbers.setdefault(found[0], len(numbers))), svg)


def _still(part: Mapping[str, Any]) -> dict[str, Any]:
    """A specification, or a layer of one, without what hovering shows."""
    if "encoding" not in part:
        return dict(part)
    return dict(part) | {"encoding": {name: value for name, value in part["encoding"].items() if name != "tooltip"}}


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


def _fitted(spec: dict[str, Any], width: int) -> dict[str, Any]:
    """The same for a column: titles that are longer than their axis on several lines, names of the legend cut to the frame,
    and no higher than four fifths of the width, which leaves room for a caption."""
    height = min(int(spec.get("height", width)), int(0.8 * width))
    room = {"x": max(width - NAMED, 8 * LETTER), "y": max(height, 8 * LETTER)}
    for part in (spec, *spec.get("layer", ())):
        for name, letters in ((name, int(pixels / LETTER)) for name, pixels in room.items()):
            channel = part.get("encoding", {}).get(name, {})
            if isinstance(channel.get("title"), str):
                channel["title"] = wrap(channel["title"], letters)
    label = min(spec["config"]["legend"].get("labelLimit", width), width - NAMED)
    legend = spec["config"]["legend"] | {"labelLimit": label}
    return spec | {"height": height, "config": spec["config"] | {"legend": legend}}
