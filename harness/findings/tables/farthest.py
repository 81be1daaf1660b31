"""How far each engine goes along each axis at equal sub-steps, and for equal time; worked out in `harness.findings.leads`."""

from collections.abc import Mapping, Sequence
from dataclasses import asdict, fields
from typing import Any

from plumbline.harness.findings.leads import Reach, reaches
from plumbline.harness.findings.limits_found import amount, searches
from plumbline.harness.store.store import Store

COLUMNS = tuple(field.name for field in fields(Reach))


def rows(store: Store) -> list[dict[str, Any]]:
    """Flat rows with COLUMNS."""
    return [asdict(reach) for reach in reaches(searches(store))]


BRIEF = ("case", "engine", "at", "condition", "axis", "held", "setting", "ms a step", "leads", "without ours")


def brief(row: Mapping[str, Any]) -> list[object]:
    """A flat row in short words under BRIEF."""
    return [
        f"{row['case']} {row['where']}".strip(),
        row["engine"],
        row["at"],
        f"{1e3 * row['condition']:.3g} ms" + ("" if row["parts"] else " a step"),
        row["axis"],
        amount(row["held"], "none"),
        row["setting"],
        "" if row["cost"] is None else f"{1e3 * row['cost']:.3g}",
        "leads" if row["leads"] else "",
        "leads" if row["leads_without"] else "",
    ]


def sentences(rows: Sequence[Mapping[str, Any]]) -> list[str]:
    """What is equal, and how axes are told apart."""
    if not rows:
        return []
    return [
        "At equal sub-step every engine takes the time step of a case in as many parts; one without sub-steps takes shorter "
        "steps.",
        "At equal time the farthest counts of all that an engine held for at most so much CPU time per time step of the case, "
        "with default settings as with tuned ones at any sub-step; nothing is interpolated, and costs are rough.",
        "Engines whose brackets meet lead together.",
    ]
