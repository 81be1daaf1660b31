"""A page for each scene of one's own: does it run, do engines agree, who is off and why, what accuracy costs, what to set."""

import shlex
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import PurePath
from typing import Any

from plumbline.harness.findings.agreement.costs import best_price, best_setting, cost_words
from plumbline.harness.findings.agreement.happened import happened_words, happenings
from plumbline.harness.findings.agreement.perturbed_starts import LAWS, balances, foreseeable_until, horizon_of, outlooks
from plumbline.harness.findings.agreement.setting_causes import cause_words, settings_turned
from plumbline.harness.findings.agreement.values import Agreement
from plumbline.harness.findings.agreement.words import cut_words, headline, listed, metres, side_words, unresolved_words
from plumbline.harness.findings.tables.agreement import TABLE as AGREEMENT
from plumbline.harness.findings.tables.agreement import side_verdicts
from plumbline.harness.findings.tables.fidelity import of_element
from plumbline.harness.store.imported_scenes import kept_by
from plumbline.harness.store.rows import records
from plumbline.harness.store.store import Store
from plumbline.reports.charts.errors import error_by_step
from plumbline.reports.charts.marks import looks
from plumbline.reports.charts.own_scenes import horizon_chart, parting_chart
from plumbline.reports.charts.work_precision import miniatures, work_precision
from plumbline.reports.html.template import fill
from plumbline.reports.page import Page, Rendered
from plumbline.reports.pictures import answer_pictures
from plumbline.reports.pictures.answer_pictures import AnswerPicture
from plumbline.reports.pictures.case_pictures import CaseSight, sight
from plumbline.reports.recordings.layout import file_name
from plumbline.reports.tables.csv import sheet
from plumbline.reports.tables.own_scenes import by_case, shown, summary
from plumbline.reports.tables.price_list import price_list, scenes
from plumbline.reports.tables.trial_results import answers, as_csv, in_order, is_file, measured_of, metrics_of, trial
from plumbline.reports.words.altered_parameters import departures
from plumbline.reports.words.catalogue import FAMILIES, case_file, cases, engines, titles, tracks
from plumbline.reports.words.emulated_features import laws_of_case
from plumbline.reports.words.status import FINITE, STATUSES, VERDICTS
from plumbline.reports.words.text import slug

CAPTION = (
    "Each point is one run; a line joins those of an engine that differ in the time step only. {} "
    "Runs without an answer stand above the frame as their outcome."
)
DOWN = "Down is more accurate, left is a finer step."
OF_ONE = "The grey line is how far the limit itself may be off."
OF_EACH = (
    "Each engine is measured from its own limit, since none is agreed; a run that is that limit errs by what it is known to."
)


def concerns(store: Store) -> bool:
    """Only where a scene has no truth but the engines' own agreement."""
    return bool(by_case(store))


def one_limit(agreements: Sequence[Agreement]) -> bool:
    """Are all engines measured from one limit, in each of a case's scenes?"""
    return all(agreement.agreed for agreement in agreements)


def render(store: Store) -> Mapping[str, Rendered]:
    """For each scene its page, its charts, its trials and its verdicts as CSV."""
    files: dict[str, Rendered] = {}
    rows, known = answers(store, store.trials), cases(store)
    prices = price_list(store) if scenes(store) else []
    sides = [(engine, track) for engine in engines(store) for track in tracks(store)]
    verdicts = side_verdicts(store)
    robots = {folder: (table, [of_element(row) for row in table["rows"]]) for folder, table in kept_by(store.folder)}
    for name, agreements in by_case(store).items():
        case, mine, plain = known[name], in_order(rows[rows["case"] == name], sides), slug(name)
        measured = measured_of(store, name)
        ladder = mine[
            mine["trial"].isin(
                [rung.trial for agreement in agreements for side in agreement.sides for rung in side.limit.rungs]
            )
        ]
        one = one_limit(agreements)
        how = CAPTION.format(OF_ONE if one else OF_EACH)
        by_step = error_by_step(
            store, ladder, f"case-{plain}", "distance from the limit", "of its size", DOWN, how=how, bounded=one
        )
        figures = [by_step, *(work_precision(store, scene) for scene in scenes(store) if scene.case == name)]
        figures += [
            drawn for agreement in agreements for drawn in (horizon_chart(store, agreement), parting_chart(store, agreement))
        ]
        charts = [figure for figure in figures if figure is not None]
        recording = store.folder / "recordings" / file_name(name)
        listed = [line for line in prices if line.case == name]
        files[f"trials/{plain}.csv"] = as_csv(mine, measured)
        files[f"trials/{plain}-agreement.csv"] = sheet(
            AGREEMENT.columns, [AGREEMENT.flat(each) for each in verdicts if each.agreement.case == name]
        )
        files |= {figure.path: figure for figure in charts}
        files[case_file(name)] = fill(
            "scene.html",
            store,
            title=case["title"],
            case=case,
            family=FAMILIES["scene"],
            file=file_of(name),
            robot=robots.get(folder_of(name)),
            found=[judged(store, agreement) for agreement in agreements],
            seen=(seen := sight(store, name)),
            lead=next(
                (line for each in agreements for line in happened_words(happenings(store, each), each, titles(store))), ""
            ),
            own={line.colour for engine, line in looks(engines(store)).items() if engines(store)[engine]["ours"]},
            summary=summary(store, name),
            answers=[answer for agreement in agreements for answer in answers_of(store, agreement, seen)],
            meanings=VERDICTS,
            figures=charts,
            prices=listed,
            several=len({line.title for line in listed}) > 1,
            laws=laws_of_case(store, case),
            metrics=metrics_of(measured),
            trials=[trial(store, row, measured.get(row["trial"], {})) for row in records(mine)],
            departures=departures(mine),
            shown=shown,
            meant={FINITE.name: FINITE} | {name: status for name, status in STATUSES.items() if name != "passed"},
            csv=f"trials/{plain}.csv",
            sheet=f"trials/{plain}-agreement.csv",
            recording=f"../recordings/{file_name(name)}" if is_file(recording) else None,
            view=f"plumbline view {shlex.quote(str(store.folder))} {shlex.quote(name)}",
        )
    return files


