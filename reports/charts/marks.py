"""The look of marks and axes in every chart: colour and shape of an engine, filling and dashes of a track, ticks, hovering.

One colour and one marker shape per engine, the same on every page and in every chart.

Colours after Okabe & Ito, 'Color Universal Design' (2008), two of them darkened until each keeps a contrast of 3:1 (WCAG 2.2,
1.4.11) against the light and against the dark page. Shapes make the colours redundant.
"""

import json
import math
import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any

from plumbline.harness.store.store import Store
from plumbline.reports.charts.grammar import Channel, Row, channel, chart, fixed, layered
from plumbline.reports.words.called import WORDS
from plumbline.reports.words.catalogue import labels
from plumbline.reports.words.text import amount


@dataclass(frozen=True, slots=True)
class EngineLook:
    """A colour (#rrggbb) and a marker: an SVG path within -1..1, which Vega and HTML both draw."""

    colour: str
    path: str


CIRCLE = "M1,0A1,1,0,1,1,-1,0A1,1,0,1,1,1,0Z"
SQUARE = "M-.89,-.89H.89V.89H-.89Z"
DIAMOND = "M0,-1.2L1.1,0L0,1.2L-1.1,0Z"
TRIANGLE_UP = "M0,-1.1L1.1,.85H-1.1Z"
TRIANGLE_DOWN = "M0,1.1L1.1,-.85H-1.1Z"
CROSS = "M-.38,-1.1H.38V-.38H1.1V.38H.38V1.1H-.38V.38H-1.1V-.38H-.38Z"
PENTAGON = "M0,-1.1L1.05,-.34L.65,.9H-.65L-1.05,-.34Z"
BAR = "M-.45,-1.1H.45V1.1H-.45Z"
HOURGLASS = "M-1,-1H1L.3,0L1,1H-1L-.3,0Z"
FLAT = "M-1.1,-.45H1.1V.45H-1.1Z"

BACKGROUNDS = {"light": "#ffffff", "dark": "#15191f"}
"""What charts stand on; the style sheet uses the same two."""

ENGINES: dict[str, EngineLook] = {
    "reference": EngineLook("#d55e00", DIAMOND),
    "mujoco": EngineLook("#0077bb", CIRCLE),
    "bullet": EngineLook("#009e73", SQUARE),
    "dart": EngineLook("#c0639a", TRIANGLE_UP),
    "sapien": EngineLook("#a87900", TRIANGLE_DOWN),
    "drake": EngineLook("#2e93c9", CROSS),
    "newton": EngineLook("#7f7f8c", PENTAGON),
}
"""The engines that have an adapter here."""

SPARE: tuple[EngineLook, ...] = (
    EngineLook("#8f6bd1", BAR),
    EngineLook("#6b8e23", HOURGLASS),
    EngineLook("#c94c4c", FLAT),
    EngineLook("#a0723c", CIRCLE),
)
"""For engines of third parties, in alphabetical order of their names."""


def looks(names: Iterable[str]) -> dict[str, EngineLook]:
    """A look for each engine, in the order given; spare ones repeat only beyond the last."""
    listed = list(names)
    strangers = sorted(name for name in listed if name not in ENGINES)
    spare = {name: SPARE[index % len(SPARE)] for index, name in enumerate(strangers)}
    return {name: ENGINES.get(name) or spare[name] for name in listed}


POINT: Row = {"filled": True, "size": 70, "strokeWidth": 1.6, "opacity": 1}
TRACKS = ("default", "tuned")
OURS = re.compile(r"^\S+ (.+) \(ours\)")
OPEN, HALF = 0.0001, 0.35
"""Opacities of the filling of marks; 1 is filled."""
LANE = 15
"""Height of one row of outcomes above a chart [px]."""
SHARES: Row = {"labelExpr": "round(100 * datum.value) + ' %'"}
"""The axis of a share, in per cent."""
NUMBERS = ("dt", "error", "pace", "cpu", "low", "high")
HOVER = WORDS["hovering"]
"""What hovering shows of a trial, by field."""


class Marks:
    """The look of engines and tracks in one chart: colour and shape say the engine, filling and dashes the track."""

    def __init__(self, store: Store, drawn: Sequence[Row]) -> None:
        present = {row["engine"] for row in drawn}
        chosen = looks(labels(store))
        shown = [(label, chosen[name]) for name, label in labels(store).items() if label in present]
        self.engines = [label for label, _ in shown]
        self.colours = [look.colour for _, look in shown]
        self.paths = [look.path for _, look in shown]
        order = {track: place for place, track in enumerate(TRACKS)}
        self.tracks = sorted({row["track"] for row in drawn}, key=lambda track: (order.get(track, len(order)), track))

    def colour(self) -> Channel:
        """Colour of the engine, of what is filled and of lines."""
        return channel("engine:N", title=None, scale={"domain": self.engines, "range": self.colours})

    def dash(self) -> Any:
        """Dashes of the track: whole lines for tuned."""
        dashes = [[1, 0] if track != "default" else [4, 3] for track in self.tracks]
        # A legend of the many settings of a sweep would be longer than the chart; hovering names them.
        legend = {"values": [track for track in self.tracks if track in TRACKS] or self.tracks[:2]}
        return channel("track:N", title=None, legend=legend, scale={"domain": self.tracks, "range": dashes})

    def tooltip(self) -> list[Any]:
        """What hovering shows."""
        return [
            channel(f"{key}:Q", title=title, format=".3~g") if key in NUMBERS else channel(f"{key}:N", title=title)
            for key, title in HOVER.items()
            if key != "dt"
        ]

    def _filling(self, track: str) -> float:
        """Open for the defaults, half filled for what is neither of the two tracks where 'tuned' is drawn too."""
        return OPEN if track == "default" else HALF if track != "tuned" and "tuned" in self.tracks else 1

    def channels(self, tooltip: Sequence[Channel] = ()) -> Row:
        """All channels of a point. Args: tooltip: what hovering shows, if not what it shows of a trial."""
        filled = [self._filling(track) for track in self.tracks]
        return {
            "color": self.colour(),
            "stroke": self.colour(),
            "shape": channel("engine:N", title=None, scale={"domain": self.engines, "range": self.paths}),
            "fillOpacity": channel("track:O", title=None, scale={"type": "ordinal", "domain": self.tracks, "range": filled}),
            "tooltip": list(tooltip) or self.tooltip(),
        }


