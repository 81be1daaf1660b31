"""The text beside the pictures: the question, every trial's outcome, and settings and measurements of those shown."""

import json
from collections.abc import Mapping, Sequence
from typing import Any

from plumbline.harness.findings.parameter_words import step_in_words, substeps_of
from plumbline.harness.store.store import Store
from plumbline.reports.recordings.runs import Stage
from plumbline.reports.words.text import amount, settings_text, visible

ESCAPED = str.maketrans({"\n": " ", "\t": " "} | {mark: f"\\{mark}" for mark in "\\|`*_<>[]"})
"""What would end a cell, or be taken for a mark of Markdown."""


def cell(value: Any) -> str:
    """Text that stays within its cell of a Markdown table."""
    return visible(str(value)).translate(ESCAPED)


def table(head: Sequence[str], rows: Sequence[Sequence[Any]]) -> list[str]:
    """Lines of a Markdown table."""
    lines = [head, ["---"] * len(head), *([cell(value) for value in row] for row in rows)]
    return [f"| {' | '.join(line)} |" for line in lines] + [""]


def outcome(trial: Mapping[str, Any], note: str) -> str:
    """The reason, and what of the trajectory is not shown."""
    return f"{trial['reason']}; {note}" if note else str(trial["reason"])


def text(store: Store, stage: Stage, newtons: float, notes: Sequence[str] = ()) -> str:
    """The whole text as Markdown.

    Args:
        newtons: the force [N] of an arrow of unit length in m, 0 where no contact is drawn. notes: what else is to be said.
    """
    case = stage.case
    lines = [f"# {cell(case.get('title') or stage.name)}", ""]
    lines += [cell(case["question"]), ""] if case.get("question") else []
    lines += [f"Truth: {cell(case['truth'])}. Source: {cell(case.get('source', ''))}", ""] if case.get("truth") else []
    if newtons:
        lines += [f"Contact forces: 1 m of arrow is {amount(newtons)} N; arrows end at three times the typical largest.", ""]
    lines += [line for note in notes for line in (cell(note), "")]
    if not stage.runs:
        lines += ["No trial of this case left a trajectory; nothing can be drawn.", ""]
    shown = {run.trial["trial"] for run in stage.runs}
    ranked = sorted(stage.trials, key=lambda t: (t["trial"] not in shown, t["engine"], t["track"], -t["dt"]))
    lines += ["## Outcomes", ""]
    lines += table(
        ("engine", "track", "time step", "shown", "status", "reason"),
        [
            (
                t["engine"],
                t["track"],
                step_in_words(t["dt"], substeps_of(str(t["resolved"]))),
                "yes" if t["trial"] in shown else "no",
                t["status"],
                outcome(t, stage.notes.get(t["trial"], "")),
            )
            for t in ranked
        ],
    )
    for run in stage.runs:
        lines += run_text(store, run.trial)
    return "\n".join(lines)


def run_text(store: Store, trial: Mapping[str, Any]) -> list[str]:
    """Trial, settings and measurements of a run that is shown."""
    lines = [f"## {cell(trial['engine'])}, {cell(trial['track'])}: {trial['status']}", ""]
    lines += [f"Trial {trial['trial']}, version {cell(trial['engine_version'])}, seed {trial['seed']}", ""]
    lines += [f"Requested: {cell(settings_text(trial['settings']))}", ""]
    lines += [f"Resolved: {cell(settings_text(trial['resolved']))}", ""]
    parameters = settings_text(trial["parameters"])
    lines += [f"Parameters: {cell(parameters)}", ""] if parameters else []
    warnings = json.loads(trial["warnings"]) if isinstance(trial["warnings"], str) else []
    lines += [f"Warning: {cell(warning)}\n" for warning in warnings]
    rows = store.measured.get(trial["trial"], ())
    verdicts = {True: "holds", False: "fails"}
    return lines + table(
        ("metric", "value", "unit", "bound", ""),
        [
            (r["metric"], amount(r["value"]), r["unit"], amount(r["at_most"]), verdicts.get(r["passed"], "observed"))
            for r in rows
        ],
    )
