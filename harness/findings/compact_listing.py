"""What tells the trials of a run apart in a listing, and which of them did not pass, one row for those that read alike.

A run puts the same question more than once: as a rung of a ladder, as a first look, and again and again to see whether the bits
stay. Such trials differ in nothing that a reader sees, as long as they end alike; then they are one row with their number.
"""

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import pandas as pd

from plumbline.harness.case.alteration import Alteration
from plumbline.harness.findings.steps_taken import step_in_words, substeps_of
from plumbline.harness.findings.variant_of import differing, in_words

ALIKE = "as it is"
"""How a scene is run that is neither another one nor run once more."""

EVERY_STEP = "every step recorded"
"""The run that repetitions are compared with; a metric that looks at more instants may find more."""


@dataclass(frozen=True, slots=True)
class Row:
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
        _joined(told, () if how[alteration] == ALIKE else (how[alteration],))
        for told, alteration in zip(_apart(trials, catalogue), trials["alteration"], strict=True)
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


def rows(trials: pd.DataFrame, catalogue: Mapping[str, Any]) -> list[Row]:
    """The trials as rows, in the order in which each row's first stands; no two of them read alike."""
    how = {text: _repetition(text) for text in trials["alteration"].unique()}
    groups: dict[tuple[str, ...], dict[str, list[str]]] = {}
    columns = trials[["case", "engine", "track", "dt", "resolved", "status", "reason", "alteration"]]
    for row, told in zip(columns.itertuples(index=False), _apart(trials, catalogue), strict=True):
        step = step_in_words(row.dt, substeps_of(str(row.resolved)))
        key = (str(row.case), str(row.engine), str(row.track), step, told, str(row.status))
        groups.setdefault(key, {}).setdefault(str(row.reason), []).append(how[row.alteration])
    return [
        Row(case, engine, track, dt, _joined(told, ways if apart else ()), status, reason, len(ways))
        for (case, engine, track, dt, told, status), by_reason in groups.items()
        for reason, ways in by_reason.items()
        for apart in (len(by_reason) > 1 or _once_more(ways),)
    ]


def _once_more(ways: Sequence[str]) -> bool:
    """Was the scene run once more each time? Its first run ended otherwise then."""
    return not {"", ALIKE, EVERY_STEP} & set(ways)


def _joined(told: str, ways: Sequence[str]) -> str:
    return ", ".join(filter(None, (told, *dict.fromkeys(ways))))


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
