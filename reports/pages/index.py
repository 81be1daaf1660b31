"""The first page: what was found, the verdict of every case on every engine, the engines, and where the numbers come from."""

from collections.abc import Mapping
from typing import TYPE_CHECKING

from harness.findings.emulations import whose
from reports.answers import answers, at_own_step
from reports.charts import across_cases
from reports.contents import cases, engines, families, named_tracks
from reports.glance import glances
from reports.own_scenes import by_case
from reports.page import Page
from reports.selection import needs
from reports.sights import thumbnails
from reports.status import STATUSES, VERDICTS
from reports.summary import sentences
from reports.template import fill
from reports.verdict import verdicts

if TYPE_CHECKING:
    from harness.store.store import Store

__all__ = ["PAGE"]

ERRORS = (
    "Each mark is the median headline error of an engine on a case, at the case's own time step, divided by the case's scale: "
    "left is better. Filled is tuned, open the vendor's defaults. "
    "Exact answers stand on the left edge, trials without a number at the right as outcomes."
)
COSTS = (
    "CPU time per simulated second at the same trials: left is cheaper; 1 is as fast as the clock on the wall. "
    "Read it together with the errors beside it: neither means anything alone."
)


def render(store: "Store") -> Mapping[str, str]:
    """The page and its two charts."""
    rows = at_own_step(store, answers(store))
    scales = {name: case["scale"] or 1.0 for name, case in cases(store).items()}
    scaled = rows.assign(error=[error / scales[name] for error, name in zip(rows["error"], rows["case"], strict=True)])
    figures = [
        figure
        for figure in (
            across_cases(store, scaled, "error", "overview-error", "Error as a share of the case's scale", ERRORS),
            across_cases(store, scaled, "cpu", "overview-cost", "CPU time per simulated second [s/s]", COSTS),
        )
        if figure is not None
    ]
    cells = verdicts(store)
    judged = {case for case, _, _ in cells}
    by_family = [(family, [case for case in listed if case["name"] in judged]) for family, listed in families(store)]
    page = fill(
        "index.html",
        store,
        title=store.study.get("title") or store.study.get("name", "Report"),
        needs=needs(store),
        sentences=sentences(store),
        glances=glances(store),
        thumbs=thumbnails(store),
        families=[(family, listed) for family, listed in by_family if listed],
        cells=cells,
        meanings=(VERDICTS if by_case(store) else {}) | (STATUSES if len(by_case(store)) < len(judged) else {}),
        laws={(case, name, track): whose(store.catalogue, name, case, track) for case, name, track in cells},
        tracks=named_tracks(store),
        figures=figures,
        findings={name: by_reason(engine["known_failures"]) for name, engine in engines(store).items()},
        machine=store.machine,
        trials=len(store.trials),
    )
    return {"index.html": page} | {figure.path: figure.svg for figure in figures}


def by_reason(known_failures: Mapping[str, str]) -> list[tuple[str, list[str]]]:
    """Checks that fail for one reason stand together under it."""
    checks: dict[str, list[str]] = {}
    for check, reason in known_failures.items():
        checks.setdefault(reason, []).append(check)
    return list(checks.items())


PAGE = Page(name="index", title="Overview", order=0, render=render)
