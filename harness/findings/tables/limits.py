"""How far each engine goes along each axis before it breaks, by what, and what a step costs there."""

from collections.abc import Sequence
from operator import attrgetter

from plumbline.harness.findings.columns import Column, Table, Titled, Titles, milli, names, plain, scene
from plumbline.harness.findings.limits_found import CONSTANT, Search, amount, searches
from plumbline.harness.findings.parameter_words import called
from plumbline.harness.findings.standing import is_reference, leaders
from plumbline.harness.metric.titles import metric_title
from plumbline.harness.store.rows import grouped


def _axis(row: Search) -> str:
    return f"{row.axis} {row.easy:.4g}..{row.extreme:.4g}{'' if row.unit == '1' else ' ' + row.unit}"


def _broke(row: Search) -> str:
    silent = row.verdict in ("stopped", "unsupported", "unavailable", CONSTANT)
    return str(row.verdict) if silent else amount(row.broke, "none")


def _by(row: Search) -> str:
    return f"{row.signs.text or row.reason[:60]}{'; its own start holds' if row.own_holds else ''}"


def _signs(search: Search) -> str:
    signs = ", ".join(f"{metric_title(metric)} {count}" for metric, count in search.signs.counts)
    return signs or search.signs.text or search.verdict


def _setting(row: Search) -> str:
    return row.track if not row.parts else f"{row.track}, dt/{row.parts}"


def _sentences(rows: Sequence[Search]) -> list[str]:
    """Axis by axis and sub-step by sub-step, who goes farthest of the engines that people can deploy, and the reference engine.

    Whose brackets meet go as far as each other; leads are counted by the table `farthest`.
    """
    lines = []
    fair = (row for row in rows if row.verdict not in ("unsupported", "unavailable", CONSTANT) and row.fair)
    # Tracks as they come are not compared with what is held to a sub-step.
    axes = grouped(fair, attrgetter("experiment", "case", "where", "axis", "parts"))
    for (_, case, where, axis, parts), searched in axes.items():
        ours = max((row for row in searched if is_reference(row.engine)), key=lambda row: row.reach, default=None)
        ranked = [row for row in searched if not is_reference(row.engine) and row.held is not None]
        first = leaders({_searched(row): (row.reach, row.further) for row in ranked})
        best = sorted((row for row in ranked if _searched(row) in first), key=lambda row: -row.reach)
        held = best[0].held if best else None
        names = [_searched(row) + (f" to {amount(row.held, '')}" if row.held != held else "") for row in best]
        beside = "" if ours is None else f"; {ours.engine}, not ranked, {amount(ours.held, 'no value')}"
        name = f"{case} {where}".strip() + (f", sub-step dt/{parts}" if parts else ", as tracks come")
        lines.append(f"{name}: {axis} up to {amount(held, 'no value')}: {', '.join(names) or 'nobody'}{beside}.")
    return lines


def _searched(row: Search) -> str:
    return f"{row.engine} ({_setting(row)})"


TABLE = Table(
    holds=names(Search, "beside", "remedy", "remedied", "holds", "along", "noticed").replace("signs", "signs=signs.text")
    + " noticed=noticed_in_words along=along_in_words further fair",
    objects=lambda store: [search for search in searches(store) if not search.remedied],
    shown=(
        Column("case", scene),
        Column("engine", "engine"),
        Column("setting", _setting),
        Column("axis", _axis),
        Column("held", lambda row: "" if row.verdict == CONSTANT else amount(row.held, "none")),
        Column("broke", _broke),
        Column("share held there", "share", ".2f"),
        Column("by", _by),
        Column("headline error", "along_in_words"),
        Column("CPU s per s", lambda row: amount(row.cost, "")),
        Column("ms a step", lambda row: milli(row.step_cost), ".3g"),
        Column("values", "values"),
    ),
    sentences=_sentences,
    paper=(
        Titled("Case", Titles.scene),
        Titled("Engine", Titles.engine),
        Column("Track", "track"),
        Column("Axis", lambda search: called(search.case, search.axis)),
        Column("Unit", lambda search: "" if search.unit == "1" else search.unit),
        *plain("Held to=held", "Broke at=broke"),
        Column("CPU time [ms/s]", lambda search: milli(search.cost)),
        Column("By", _signs),
    ),
)
