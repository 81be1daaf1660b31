"""The legend of a still chart reads as that of a live one."""

import re
from typing import Any

import pytest

from plumbline.reports.charts.figure import BESIDE, Figure

NAMES = ["Plumbline reference (ours)", "MuJoCo", "Bullet", "DART"]
TRACKS = ["default", "tuned"]


def chart(lane: int) -> Figure:
    engines: Any = {"field": "engine", "type": "nominal", "title": None, "scale": {"domain": NAMES, "range": ["#a00"] * 4}}
    tracks: Any = {"field": "track", "type": "nominal", "title": None, "scale": {"domain": TRACKS, "range": [[4, 3], [1, 0]]}}
    filling: Any = {"field": "track", "type": "ordinal", "title": None, "scale": {"domain": TRACKS, "range": [0.0001, 1]}}
    place: Any = {"x": {"field": "x", "type": "quantitative"}, "y": {"field": "x", "type": "quantitative"}}
    rows = [{"x": k, "engine": name, "track": TRACKS[k % 2]} for k, name in enumerate(NAMES)]
    lines = {"mark": "line", "encoding": place | {"color": engines, "strokeDash": tracks}}
    points = {"mark": {"type": "point", "filled": True}, "encoding": place | {"color": engines, "fillOpacity": filling}}
    above = {
        "data": {"name": "lanes"},
        "mark": {"type": "text", "text": "!"},
        "encoding": {"y": {"field": "lane", "type": "quantitative", "scale": None, "axis": None}},
    }
    spec = {
        "data": {"values": rows},
        "datasets": {"lanes": [{"lane": lane}]},
        "layer": [lines, points, above],
        "height": 200,
        "config": {"legend": {"orient": "top", "direction": "horizontal"}},
    }
    return Figure("name", "title", "caption", spec, [], [])


@pytest.mark.parametrize("width", [320, 640])
def test_every_engine_and_track_is_named_once_within_the_picture(width: int) -> None:
    drawn = chart(-40).drawn("svg", width).decode()
    legend = re.findall(r">([^<>]+)</text>", drawn)
    assert [text for text in legend if text in NAMES] == NAMES
    assert [text for text in legend if text in TRACKS] == TRACKS
    # The frame is as wide as is asked, the axis stands beside it, and a legend that did not fit would widen the picture.
    assert float(re.findall(r'width="([0-9.]+)"', drawn)[0]) <= width + BESIDE


def test_the_legend_stands_above_the_lanes_of_outcomes() -> None:
    heights = [float(re.findall(r'height="([0-9.]+)"', chart(lane).drawn("svg").decode())[0]) for lane in (-10, -70)]
    assert heights[1] == pytest.approx(heights[0] + 60, abs=1)
