"""What a comparison leaves on disk: for a pull request, a build server, other trackers of benchmarks, and a page's corner.

The figures of a run for other trackers of benchmarks: airspeed velocity's results, and Bencher's metric format.

Sources: asv, 'Developer docs', file format of results, version 2 (columns of each benchmark under 'result_columns'); Bencher,
'Bencher Metric Format' (benchmark, measure, value with lower_value and upper_value).

What changed for a build server: one test for each case and engine, which fails where something is worse than before.

Source: the XML schema that Jenkins and others share: testsuites, testsuite, testcase, failure, skipped, system-out.
"""

import json
import math
from collections.abc import Callable, Collection, Iterator
from dataclasses import asdict, dataclass
from datetime import datetime
from typing import Any
from xml.etree import ElementTree

from plumbline.harness.findings.changes.values import ANSWERS, Change, Changes
from plumbline.harness.findings.changes.words import (
    command,
    first_line,
    folded,
    gate_in_short,
    headline,
    judged_in_short,
    one_a_side,
    sentence,
)
from plumbline.harness.findings.parameter_words import where_of
from plumbline.harness.intake.safe_text import LONGEST, LONGEST_TEXT, markdown_cell, one_line, readable, visible
from plumbline.harness.statistics.interval import Interval
from plumbline.harness.store.machine_fingerprint import machine_digest
from plumbline.harness.store.record import digest
from plumbline.harness.store.store import Store

LONGEST_COMMENT = 60_000
"""Characters: a comment on GitHub holds 65 536, and what posts it may add to it."""
_MOST = 25
"""Lines of one section; nobody reads more there."""
_SECTIONS = (
    ("Worse", ("worse",)),
    ("Unconfirmed", ("unconfirmed",)),
    ("Better", ("better",)),
    ("Other bits, within tolerance", ("within tolerance",)),
)


def comment(changes: Changes, gated: Collection[str] = (), least: float = 0.0) -> str:
    """The summary in Markdown, never longer than LONGEST_COMMENT. Args: least: see `gate_in_short`."""
    lines = ["# What changed", "", markdown_cell(first_line(changes)), "", f"**{markdown_cell(headline(changes))}.**"]
    if not gated:
        lines += ["", f"{judged_in_short(changes.judged_of()).capitalize()}."]
    else:
        lines += ["", f"Gate ({markdown_cell(', '.join(sorted(gated)))}): {gate_in_short(changes, gated, least)}."]
    lines += [f"Not compared: {markdown_cell(text)}" for text in changes.unread]
    for title, senses in (*_SECTIONS, ("Circumstances", ("neither",))):
        rows = [row for row in changes.rows if row.sense in senses]
        lines += _section(title, rows, changes) if rows else []
    made = ""
    for number, line in enumerate(lines):
        rest = f"\n… {len(lines) - number} lines more: `plumbline diff` prints them.\n"
        if len(made) + len(line) + 1 + len(rest) > LONGEST_COMMENT:
            return made + rest
        made += f"{line}\n"
    return made


def _section(title: str, rows: list[Change], changes: Changes) -> list[str]:
    groups = one_a_side(folded(rows))
    lines = ["", f"## {title} ({len(rows)})", ""]
    for text, group in groups[:_MOST]:
        command_line = command(group[0], changes)
        shown = f" `{one_line(command_line, LONGEST).replace('`', '')}`" if command_line else ""
        lines.append(f"* {markdown_cell(text)}{shown}")
    return [*lines, f"* … and {len(groups) - _MOST} more"] if len(groups) > _MOST else lines


_COLUMNS = ["result", "params", "version", "started_at", "duration", "stats_ci_99_a", "stats_ci_99_b", "stats_q_25",
            "stats_q_75", "number", "repeat", "samples", "profile"]  # fmt: skip
"""In the order in which asv writes them; trailing ones may be left out of a row."""


@dataclass(frozen=True, slots=True)
class _Figure:
    """One number of one trial. Terms: values by name, ordered: what asv calls parameters."""

    benchmark: str
    settings: tuple[str, str, str]
    value: Interval


def _name(row: Any, store: Store) -> str:
    """The case; a trial that departs from the case's parameters, or counts something else than steps, is another benchmark."""
    where = where_of(store.catalogue, row.case, row.parameters)
    unit = row.unit if isinstance(row.unit, str) and row.unit != "step" else ""
    return str(row.case) + (f"({where})" if where else "") + (f".{unit}" if unit else "")


def _settings(row: Any) -> tuple[str, str, str]:
    return row.engine, row.track, f"{row.dt:.6g}"


def _beside(row: Any) -> bool:
    """Was something else clocked than the work itself, once?"""
    return getattr(row, "workers", 1) != 1 or getattr(row, "clocks", "work") != "work"


