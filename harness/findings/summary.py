"""Two short answers beside the tables: junit.xml for build servers, and summary.md for people.

A run puts the same question more than once: as a rung of a ladder, as a first look, and again and again to see whether the bits
stay. Such trials differ in nothing that a reader sees, as long as they end alike; then they are one row with their number.
"""

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any
from xml.etree import ElementTree

import pandas as pd

from plumbline.harness.case.alteration import Alteration
from plumbline.harness.findings.agreement.found import AGREED_TRUTH
from plumbline.harness.findings.emulations import whose
from plumbline.harness.findings.parameter_words import differing, in_words, step_in_words, substeps_of
from plumbline.harness.findings.tables.agreement import TABLE
from plumbline.harness.intake.safe_text import markdown_cell, visible
from plumbline.harness.store.disk import write_atomically
from plumbline.harness.store.store import Store

SUMMARIES = ("junit.xml", "summary.md")
_ERRORS = ("crashed", "timeout", "oom", "diverged")
_SKIPPED = ("unsupported", "unavailable", "interrupted")


def _junit(trials: pd.DataFrame, catalogue: Mapping[str, Any]) -> bytes:
    suite = ElementTree.Element("testsuite", name="plumbline", tests=str(len(trials)))
    counts = trials["status"].value_counts()
    suite.set("failures", str(int(counts.get("failed", 0))))
    suite.set("errors", str(int(counts.reindex(_ERRORS, fill_value=0).sum())))
    suite.set("skipped", str(int(counts.reindex(_SKIPPED, fill_value=0).sum())))
    columns = trials[["study", "experiment", "case", "engine", "track", "dt", "status", "reason"]]
    for row, apart in zip(columns.itertuples(), told_apart(trials, catalogue), strict=True):
        name = f"{row.case}[{row.engine}/{row.track}/dt={row.dt:g}{apart and f'/{apart}'}]"
        # Servers take tests of one class and name for one test.
        place = f"{row.study}.{row.experiment}" if row.experiment else str(row.study)
        test = ElementTree.SubElement(suite, "testcase", classname=visible(place), name=visible(name))
        kind = {"failed": "failure"} | dict.fromkeys(_ERRORS, "error") | dict.fromkeys(_SKIPPED, "skipped")
        if row.status in kind:
            ElementTree.SubElement(test, kind[row.status], message=visible(f"{row.status}: {row.reason}"))
    text: bytes = ElementTree.tostring(suite, encoding="utf-8", xml_declaration=True)
    return text


def _markdown(trials: pd.DataFrame, catalogue: Mapping[str, Any], verdicts: Sequence[str]) -> bytes:
    own = trials["case"].isin([name for name, case in catalogue.get("cases", {}).items() if case.get("truth") == AGREED_TRUTH])
    shown = trials.assign(status=trials["status"].mask(own & (trials["status"] == "passed"), "finite"))
    table = shown.groupby(["engine", "track", "status"]).size().unstack(fill_value=0)
    lines = ["# Outcomes", "", "| engine | track | " + " | ".join(map(markdown_cell, table.columns)) + " |"]
    lines.append("|---" * (2 + len(table.columns)) + "|")
    for (engine, track), row in table.iterrows():
        lines.append(f"| {markdown_cell(engine)} | {markdown_cell(track)} | " + " | ".join(str(n) for n in row) + " |")
    notable = trials[trials["status"].isin((*_ERRORS, "failed"))]
    if len(notable):
        lines += [
            "",
            "# What did not pass",
            "",
            "| case | engine | track | dt | differs in | status | reason | by the adapter | trials |",
            "|---|---|---|---|---|---|---|---|---|",
        ]
        for row in rows(notable, catalogue):
            law = whose(catalogue, row.engine, row.case, row.track)
            cells = (row.case, row.engine, row.track, row.dt, row.apart, row.status, row.reason, law, row.count)
            lines.append("| " + " | ".join(map(markdown_cell, cells)) + " |")
    if verdicts:
        lines += ["", "# Who agrees", "", *(f"* {markdown_cell(sentence)}" for sentence in verdicts)]
    return ("\n".join(lines) + "\n").encode()


def summaries(store: Store) -> dict[str, bytes]:
    """The content of junit.xml and summary.md."""
    verdicts = TABLE.said(store)
    return {
        "junit.xml": _junit(store.trials, store.catalogue),
        "summary.md": _markdown(store.trials, store.catalogue, verdicts),
    }


