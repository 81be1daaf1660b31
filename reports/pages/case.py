"""A page for each case: the question, its truth and checks, error against time step and cost, and every trial.

Scenes of one's own, whose truth engines have to agree on, have a page of their own kind (`reports.pages.scene`).
"""

import shlex
from collections.abc import Collection, Iterator, Sequence

import pandas as pd

from plumbline.harness.findings.emulations import whose
from plumbline.harness.findings.tables.orders import ObservedOrder, convergences
from plumbline.harness.store.rows import records
from plumbline.harness.store.store import Store
from plumbline.reports.charts.errors import error_by_step
from plumbline.reports.charts.figure import Figure
from plumbline.reports.charts.work_precision import work_precision
from plumbline.reports.html.template import fill
from plumbline.reports.page import Page, Rendered
from plumbline.reports.pictures.case_pictures import sight, thumbnails
from plumbline.reports.recordings.layout import file_name
from plumbline.reports.tables.engine_summary import leads
from plumbline.reports.tables.own_scenes import by_case
from plumbline.reports.tables.price_list import price_list, scenes
from plumbline.reports.tables.trial_results import answers, as_csv, in_order, is_file, listed, measured_of, metrics_of, trial
from plumbline.reports.tables.verdicts import verdicts
from plumbline.reports.words.altered_parameters import departures
from plumbline.reports.words.catalogue import FAMILIES, case_file, cases, engines, tracks
from plumbline.reports.words.emulated_features import laws_of_case
from plumbline.reports.words.known_findings import disputed, of_case, told
from plumbline.reports.words.status import outcome
from plumbline.reports.words.text import slug


def render(store: Store) -> Iterator[tuple[str, Rendered]]:
    """For each case its page, its charts and its trials as CSV; first the charts that rest on little."""
    known = cases(store)
    sides = [(engine, track) for engine in engines(store) for track in tracks(store)]
    asked, names = set(store.asked["trial"]), [name for name in known if name not in by_case(store)]
    answered = answers(store, store.trials)
    rows = {name: in_order(answered[answered["case"] == name], sides) for name in names}
    steps: dict[str, Figure] = {}
    for name in names:
        if (chart := _by_step(store, name, rows[name], asked)) is not None:
            steps[name] = chart
            yield chart.path, chart
    cells, ladders = verdicts(store), convergences(store)
    prices = price_list(store) if scenes(store) else []
    for index, name in enumerate(names):
        case, mine = known[name], rows[name]
        measured = measured_of(store, name)
        plain = slug(name)
        priced = [work_precision(store, scene) for scene in scenes(store) if scene.case == name]
        lines = [line for line in prices if line.case == name]
        shown = listed(mine, {entry.trial for line in lines for entry in line.entries.values()})
        recording = store.folder / "recordings" / file_name(name)
        yield from ((figure.path, figure) for figure in priced)
        yield f"trials/{plain}.csv", as_csv(mine, measured)
        page = fill(
            "case.html",
            store,
            title=case["title"],
            case=case,
            family=FAMILIES.get(case["family"], case["family"]),
            before=known[names[index - 1]] if index else None,
            after=known[names[index + 1]] if index + 1 < len(names) else None,
            figures=[*([steps[name]] if name in steps else []), *priced],
            seen=sight(store, name),
            thumbs=thumbnails(store),
            prices=lines,
            several=len({line.title for line in lines}) > 1,
            known_findings=of_case(store, name),
            laws=laws_of_case(store, case),
            leads=[lead for (of, _), lead in leads(store).items() if of == name],
            orders=(fitted := orders([row for row in ladders if row.case == name], sides)),
            broken=[
                (row.finding, whose(store.catalogue, row.engine, name, row.track), disputed(store, row.engine, name))
                for row in fitted
                if row.finding
            ],
            disputes=told(store, name),
            verdicts={(engine, track): cells[name, engine, track] for engine, track in sides if (name, engine, track) in cells},
            metrics=list(dict.fromkeys([case["headline"], *metrics_of(measured)])) if measured else [],
            trials=[trial(store, row, measured.get(row["trial"], {})) for row in records(shown)],
            departures=departures(shown),
            trials_in_all=len(mine),
            shown=outcome,
            csv=f"trials/{plain}.csv",
            recording=f"../recordings/{file_name(name)}" if is_file(recording) else None,
            view=f"plumbline view {shlex.quote(str(store.folder))} {shlex.quote(name)}",
        )
        yield case_file(name), page


def _by_step(store: Store, name: str, rows: pd.DataFrame, asked: Collection[str]) -> Figure | None:
    """The chart of a case's errors; asked: the trials that put it as it is."""
    unit = next((str(unit) for unit in rows["unit"].dropna()), "1")
    return error_by_step(store, rows[rows["trial"].isin(asked)], f"case-{slug(name)}", cases(store)[name]["headline"], unit)


def orders(ladders: Sequence[ObservedOrder], sides: list[tuple[str, str]]) -> list[ObservedOrder]:
    """The ladders that have a fit or need none, engine by engine and track by track."""
    listed = [row for row in ladders if row.fit is not None or row.verdict == "exact"]
    return sorted(listed, key=lambda row: sides.index((row.engine, row.track)))


PAGE = Page(name="case", title="Cases", order=50, render=render, listed=False)
