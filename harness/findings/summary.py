"""Two short answers beside the tables: junit.xml for build servers, and summary.md for people."""

from collections.abc import Mapping, Sequence
from typing import Any
from xml.etree import ElementTree

import pandas as pd

from plumbline.harness.findings.agreement import AGREED_TRUTH
from plumbline.harness.findings.compact_listing import rows, told_apart
from plumbline.harness.findings.emulations import whose
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
    for row, told in zip(columns.itertuples(), told_apart(trials, catalogue), strict=True):
        name = f"{row.case}[{row.engine}/{row.track}/dt={row.dt:g}{told and f'/{told}'}]"
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
    verdicts = TABLE.sentences(TABLE.rows(store))
    return {
        "junit.xml": _junit(store.trials, store.catalogue),
        "summary.md": _markdown(store.trials, store.catalogue, verdicts),
    }


def write_summary(store: Store) -> None:
    """Write junit.xml and summary.md into the run folder."""
    for name, content in summaries(store).items():
        write_atomically(store.folder / name, content)
