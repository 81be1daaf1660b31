"""How many axes, and pairs of case and error, each engine leads at equal sub-step and at equal time, with ours and without."""

from collections.abc import Mapping, Sequence
from dataclasses import asdict, fields
from typing import Any

from plumbline.harness.findings.leads import Lead, axis_leads, pair_leads, reaches
from plumbline.harness.findings.limits_found import searches
from plumbline.harness.findings.priced import priced
from plumbline.harness.store.store import Store

COLUMNS = tuple(field.name for field in fields(Lead))


def rows(store: Store) -> list[dict[str, Any]]:
    """Flat rows with COLUMNS."""
    prices = priced(store)
    return [asdict(lead) for lead in (*axis_leads(reaches(searches(store))), *pair_leads(prices.prices, prices.points))]


BRIEF = ("of", "at", "condition", "with ours", "engine", "alone", "with others", "asked")


def brief(row: Mapping[str, Any]) -> list[object]:
    """A flat row in short words under BRIEF."""
    return [
        row["what"],
        row["at"],
        row["condition"],
        "yes" if row["ours"] else "no",
        row["engine"],
        row["alone"],
        row["shared"],
        row["of"],
    ]


def sentences(rows: Sequence[Mapping[str, Any]]) -> list[str]:
    """Condition by condition, who leads how often."""
    lines = []
    for key in dict.fromkeys((row["what"], row["at"], row["condition"], row["ours"]) for row in rows):
        mine = [row for row in rows if (row["what"], row["at"], row["condition"], row["ours"]) == key]
        what, at, condition, ours = key
        counts = ", ".join(
            f"{row['engine']} {row['alone']} alone and {row['shared']} with others of {row['of']}"
            for row in sorted(mine, key=lambda row: -row["alone"] - row["shared"])
        )
        lines.append(f"{what} led at {at}{f' ({condition})' if condition else ''}{'' if ours else ', without ours'}: {counts}.")
    return lines
