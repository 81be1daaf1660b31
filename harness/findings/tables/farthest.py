"""How far each engine goes along each axis at equal sub-steps, and for equal time; see `harness.findings.standing`."""

from collections.abc import Sequence

from plumbline.harness.findings.columns import Column, Table, at, milli, plain, scene
from plumbline.harness.findings.limits_found import amount, searches
from plumbline.harness.findings.standing import Reach, reaches


def _sentences(rows: Sequence[Reach]) -> list[str]:
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


TABLE = Table(
    holds="experiment=search.experiment case=search.case where=search.where axis=search.axis unit=search.unit "
    "engine=search.engine at condition parts held=hold.value reach further setting=search.setting substep=search.substep "
    "cost=hold.cost leads leads_without",
    objects=lambda store: reaches(searches(store)),
    shown=(
        Column("case", lambda row: scene(row.search)),
        *plain("engine=search.engine", "at"),
        Column("condition", lambda row: f"{1e3 * row.condition:.3g} ms" + ("" if row.parts else " a step")),
        Column("axis", "search.axis"),
        Column("held", lambda row: amount(at(row, "hold.value"), "none")),
        Column("setting", "search.setting"),
        Column("ms a step", lambda row: milli(at(row, "hold.cost")), ".3g"),
        Column("leads", lambda row: "leads" if row.leads else ""),
        Column("without ours", lambda row: "leads" if row.leads_without else ""),
    ),
    sentences=_sentences,
)
