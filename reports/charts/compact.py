"""What a chart draws, in few bytes: of each of its tables the fields that it shows, column by column, each word once."""

import json
import math
import re
from collections import Counter
from collections.abc import Collection, Iterable, Mapping, Sequence
from typing import Any, TypeGuard

from markupsafe import Markup

SCRIPTED = frozenset(("engine", "track", "trial"))
"""Fields that the page's script reads beside those that a chart names: what a switch leaves out, where a click leads."""
DATUM = re.compile(r"datum\.(\w+)|datum\[\\?['\"](\w+)")
DIGITS = 6
"""Of a number that a chart draws, which shows three or four; the exact ones stand in the tables of the store."""
HOVERED, HOVER_DIGITS = ".3~g", 3
"""How hovering writes nearly all numbers, and the digits that this leaves: of what is drawn nowhere a page has no more."""


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


def _hovered(spec: Mapping[str, Any]) -> dict[str, set[str]]:
    """By table the numbers that hovering alone shows, in three digits."""
    drawn: dict[str, set[str]] = {}
    told: dict[str, set[str]] = {}
    for layer in spec.get("layer", [spec]):
        table, encoding = layer.get("data", {}).get("name", ""), dict(layer.get("encoding", {}))
        tooltips = encoding.pop("tooltip", [])
        others = [entry for entry in tooltips if entry.get("format") != HOVERED]
        told.setdefault(table, set()).update(_named([entry for entry in tooltips if entry.get("format") == HOVERED]))
        drawn.setdefault(table, set()).update(_named([encoding, layer.get("mark", {}), layer.get("transform", []), others]))
    return {table: fields - drawn[table] for table, fields in told.items()}


def _rounded(value: Any, digits: int) -> Any:
    return float(f"{value:.{digits}g}") if isinstance(value, float) and math.isfinite(value) else value


def _worded(values: Sequence[Any]) -> TypeGuard[Sequence[str]]:
    return all(isinstance(value, str) for value in values)


def columns(rows: Sequence[Mapping[str, Any]], places: Mapping[str, int], hovered: Collection[str] = ()) -> Any:
    """A table as {"count": n, "columns": {field: values}}; values that are words as {"words": [places]}.

    A table whose rows differ in their fields stays as it is: nothing stands for a field that is not there.

    Args: places: of words in the list of the chart. hovered: fields of which three digits are enough.
    """
    fields = set(rows[0]) if rows else set()
    if any(set(row) != fields for row in rows):
        return list(rows)
    packed: dict[str, Any] = {}
    for field in sorted(fields):
        values = [row[field] for row in rows]
        digits = HOVER_DIGITS if field in hovered else DIGITS
        worded = _worded(values)
        packed[field] = {"words": [places[value] for value in values]} if worded else [_rounded(v, digits) for v in values]
    return {"count": len(rows), "columns": packed}


def new_words(spec: Mapping[str, Any], known: Collection[str] = ()) -> list[str]:
    """The words in the tables of a chart, each once, without those that a chart before it on the page has said.

    What stands in most rows comes first, so that most places are short.
    """
    counts: Counter[str] = Counter()
    for rows in shown_rows(spec, SCRIPTED).values():
        for field in rows[0] if rows else ():
            values = [row.get(field) for row in rows]
            if _worded(values):
                counts.update(values)
    said = frozenset(known)
    return [word for word, _ in counts.most_common() if word not in said]


def shown_spec(spec: Mapping[str, Any], known: Sequence[str] = (), after: str = "") -> Markup:
    """A specification as a page carries it, its tables by columns: JSON in which nothing can end the element that holds it.

    Args: known: the words that the figure `after`, which stands before it on the page, and those before that have said.
    """
    words = new_words(spec, known)
    places = {word: place for place, word in enumerate((*known, *words))}
    hovered = _hovered(spec)
    tables = {name: columns(rows, places, hovered.get(name, ())) for name, rows in shown_rows(spec, SCRIPTED).items()}
    whole = dict(spec) | {"datasets": tables, "words": words} | ({"after": after} if after else {})
    text = json.dumps(whole, separators=(",", ":"), sort_keys=True, ensure_ascii=False)
    for sign in "<>&":
        text = text.replace(sign, f"\\u{ord(sign):04x}")
    return Markup(text)
