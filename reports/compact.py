"""What a chart draws, in few bytes: of each of its tables the fields that it shows, column by column, repeated words once."""

import json
import math
import re
from collections.abc import Collection, Iterable, Mapping, Sequence
from typing import Any

from markupsafe import Markup

__all__ = ["columns", "shown_rows", "shown_spec"]

SCRIPTED = frozenset(("engine", "track", "trial"))
"""Fields that the page's script reads beside those that a chart names: what a switch leaves out, where a click leads."""
DATUM = re.compile(r"datum\.(\w+)|datum\[\\?['\"](\w+)")
DIGITS = 6
"""Of a number on a page: a picture shows three or four, a hover three; the exact ones stand in the tables of the store."""


def _named(part: Any) -> Iterable[str]:
    """The fields that a part of a specification names, in channels and in expressions."""
    if isinstance(part, Mapping):
        for key, value in part.items():
            if key == "field" and isinstance(value, str):
                yield value
            else:
                yield from _named(value)
    elif isinstance(part, list):
        for value in part:
            yield from _named(value)
    elif isinstance(part, str):
        yield from (a or b for a, b in DATUM.findall(part))


def shown_rows(spec: Mapping[str, Any], always: Collection[str] = ()) -> dict[str, list[dict[str, Any]]]:
    """The tables of a specification by name, each with the fields alone that a layer on it names, and those in `always`.

    A table that a layer transforms keeps all its fields.
    """
    tables: Mapping[str, Sequence[dict[str, Any]]] = spec.get("datasets", {})
    named: dict[str, set[str] | None] = {}
    for layer in spec.get("layer", [spec]):
        table = layer.get("data", {}).get("name", "")
        known = named.setdefault(table, set(always))
        if "transform" in layer or known is None:
            named[table] = None
        else:
            known |= set(_named(layer.get("encoding", {}))) | set(_named(layer.get("mark", {})))
    return {name: _only(rows, named.get(name)) for name, rows in tables.items()}


def _only(rows: Sequence[dict[str, Any]], fields: Collection[str] | None) -> list[dict[str, Any]]:
    return list(rows) if fields is None else [{key: row[key] for key in row if key in fields} for row in rows]


def _rounded(value: Any) -> Any:
    return float(f"{value:.{DIGITS}g}") if isinstance(value, float) and math.isfinite(value) else value


def columns(rows: Sequence[Mapping[str, Any]]) -> Any:
    """A table as {"count": n, "columns": {field: values}}; values that repeat words as {"words": [...], "of": [places]}.

    A table whose rows differ in their fields stays as it is: nothing stands for a field that is not there.
    """
    fields = set(rows[0]) if rows else set()
    if any(set(row) != fields for row in rows):
        return list(rows)
    packed: dict[str, Any] = {}
    for field in sorted(fields):
        values = [_rounded(row[field]) for row in rows]
        packed[field] = values
        if len(values) > 1 and all(isinstance(value, str) for value in values):
            place = {word: k for k, word in enumerate(dict.fromkeys(values))}
            if 2 * len(place) <= len(values):
                packed[field] = {"words": list(place), "of": [place[value] for value in values]}
    return {"count": len(rows), "columns": packed}


def shown_spec(spec: Mapping[str, Any]) -> Markup:
    """A specification as a page carries it, its tables by columns: JSON in which nothing can end the element that holds it."""
    tables = {name: columns(rows) for name, rows in shown_rows(spec, SCRIPTED).items()}
    text = json.dumps(dict(spec) | {"datasets": tables}, separators=(",", ":"), sort_keys=True, ensure_ascii=False)
    for sign in "<>&":
        text = text.replace(sign, f"\\u{ord(sign):04x}")
    return Markup(text)
