"""The legend of a still chart, as a live one has it: engines by shape and colour, then tracks, in as few lines as fit."""

from collections.abc import Mapping, Sequence
from typing import Any

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
