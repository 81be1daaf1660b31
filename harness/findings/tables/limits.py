"""How far each engine goes along each axis before it breaks, by what, and what a step costs there."""

from collections.abc import Mapping, Sequence
from dataclasses import asdict, fields
from typing import Any

from plumbline.harness.findings.leads import REFERENCE
from plumbline.harness.findings.limits_found import Search, amount, searches
from plumbline.harness.store.store import Store

COLUMNS = tuple(field.name for field in fields(Search) if field.name not in ("beside", "remedy", "remedied", "holds"))


def rows(store: Store) -> list[dict[str, Any]]:
    """Flat rows with COLUMNS."""
    plain = [search for search in searches(store) if not search.remedied]
    return [
        {name: value for name, value in asdict(search).items() if name in COLUMNS}
        | {"signs": search.signs.text, "noticed": "; ".join(map(str, search.noticed))}
        for search in plain
    ]


BRIEF = ("case", "engine", "setting", "axis", "held", "broke", "share held there", "by", "CPU s per s", "ms a step", "values")


def brief(row: Mapping[str, Any]) -> list[object]:
    """A flat row in short words under BRIEF."""
    silent = row["verdict"] in ("stopped", "unsupported", "unavailable")
    return [
        f"{row['case']} {row['where']}".strip(),
        row["engine"],
        _setting(row),
        f"{row['axis']} {row['easy']:.4g}..{row['extreme']:.4g}{'' if row['unit'] == '1' else ' ' + row['unit']}",
        amount(row["held"], "none"),
        row["verdict"] if silent else amount(row["broke"], "none"),
        "" if row["share"] is None else f"{row['share']:.2f}",
        f"{row['signs'] or row['reason'][:60]}{'; its own start holds' if row['own_holds'] else ''}",
        amount(row["cost"], ""),
        "" if row["step_cost"] is None else f"{1e3 * row['step_cost']:.3g}",
        row["values"],
    ]


def _setting(row: Mapping[str, Any]) -> str:
    return row["track"] if not row["parts"] else f"{row['track']}, dt/{row['parts']}"


def sentences(rows: Sequence[Mapping[str, Any]]) -> list[str]:
    """Axis by axis and sub-step by sub-step, who goes farthest of the engines that people can deploy, the ruler beside them.

    Leads are counted by the table `farthest`.
    """
    axes: dict[tuple[Any, ...], list[Mapping[str, Any]]] = {}
    for row in rows:
        if row["verdict"] not in ("unsupported", "unavailable"):
            # Tracks as they come are not compared with what is held to a sub-step.
            axes.setdefault((row["experiment"], row["case"], row["where"], row["axis"], row["parts"]), []).append(row)
    lines = []
    for (_, case, where, axis, parts), searched in axes.items():
        ranked = [row for row in searched if row["engine"] != REFERENCE]
        mine = max((row for row in searched if row["engine"] == REFERENCE), key=lambda row: row["reach"], default=None)
        farthest = max((row["reach"] for row in ranked), default=0.0)
        best = [row for row in ranked if row["reach"] >= farthest - 1e-9 and row["held"] is not None]
        names = ", ".join(f"{row['engine']} ({_setting(row)})" for row in best) or "nobody"
        value = best[0]["held"] if best else None
        beside = "" if mine is None else f"; {REFERENCE}, the yardstick, {amount(mine['held'], 'no value')}"
        name = f"{case} {where}".strip() + (f", sub-step dt/{parts}" if parts else ", as tracks come")
        lines.append(f"{name}: {axis} up to {amount(value, 'no value')}: {names}{beside}.")
    return lines