def _prices(store: Store) -> Iterator[_Figure]:
    for row in store.asked.itertuples():
        if row.cpu_per_unit == row.cpu_per_unit and not _beside(row):
            price = Interval(float(row.cpu_per_unit), float(row.cpu_per_unit_low), float(row.cpu_per_unit_high))
            yield _Figure(_name(row, store), _settings(row), price)


def _errors(store: Store) -> Iterator[_Figure]:
    cases = store.catalogue.get("cases", {})
    values = {(str(m.trial), str(m.metric)): m for m in store.measurements.itertuples()}
    for row in store.asked.itertuples():
        headline = values.get((str(row.trial), str(cases.get(row.case, {}).get("headline"))))
        if headline is not None and math.isfinite(headline.value):
            off, value = float(getattr(headline, "truth_error", 0.0) or 0.0), float(headline.value)
            yield _Figure(_name(row, store), _settings(row), Interval(value, value - off, value + off))


def bencher(store: Store) -> dict[str, dict[str, dict[str, float]]]:
    """By benchmark 'case/engine/track/dt': the measures 'latency' [ns of CPU time a unit] and 'error' [the case's own unit]."""
    made: dict[str, dict[str, dict[str, float]]] = {}
    for measure, scale, figures in (("latency", 1e9, _prices(store)), ("error", 1.0, _errors(store))):
        for figure in figures:
            name = "/".join((figure.benchmark, *figure.settings))
            value = dict(
                zip(
                    ("value", "lower_value", "upper_value"),
                    (scale * each for each in (figure.value.value, *figure.value.ends)),
                    strict=True,
                )
            )
            made.setdefault(name, {})[measure] = value
    return made


def asv(store: Store) -> dict[str, Any]:
    """A results file of version 2: for each case a time_ benchmark [s] and a track_ one (the error), over engine, track, dt."""
    machine = store.machine
    started = _milliseconds(machine.get("started"))
    results: dict[str, list[Any]] = {}
    for prefix, figures in (("time", list(_prices(store))), ("track", list(_errors(store)))):
        for benchmark in dict.fromkeys(figure.benchmark for figure in figures):
            mine = {figure.settings: figure for figure in figures if figure.benchmark == benchmark}
            axes = [list(dict.fromkeys(settings[k] for settings in mine)) for k in range(3)]
            grid = [mine.get((engine, track, dt)) for engine in axes[0] for track in axes[1] for dt in axes[2]]
            value, low, high = ([None if each is None else each.value[k] for each in grid] for k in range(3))
            results[f"plumbline.{prefix}_{benchmark}"] = [
                value,
                [[f"'{value}'" for value in axis] for axis in axes],
                "1",
                started,
                0.0,
                low,
                high,
            ]
    properties = {"machine": machine_digest(machine) or "unknown", "cpu": str(machine.get("processor", "")),
                  "num_cpu": str(machine.get("cores", "")), "os": str(machine.get("system", "")),
                  "ram": str(machine.get("memory_mb", "")), "arch": ""}  # fmt: skip
    python = str(machine.get("python", ""))
    commit = digest(sorted(store.trials["trial"]))  # names of trials cover versions and sources, as a commit would
    return {
        "version": 2, "commit_hash": commit, "date": started, "env_name": f"existing-py{python}", "python": python,
        "requirements": {str(k): str(v) for k, v in (machine.get("packages") or {}).items()}, "env_vars": {},
        "params": properties, "result_columns": _COLUMNS, "results": results, "durations": {},
    }  # fmt: skip


def _milliseconds(text: Any) -> int:
    """Since 1970, as asv counts them; 0 for no date."""
    try:
        return int(datetime.fromisoformat(str(text)).timestamp() * 1000)
    except ValueError:
        return 0


_LABEL = "plumbline"
_WIDTH, _PADDING, _HEIGHT = 7, 12, 20
"""Pixels of a letter, around a word, and of all of it."""
_WORSE, _BETTER, _SAME = "#b3261e", "#2e6da4", "#2e7d32"
"""White on each has a contrast of 4.5 to 1 or more."""


