"""How far each engine goes along each axis before it breaks, by what, and what a step costs there."""

from collections.abc import Mapping, Sequence
from dataclasses import asdict, fields
from typing import Any

from harness.searches import Search, amount, searches
from harness.store import Store

__all__ = ["BRIEF", "COLUMNS", "brief", "rows", "sentences"]

COLUMNS = tuple(field.name for field in fields(Search) if field.name not in ("remedy", "remedied"))


def rows(store: Store) -> list[dict[str, Any]]:
    """Flat rows with COLUMNS."""
    return [{k: v for k, v in asdict(one).items() if k in COLUMNS} for one in searches(store) if not one.remedied]


BRIEF = ("case", "engine", "setting", "axis", "held", "broke", "share held there", "by", "CPU s per s", "values")


def brief(row: Mapping[str, Any]) -> list[object]:
    """A flat row in short words under BRIEF."""
    silent = row["verdict"] in ("stopped", "unsupported", "unavailable")
    return [
        f"{row['case']} {row['where']}".strip(),
        row["engine"],
        row["track"],
        f"{row['axis']} {row['easy']:.4g}..{row['extreme']:.4g}{'' if row['unit'] == '1' else ' ' + row['unit']}",
        amount(row["held"], "none"),
        row["verdict"] if silent else amount(row["broke"], "none"),
        "" if row["share"] is None else f"{row['share']:.2f}",
        row["signs"] or row["reason"][:60],
        amount(row["cost"], ""),
        row["values"],
    ]


def sentences(rows: Sequence[Mapping[str, Any]]) -> list[str]:
    """Axis by axis, who goes farthest; and how often that is the reference engine in some setting."""
    axes: dict[tuple[str, ...], list[Mapping[str, Any]]] = {}
    for row in rows:
        if row["verdict"] not in ("unsupported", "unavailable"):
            axes.setdefault((row["experiment"], row["case"], row["where"], row["axis"]), []).append(row)
    found, ours, asked = [], 0, 0
    for (_, case, where, axis), searched in axes.items():
        farthest = max(row["reach"] for row in searched)
        best = [f"{row['engine']} ({row['track']})" for row in searched if row["reach"] >= farthest - 1e-9]
        value = next(row["held"] for row in searched if row["reach"] >= farthest - 1e-9)
        name = f"{case} {where}".strip()
        found.append(f"{name}: {axis} up to {amount(value, 'no value')}: {', '.join(best)}.")
        mine = [row["reach"] for row in searched if row["engine"] == "reference"]
        if mine:
            asked, ours = asked + 1, ours + (max(mine) >= farthest - 1e-9)
    if asked:
        found.append(f"On {ours} of {asked} axes no other engine goes farther than the reference engine in its better setting.")
    return found
