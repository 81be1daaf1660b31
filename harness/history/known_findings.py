"""Of the findings about engines: which a night found still there, and which turned since the last night that asked."""

from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from typing import Any

from plumbline.harness.findings.vendor.finding import Finding
from plumbline.harness.findings.vendor.still_there import SECONDS, ScriptAnswer, ask

_ANSWERS = ("still there", "gone")


def asked_again(
    findings: Sequence[Finding],
    engines: Collection[str],
    left: Callable[[], float],
    answer: Callable[[Finding], ScriptAnswer] = ask,
) -> list[dict[str, Any]]:
    """Flat rows of those of these engines, as a night's file keeps them; none more once a hung one would not fit.

    Args: left: seconds of the budget that are left.
    """
    rows = []
    for finding in findings:
        if finding.engine in engines and left() > SECONDS:
            standing = answer(finding)
            rows.append(
                {"name": finding.name, "verdict": standing.verdict, "figure": standing.figure, "version": standing.version}
            )
    return rows


def turned(findings: Sequence[Finding], rows: Sequence[Mapping[str, Any]], plans: Iterable[Mapping[str, Any]]) -> list[str]:
    """A sentence for each that is gone or back: whose answer is another than the last one before. Args: plans: of the nights
    before, the earliest first."""
    before: dict[str, Mapping[str, Any]] = {}
    for plan in plans:
        before |= {row["name"]: row for row in plan.get("findings", ()) if row["verdict"] in _ANSWERS}
    titles = {finding.name: finding.title for finding in findings}
    return [
        f"{row['name']} is {'gone' if row['verdict'] == 'gone' else 'back'} ({_since(was['version'], row['version'])}): "
        f"{titles[row['name']]}; {row['figure']}"
        for row in rows
        if (was := before.get(row["name"])) is not None and row["verdict"] in _ANSWERS and row["verdict"] != was["verdict"]
    ]


def _since(before: str, now: str) -> str:
    """The versions of an engine at two answers, in words."""
    return f"with {now}" if now == before else f"{before} -> {now}"