def badge(changes: Changes, gated: Collection[str] = ()) -> str:
    """An SVG with a title that says the same; without gated engines, all of them count."""
    worse = len(changes.regressions(gated)) if gated else sum(row.regression for row in changes.rows)
    better = sum(row.sense == "better" and row.kind in ANSWERS for row in changes.rows)
    message = f"{worse} worse" if worse else f"{better} better" if better else "no change"
    colour = _WORSE if worse else _BETTER if better else _SAME
    left, right = (len(text) * _WIDTH + _PADDING for text in (_LABEL, message))
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{left + right}" height="{_HEIGHT}" role="img" '
        f'aria-label="{_LABEL}: {message}"><title>{_LABEL}: {message}</title>'
        f'<rect width="{left}" height="{_HEIGHT}" fill="#444"/>'
        f'<rect x="{left}" width="{right}" height="{_HEIGHT}" fill="{colour}"/>'
        f'<g fill="#fff" text-anchor="middle" font-family="Verdana,DejaVu Sans,sans-serif" font-size="11">'
        f'<text x="{left / 2}" y="14">{_LABEL}</text><text x="{left + right / 2}" y="14">{message}</text></g></svg>\n'
    )


def junit(changes: Changes, store: Store, gated: Collection[str] = (), least: float = 0.0) -> str:
    """The document. A case that has no answer on an engine is skipped; without gated engines, all of them count.

    Args: least: see `gate_in_short`; where too little could be judged, a test of its own fails.
    """
    cells = {(str(case), str(engine)): trials for (case, engine), trials in store.trials.groupby(["case", "engine"], sort=True)}
    rows: dict[tuple[str, str], list[Change]] = {cell: [] for cell in cells}
    for row in changes.rows:
        if (row.case, row.engine) in rows or (not row.case and row.engine and row.kind == "price"):
            rows.setdefault((row.case or "all cases", row.engine), []).append(row)
    suite = ElementTree.Element("testsuite", name="plumbline diff")
    failures = skipped = 0
    for (case, engine), changed in rows.items():
        test = ElementTree.SubElement(suite, "testcase", classname=visible(engine, ""), name=visible(case, ""), time="0")
        worse = [row for row in changed if row.regression and (not gated or engine in gated)]
        trials = cells.get((case, engine))
        if worse:
            failures += 1
            failure = ElementTree.SubElement(test, "failure", type=worse[0].kind, message=_clean(sentence(worse[0])))
            failure.text = _clean("\n".join(f"{sentence(row)}\n  {command(row, changes)}" for row in worse))
        elif trials is not None and trials["status"].isin(("unsupported", "unavailable", "interrupted")).all():
            skipped += 1
            ElementTree.SubElement(test, "skipped", message=_clean(f"{trials['status'].iloc[0]}: {trials['reason'].iloc[0]}"))
        if others := [row for row in changed if row not in worse]:
            ElementTree.SubElement(test, "system-out").text = _clean("\n".join(map(sentence, others)))
    if gated and changes.judged_of(gated).share < least:
        failures += 1
        rows["gate", "judged"] = []
        test = ElementTree.SubElement(suite, "testcase", classname="gate", name="judged", time="0")
        message = _clean(gate_in_short(changes, gated, least))
        ElementTree.SubElement(test, "failure", type="not judged", message=message)
    for name, count in (("tests", len(rows)), ("failures", failures), ("errors", 0), ("skipped", skipped)):
        suite.set(name, str(count))
    suite.set("time", "0")
    judged = ElementTree.SubElement(suite, "system-out")
    judged.text = _clean(judged_in_short(changes.judged_of(gated)) if not gated else gate_in_short(changes, gated, least))
    # Of all suites together the schema of Jenkins (junit-10.xsd) has no count of what was skipped.
    root = ElementTree.Element("testsuites", {name: value for name, value in suite.attrib.items() if name != "skipped"})
    root.append(suite)
    text: str = ElementTree.tostring(root, encoding="unicode", xml_declaration=False)
    return f'<?xml version="1.0" encoding="utf-8"?>\n{text}\n'


def _clean(text: str) -> str:
    return readable(text, LONGEST_TEXT)


def flat_rows(changes: Changes) -> list[dict[str, Any]]:
    """The rows as flat mappings, each with its sentence and its command."""
    return [
        asdict(row) | {"regression": row.regression, "sentence": sentence(row), "command": command(row, changes)}
        for row in changes.rows
    ]


def changes_files(changes: Changes, store: Store, gated: Collection[str] = (), least: float = 0.0) -> dict[str, bytes]:
    """The content of each file by name.

    Args: store: of B, whose figures are exported. gated: those that may not be worse. least: see `gate_in_short`.
    """
    made: dict[str, Callable[[], str]] = {
        "changes.json": lambda: json.dumps(flat_rows(changes), indent=1, default=str),
        "summary.md": lambda: comment(changes, gated, least),
        "junit.xml": lambda: junit(changes, store, gated, least),
        "asv.json": lambda: json.dumps(asv(store), indent=1, allow_nan=False),
        "bencher.json": lambda: json.dumps(bencher(store), indent=1, allow_nan=False),
        "badge.svg": lambda: badge(changes, gated),
    }
    return {name: make().encode() for name, make in made.items()}
