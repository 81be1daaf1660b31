"""The words of Vega-Lite that charts are written in: layers of marks over rows, each of which encodes fields by channels.

A chart is plain data from its first word on, since a report draws hundreds; tests hold every kind against the schema.
"""

import hashlib
import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

SCHEMA = "https://vega.github.io/schema/vega-lite/v6.4.1.json"
KINDS = {"N": "nominal", "O": "ordinal", "Q": "quantitative", "T": "temporal"}
SECOND = {"x2", "y2"}
"""Channels for the other end of a mark: they have the kind of the first."""

Row = dict[str, Any]
"""What a chart draws a mark of: values by the names of fields."""
Channel = Mapping[str, Any]
"""What a channel says: a field with its kind, scale, axis, legend or title, or a value for all marks."""


def channel(column: str, /, **more: Any) -> Channel:
    """A channel for a field and its kind, 'error:Q', with what else is given for it. Raises: ValueError, without a kind."""
    name, _, kind = column.rpartition(":")
    if not name or kind not in KINDS:
        raise ValueError(f"channel {column!r}: expected a field and its kind, one of {', '.join(KINDS)}, as in 'error:Q'")
    return {"field": name, "type": KINDS[kind], **more}


def hovering(*fields: str | tuple[str, ...]) -> list[Channel]:
    """What hovering over a mark shows: fields with their kinds, each alone or with its title and, behind that, its format."""
    listed = [(column,) if isinstance(column, str) else column for column in fields]
    more = [{key: words for key, words in zip(("title", "format"), column[1:], strict=False) if words} for column in listed]
    return [channel(column[0], **about) for column, about in zip(listed, more, strict=True)]


def fixed(same: float | str) -> Channel:
    """One place for all marks: pixels, or 'width' and 'height' of the frame."""
    return {"value": same}


@dataclass(frozen=True, slots=True)
class Chart:
    """Marks of one kind over rows that travel inside the specification. Terms: mark: with its type; encoding: by channel."""

    rows: Sequence[Mapping[str, Any]]
    mark: Mapping[str, Any] = field(default_factory=dict)
    encoding: Mapping[str, Any] = field(default_factory=dict)

    def marked(self, kind: str, **look: Any) -> "Chart":
        """The same rows as marks of a kind: point, line, rule, area, text, tick."""
        return Chart(self.rows, {"type": kind, **look}, self.encoding)

    def encode(self, **channels: str | Channel | Sequence[Channel]) -> "Chart":
        """The same marks where and in which colours rows say; a channel may be its field and kind alone."""
        encoding: dict[str, Any] = {name: channel(what) if isinstance(what, str) else what for name, what in channels.items()}
        for name in SECOND & encoding.keys():
            encoding[name] = {key: part for key, part in encoding[name].items() if key != "type"}
        return Chart(self.rows, self.mark, encoding)


def chart(rows: Sequence[Mapping[str, Any]]) -> Chart:
    """A chart of rows, whose marks are not chosen yet."""
    return Chart(rows)


def layered(charts: Sequence[Chart], **more: Any) -> dict[str, Any]:
    """One specification of charts over each other; equal rows stand in its `datasets` once, by a digest."""
    tables: dict[str, list[Mapping[str, Any]]] = {}
    layers: list[dict[str, Any]] = []
    for one in charts:
        rows = json.dumps(one.rows, sort_keys=True)
        name = f"data-{hashlib.sha256(rows.encode()).hexdigest()[:32]}"
        tables[name] = list(one.rows)
        layers.append({"data": {"name": name}, "mark": one.mark, "encoding": one.encoding})
    whole: dict[str, Any] = {"data": layers[0].pop("data")} if len(layers) == 1 else {}
    return {"$schema": SCHEMA, "layer": layers, "datasets": tables} | whole | more