def write_summary(store: Store) -> None:
    """Write junit.xml and summary.md into the run folder."""
    for name, content in summaries(store).items():
        write_atomically(store.folder / name, content)


ALIKE = "as it is"
"""How a scene is run that is neither another one nor run once more."""

EVERY_STEP = "every step recorded"
"""The run that repetitions are compared with; a metric that looks at more instants may find more."""


@dataclass(frozen=True, slots=True)
class ListedTrials:
    """Trials that read alike.

    Terms: dt: '1/60 s (4 sub-steps)', as it was taken. apart: parameters, alteration and remedy in words, and how the scene was
    run, if only the reason differs from another row's or if it was run once more each time; '' for the case as it is. count: of
    the trials.
    """

    case: str
    engine: str
    track: str
    dt: str
    apart: str
    status: str
    reason: str
    count: int


def told_apart(trials: pd.DataFrame, catalogue: Mapping[str, Any]) -> list[str]:
    """For each trial what its scene has in place of the case's own, and how that was run once more: 'edge 6, reordered'."""
    how = {text: _repetition(text) for text in trials["alteration"].unique()}
    return [
        _joined(words, () if how[alteration] == ALIKE else (how[alteration],))
        for words, alteration in zip(_apart(trials, catalogue), trials["alteration"], strict=True)
    ]


def _apart(trials: pd.DataFrame, catalogue: Mapping[str, Any]) -> list[str]:
    """For each trial what its scene has in place of the case's own: 'edge 6, friction off'; '' for the case as it is."""
    cases = catalogue.get("cases", {})
    given = {text: _values(text) for text in trials["parameters"].unique()}
    altered = {text: _altered(text) for text in trials["alteration"].unique()}
    varied = {
        case: differing((given[text] for text in group.unique()), cases.get(case, {}).get("parameters", {}))
        for case, group in trials.groupby("case", sort=False)["parameters"]
    }
    written = []
    for row in trials[["case", "parameters", "alteration", "remedy", "seed"]].itertuples(index=False):
        values = {name: _short(given[row.parameters][name]) for name in varied[row.case] if name in given[row.parameters]}
        seed = {"seed": int(row.seed)} if row.seed else {}
        written.append(", ".join(filter(None, (in_words(values | seed), altered[row.alteration], str(row.remedy)))))
    return written


def rows(trials: pd.DataFrame, catalogue: Mapping[str, Any]) -> list[ListedTrials]:
    """The trials as rows, in the order in which each row's first stands; no two of them read alike."""
    how = {text: _repetition(text) for text in trials["alteration"].unique()}
    groups: dict[tuple[str, ...], dict[str, list[str]]] = {}
    columns = trials[["case", "engine", "track", "dt", "resolved", "status", "reason", "alteration"]]
    for row, words in zip(columns.itertuples(index=False), _apart(trials, catalogue), strict=True):
        step = step_in_words(row.dt, substeps_of(str(row.resolved)))
        key = (str(row.case), str(row.engine), str(row.track), step, words, str(row.status))
        groups.setdefault(key, {}).setdefault(str(row.reason), []).append(how[row.alteration])
    return [
        ListedTrials(case, engine, track, dt, _joined(words, ways if apart else ()), status, reason, len(ways))
        for (case, engine, track, dt, words, status), by_reason in groups.items()
        for reason, ways in by_reason.items()
        # Where the scene was run once more each time, its first run ended otherwise.
        for apart in (len(by_reason) > 1 or not {"", ALIKE, EVERY_STEP} & set(ways),)
    ]


def _joined(words: str, ways: Sequence[str]) -> str:
    return ", ".join(filter(None, (words, *dict.fromkeys(ways))))


def _values(parameters: str) -> dict[str, Any]:
    """Parameters as a table has them."""
    read = json.loads(parameters)
    return read if isinstance(read, dict) else {}


def _short(value: Any) -> Any:
    """A number with four digits, which is what a reader compares."""
    return float(f"{value:.4g}") if isinstance(value, float) else value


def _altered(alteration: str) -> str:
    """The name of an alteration that departs from the scene; '' where the same scene is run once more."""
    read = Alteration.from_plain(json.loads(alteration))
    return "" if read.same_scene else read.name or "altered"


def _repetition(alteration: str) -> str:
    """How the same scene is run: 'as it is', 'again', 'reordered'; '' where the scene is another one."""
    read = Alteration.from_plain(json.loads(alteration))
    return (read.name or (EVERY_STEP if read.every_step else ALIKE)) if read.same_scene else ""