@dataclass(frozen=True, slots=True)
class SceneAnswer:
    """One question that a person asks of a scene of theirs. Terms: leads: to the part of the page that shows it whole. picture:
    None where there is nothing to draw."""

    title: str
    sentences: tuple[str, ...]
    leads: str
    picture: AnswerPicture | None


def answers_of(store: Store, agreement: Agreement, seen: CaseSight) -> list[SceneAnswer]:
    """What the first screen says, in the order in which it is needed to act."""
    names = titles(store)
    runs = dict.fromkeys(side.engine for side in agreement.sides if side.word not in ("cannot", "diverged"))
    cannot: dict[str, str] = {}  # of an engine that runs on its other track, which track does not
    for side in agreement.sides:
        if side.word in ("cannot", "diverged"):
            name = f"{names[side.engine]}, {side.track}" if side.engine in runs else names[side.engine]
            cannot.setdefault(name, f"{name}: {side.word} ({side.why}).")
    ended = [f"Runs on {listed([names[engine] for engine in runs])}." if runs else "No engine runs it.", *cannot.values()]
    off = [side for side in agreement.sides if side.word in ("converges elsewhere", "does not converge") and not side.ours]
    turned = settings_turned(store, agreement)
    who = []  # each verdict with its cause behind it
    for side in off:
        mine = [each for each in turned if (each.engine, each.track) == (side.engine, side.track)]
        verdict = f"{names[side.engine]}, {side.track}: {side_words(side, agreement)}."
        who.append(" ".join([verdict, *cause_words(mine, agreement, names)]))
    others = [each for each in turned if (each.engine, each.track) not in {(side.engine, side.track) for side in off}]
    who += cause_words(others, agreement, names)
    costs = cost_words(store)
    best = best_setting(store, agreement)
    scene = [front for front in miniatures(store) if front.address.startswith(case_file(agreement.case))]
    runs_at, apart = answer_pictures.runs_by_step(store, agreement), answer_pictures.distances(store, agreement, seen.overview)
    closed = answer_pictures.causes(store, agreement, turned)
    cheap = answer_pictures.fronts(scene, answer_pictures.least_errors(store, agreement))
    fast = answer_pictures.speeds(store, agreement, best_price(store, agreement))
    agree = [headline(agreement, names), *unresolved_words(agreement), *cut_words(agreement, names)]
    nowhere = "No setting is known to err by 1 % or less."
    return [
        SceneAnswer("Does it run?", tuple(ended), "trials", runs_at),
        SceneAnswer("Do they agree?", tuple(agree), "agreement", apart),
        SceneAnswer("Who is off, and why?", tuple(who) or ("Nobody.",), "parting" if seen.parting else "agreement", closed),
        SceneAnswer(
            "What does accuracy cost?", tuple(costs) or ("Nothing was clocked at a limit that is agreed.",), "charts", cheap
        ),
        SceneAnswer("What to set?", (best or nowhere,), "charts", fast),
    ]


def file_of(name: str) -> str:
    """The name of the file that a case lies in."""
    return PurePath(name.partition(":")[2] or name).name


def folder_of(name: str) -> str:
    """The name of the folder that this file lies in."""
    return PurePath(name.partition(":")[2] or name).parent.name


def judged(store: Store, agreement: Agreement) -> dict[str, Any]:
    """One agreement for the template: verdicts in words, and what stays defined beyond the horizon."""
    laws: dict[str, dict[tuple[str, str], Any]] = {}
    for balance in balances(store, agreement):
        laws.setdefault(LAWS[balance.law], {})[balance.engine, balance.track] = balance
    return {
        "one": agreement,
        "sides": [(side, VERDICTS[side.word]) for side in agreement.sides],
        "away": {
            (side.engine, side.track): (side.distance, metres(side.distance, agreement))
            for side in agreement.sides
            if side.distance is not None
        },
        "known": {
            (side.engine, side.track): (bar := side.limit.bar_at(side.limit.until), metres(bar, agreement))
            for side in agreement.sides
            if side.limit.bar is not None and side.limit.until > 0
        },
        "bar": None if agreement.bar is None else (agreement.bar, metres(agreement.bar, agreement)),
        "laws": {law: by_side for law in LAWS.values() if (by_side := laws.get(law))},
        "outlooks": (ensembles := outlooks(store, agreement)),
        "foreseeable": foreseeable_until(agreement, ensembles),
        "horizon": horizon_of(agreement),
    }


PAGE = Page(name="scene", title="Your scenes", order=51, render=render, concerns=concerns, listed=False)
