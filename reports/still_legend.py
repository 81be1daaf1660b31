"""The legend of a still chart, as a live one has it: engines by shape and colour, then tracks, in as few lines as there is room."""

import math
from typing import Any

__all__ = ["with_legend"]

SIGN, LETTER, BETWEEN = 24.0, 7.0, 12.0
"""Widths [px] of a symbol with its room, of a letter of the legend at most, and between two entries."""
INK = "#1d232c"


def with_legend(spec: dict[str, Any], width: int) -> dict[str, Any]:
    """The chart with its legends above the frame, at the left; hollow and filled signs tell tracks as they do on the page."""
    encodings = [layer.get("encoding", {}) for layer in spec.get("layer", [spec])]
    for encoding in encodings:
        if "strokeDash" in encoding and any("fillOpacity" in other for other in encodings):
            encoding["strokeDash"]["legend"] = None
        for channel in ("color", "stroke", "shape"):
            if channel in encoding and "scale" in encoding[channel]:
                encoding[channel] |= _laid(encoding[channel]["scale"].get("domain", []), width)
        if "fillOpacity" in encoding:
            _tracks(encoding["fillOpacity"], width)
    return spec


def _tracks(channel: dict[str, Any], width: int) -> None:
    """Two tracks are named; of the many settings of a sweep a legend would be longer than the chart."""
    domain = channel.get("scale", {}).get("domain", [])
    if len(domain) > 2:
        channel["legend"] = None
        return
    channel |= _laid(domain, width)
    channel["legend"] |= {"symbolType": "circle", "symbolFillColor": INK, "symbolStrokeColor": INK}


def _laid(domain: list[str], width: int) -> dict[str, Any]:
    """How many entries stand in a line: all where they fit, else as many as do, evenly."""
    widths = [SIGN + LETTER * len(str(name)) + BETWEEN for name in domain] or [1.0]
    columns = len(widths)
    while columns > 1 and columns * max(widths) > width and sum(widths) > width:
        columns = math.ceil(columns / 2)
    return {"legend": {"columns": columns, "title": None}}
