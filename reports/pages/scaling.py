"""The page on cost: what a step, a ray or a world costs, how that grows with the scene, and what the price buys."""

from collections.abc import Mapping, Sequence
from typing import Any

from plumbline.harness.findings.tables.scaling import TELLING, Cost, scaling_of
from plumbline.harness.statistics.order import FEWEST
from plumbline.harness.store.store import Store
from plumbline.reports.charts.step_costs import UNITS, growths, qualities, standings
from plumbline.reports.html.template import filled_page
from plumbline.reports.words.catalogue import engines, ours, titled


def concerns(store: Store) -> bool:
    """Only where some parameter was run at several values under the clock."""
    varied = store.asked.groupby("case")["parameters"].nunique().max() if len(store.asked) else 0
    # Most runs have one set of parameters a case: they need no look at their costs.
    return bool(varied >= FEWEST) and len(scaling_of(store).sweeps) > 0


def told(store: Store) -> Mapping[str, Any]:
    """What the template is told."""
    scaling = scaling_of(store)
    standing = standings(store, scaling)
    grown, bought = growths(store, scaling), qualities(store, scaling)
    return {
        "standing": standing,
        "growths": grown,
        "qualities": bought,
        "leads": leads(store, scaling.costs),
        "exponents": sorted(scaling.exponents, key=lambda fit: not fit.telling),
        "telling": TELLING,
        "costs": scaling.costs,
        "looked": [row for row in scaling.costs if row.to_plain is not None],
        "shared": [row for row in scaling.costs if row.efficiency is not None],
        "titles": {(row.case, row.where): titled(store, row.case, row.where) for row in scaling.costs},
        "units": UNITS,
        "own": next(iter(ours(store)), ""),
        "cores": store.machine.get("cores"),
    }


def leads(store: Store, costs: Sequence[Cost]) -> list[Cost]:
    """Each rival's fastest setting whose checks hold; its row names our fastest that is no worse."""
    known = engines(store)
    return [row for row in costs if row.best and not known[row.engine]["ours"]]


PAGE = filled_page("scaling", "Scaling", 20, told, tables=("scaling",), concerns=concerns)