def logarithmic(field: str, title: str, values: Row) -> Channel:
    """A logarithmic axis with room for marks at its ends."""
    return channel(f"{field}:Q", title=title, scale={"type": "log", "nice": False, "padding": 14}, axis=values)


def lane_texts(rows: Sequence[Row], field: str, x: Any, style: Marks, tooltip: Any, **words: Any) -> list[Any]:
    """What became of trials without a point, above the frame at each row's lane; no layer where there is none."""
    if not rows:
        return []
    text = chart(rows).marked("text", fontSize=13, fontWeight=700, **words)
    lane = channel("lane:Q", scale=None, axis=None)
    return [text.encode(x=x, y=lane, text=channel(f"{field}:N"), color=style.colour(), tooltip=tooltip)]


def short(label: str) -> str:
    """The label of an engine where room is short: of a name that the legend marks as ours, what the narrow legend keeps."""
    return OURS.sub(r"\1", label)


def lane_names(rows: Sequence[Row]) -> list[Any]:
    """The label of each lane, left of the frame."""
    if not rows:
        return []
    told = [row | {"label": short(row["label"])} for row in rows]
    label = chart(told).marked("text", align="right", dx=-8, fontSize=10, color="#8a93a0", limit=140)
    return [label.encode(x=fixed(0), y=channel("lane:Q", scale=None, axis=None), text="label:N")]


def finished(layers: Sequence[Any], height: int) -> Row:
    """One specification, as wide as the page lets it."""
    spec = layered(layers, width="container", height=height)
    spec["config"] = {
        "legend": {
            "orient": "top",
            "direction": "horizontal",
            "symbolSize": 90,
            "labelLimit": 240,
            "columnPadding": 12,
            "layout": {"top": {"direction": "vertical", "anchor": "start", "margin": 4, "bounds": "full"}},
        }
    }
    spec["padding"] = {"left": 5, "right": 14, "top": 5, "bottom": 5}
    spec["autosize"] = {"type": "fit-x", "contains": "padding"}
    return spec


def ticks(drawn: Iterable[Row], field: str) -> Row:
    """Ticks at the time steps themselves while they are few; otherwise at round numbers."""
    steps = [row[field] for row in drawn if row[field]]
    return at_values(steps) if field == "dt" else decades(steps)


def at_values(numbers: Iterable[float]) -> Row:
    """Ticks where values were tried, while these are few; otherwise at round numbers."""
    values = sorted(set(numbers))
    return (
        {"format": ".3~g", "values": values, "labelOverlap": "greedy", "labelSeparation": 5}
        if len(values) <= 10
        else decades(values)
    )


def decades(numbers: Iterable[float | None]) -> Row:
    """Ticks at powers of ten, with 2 and 5 between them where there are few. Of less than a decade all digits, fewer where a
    power of ten lies within, whose label needs its room, and round numbers where fewer than three of these would be seen."""
    nonzero = [value for value in numbers if value]
    if not nonzero:
        return {"values": []}
    least, most = min(nonzero), max(nonzero)
    low, high = math.floor(math.log10(least)), math.ceil(math.log10(most))
    every = max(1, math.ceil((high - low) / 8))
    within = most < 10 * least
    digits = (1, 2, 3, 5, 7) if high - low > 1 else tuple(range(1, 10))
    steps = digits if within else (1, 2, 5) if high - low <= 2 else (1,)
    values = [digit * 10.0**power for power in range(low, high + 1, every) for digit in steps]
    if within and sum(least <= value <= most for value in values) < 3:
        values = _round_numbers(least, most) or values
    return {"values": values, "labelExpr": words(values), "labelOverlap": "greedy", "labelSeparation": 5}


def _round_numbers(low: float, high: float) -> list[float]:
    """Three or more multiples of 1, 2 or 5 times a power of ten between two numbers; none where labels could not tell them."""
    for power in range(math.floor(math.log10(high)), math.floor(math.log10(high)) - 4, -1):
        for digit in (5, 2, 1):
            step = digit * 10.0**power
            values = [float(f"{k * step:.12g}") for k in range(math.ceil(low / step), math.floor(high / step) + 1)]
            if len(values) >= 3:
                return values if len({amount(value) for value in values}) == len(values) else []
    return []


def words(values: Sequence[float]) -> str:
    """An expression that writes each of these ticks as the tables do, powers included: '10⁻⁶', '0.02'."""
    return f"{json.dumps([amount(value) for value in values], ensure_ascii=False)}[indexof({json.dumps(values)}, datum.value)]"
