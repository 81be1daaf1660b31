"""The price list: what an error of a case costs on each engine; worked out in `harness.findings.prices`."""

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import asdict, fields
from typing import Any

from plumbline.harness.findings.emulations import share_in_words
from plumbline.harness.findings.priced import priced
from plumbline.harness.findings.prices import Price
from plumbline.harness.findings.steps_taken import step_in_words
from plumbline.harness.store.store import Store

COLUMNS = tuple(field.name for field in fields(Price))


def rows(store: Store) -> list[dict[str, Any]]:
    """Flat rows with COLUMNS."""
    return [asdict(row) for row in priced(store).prices]


BRIEF = ("case", "error", "engine", "CPU s", "95 %", "x cheapest", "95 %", "setting", "step", "tried", "marks")
"""What a terminal has room for; marks: * cheapest to deploy, ~ an unstable timing, <= the cheapest point errs less already."""


def brief(row: Mapping[str, Any]) -> list[object]:
    """A flat row in short words under BRIEF."""
    case = f"{row['case']} {row['where']}".strip()
    if row["cost"] is None:
        best = (
            f", best {row['best_error']:.2g} down to {step_in_words(row['finest_dt'], row['finest_substeps'])}"
            if row["best_error"] is not None
            else ""
        )
        if row["foreseen_dt"] is not None:
            best += f", trend {1e3 * row['foreseen_dt']:.2g} ms"
        outcome = f"{row['verdict']}{best}" if not row["reason"] else f"{row['verdict']}: {row['reason']}"
        return [case, f"{row['target']:.0e}", row["engine"], outcome, "", "", "", row["track"], "", _tried(row), ""]
    marks = ("*" if row["cheapest"] else "") + ("~" if row["unstable"] else "")
    marks += {"at most": "<=", "within the truth's error": "truth"}.get(row["verdict"], "")
    marks = " ".join(filter(None, (marks, share_in_words(row["emulated"]))))
    return [
        case,
        f"{row['target']:.0e}",
        row["engine"],
        f"{row['cost']:.3g}",
        f"{row['low']:.3g} .. {row['high']:.3g}",
        "" if row["ratio"] is None else f"{row['ratio']:.3g}",
        "" if row["ratio"] is None else f"{row['ratio_low']:.3g} .. {row['ratio_high']:.3g}",
        row["track"],
        step_in_words(row["dt"], row["substeps"]),
        _tried(row),
        marks,
    ]


def _tried(row: Mapping[str, Any]) -> str:
    return f"{row['tried']}" + (" (all there are)" if row["ended"] == "nothing left to try" else "")


def sentences(rows: Sequence[Mapping[str, Any]]) -> list[str]:
    """Who is cheapest how often."""
    pairs = {(row["case"], row["where"], row["target"]) for row in rows if row["cheapest"]}
    counts = Counter(row["engine"] for row in rows if row["cheapest"])
    share = ", ".join(f"{engine} {count}" for engine, count in counts.most_common())
    return [f"Of {len(pairs)} pairs of case and error that an engine to deploy reaches, cheapest: {share}."] if pairs else []
