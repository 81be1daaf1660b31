"""The first page: which engine and how surely, what breaks, what changed; then the verdicts, and where all comes from."""

from collections.abc import Mapping
from dataclasses import replace

from plumbline.harness.findings.emulations import whose
from plumbline.harness.findings.selection.rank import DRAWS
from plumbline.harness.store.store import Store
from plumbline.reports.charts.errors import across_cases
from plumbline.reports.charts.work_precision import error_against_speed
from plumbline.reports.html.template import fill
from plumbline.reports.page import Page, Rendered
from plumbline.reports.standalone.what_changed import history_news
from plumbline.reports.tables.engine_summary import Glance, glances
from plumbline.reports.tables.limit_table import limits_met
from plumbline.reports.tables.own_scenes import by_case
from plumbline.reports.tables.published import published_table
from plumbline.reports.tables.selection import answer, needs
from plumbline.reports.tables.summary import sentences
from plumbline.reports.tables.trial_results import answers, at_own_step
from plumbline.reports.tables.verdicts import cells_by_family, failing, tracks_of, verdicts
from plumbline.reports.words.catalogue import cases, compared_tracks, engines, named_tracks
from plumbline.reports.words.status import STATUSES, VERDICTS

SHOWN = 6
"""Causes and limits that stand open; the next causes fold, up to `LISTED`, and the pages of the engines have all."""
LISTED = 24
MANY = 40
"""Cases from which on the matrix scrolls in a frame of its own."""

ERRORS = (
    "Each mark is the median headline error of an engine on a case, at the case's own time step, divided by the case's scale. "
    "Filled is tuned, open the vendor's defaults{beside}. "
    "Exact answers stand on the left edge, trials without a number at the right as outcomes."
)
BESIDE = ", half filled a setting that the study names beside the two"
COSTS = "Right is faster; 1 is real time on one core."
PACED = "At 1 a simulated second takes a second of CPU time. A speed says little without its error: read both charts together."


def render(store: Store) -> Mapping[str, Rendered]:
    """The page and its charts."""
    rows = answers(store)
    # What a search went on to is no track: it stands on the pages of the cases.
    rows = at_own_step(store, rows[rows["track"].isin(named_tracks(store))])
    scales = {name: case["scale"] or 1.0 for name, case in cases(store).items()}
    scaled = rows.assign(error=[error / scales[name] for error, name in zip(rows["error"], rows["case"], strict=True)])
    title = "Error as a share of the case's scale"
    how = ERRORS.format(beside=BESIDE if len(named_tracks(store)) > len(compared_tracks(store)) > 0 else "")
    errors = across_cases(store, scaled, "error", "overview-error", title, "Left is more accurate.", how)
    paces = across_cases(store, scaled, "pace", "overview-cost", "Speed in times real time", COSTS, PACED)
    figures = [errors] if errors is not None else []
    figures += [replace(paces, after=errors)] if paces is not None else []
    cells = verdicts(store)
    judged = {case for case, _, _ in cells}
    sides: dict[str, dict[str, Glance]] = {}
    for glance in glances(store):
        sides.setdefault(glance.engine, {})[glance.track] = glance
    purposes = needs(store)
    picture = error_against_speed(store) if purposes else None
    page = fill(
        "index.html",
        store,
        title=store.study.get("title") or store.study.get("name", "Report"),
        described=bool(store.catalogue),
        needs=purposes,
        draws=DRAWS,
        noisy=answer(store).noisy,
        sentences=sentences(store),
        picture=picture,
        ranked=[name for name in engines(store) if any(name in need.standings for need in purposes)],
        failures=failing(store),
        limits=limits_met(store),
        bounded=bool(judged - by_case(store).keys()),
        apart=[
            (*key, cell)
            for key, cell in cells.items()
            if key[0] in by_case(store) and cell.own.rank >= VERDICTS["converges elsewhere"].rank
        ],
        many=MANY,
        shown=SHOWN,
        listed=LISTED,
        news=history_news(store),
        published=published_table(store),
        sides=sides,
        families=cells_by_family(store),
        cells=cells,
        meanings=(VERDICTS if by_case(store) else {}) | (STATUSES if len(by_case(store)) < len(judged) else {}),
        laws={(case, name, track): whose(store.catalogue, name, case, track) for case, name, track in cells},
        tracks=compared_tracks(store),
        columns={name: tracks for name in engines(store) if (tracks := tracks_of(store, name))},
        figures=figures,
        machine=store.machine,
        trials=len(store.trials),
    )
    return {"index.html": page} | {figure.path: figure for figure in (picture, *figures) if figure is not None}


PAGE = Page(name="index", title="Overview", order=0, render=render)
