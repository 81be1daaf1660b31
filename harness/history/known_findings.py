"""Of the findings about engines: which a night found still there, and which turned since the last night that asked."""

from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from plumbline.harness.findings.vendor.finding import Finding
from plumbline.harness.findings.vendor.still_there import SECONDS, Standing, ask

_ANSWERS = ("still there", "gone")


@dataclass(frozen=True, slots=True, kw_only=True)
class Turned:
    """A finding that is gone, or back. before, now: verdicts. figure: of now. version: of the engine; before_version: then."""

    name: str
    title: str
    before: str
    now: str
    figure: str
    version: str
    before_version: str

    @property
    def sentence(self) -> str:
        """For people; never read back."""
        known = f"with {self.version}" if self.version == self.before_version else f"{self.before_version} -> {self.version}"
        state = "gone" if self.now == "gone" else "back"
        return f"{self.name} is {state} ({known}): {self.title}; {self.figure}"


def asked_again(
    findings: Sequence[Finding],
    engines: Collection[str],
    left: Callable[[], float],
    answer: Callable[[Finding], Standing] = ask,
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


def turned(findings: Sequence[Finding], rows: Sequence[Mapping[str, Any]], plans: Iterable[Mapping[str, Any]]) -> list[Turned]:
    """Those whose answer is another than the last one before. Args: plans: of the nights before, the earliest first."""
    before: dict[str, Mapping[str, Any]] = {}
    for plan in plans:
        before |= {row["name"]: row for row in plan.get("findings", ()) if row["verdict"] in _ANSWERS}
    titles = {finding.name: finding.title for finding in findings}
    return [
        Turned(
            name=row["name"],
            title=titles[row["name"]],
            before=was["verdict"],
            now=row["verdict"],
            figure=row["figure"],
            version=row["version"],
            before_version=was["version"],
        )
        for row in rows
        if (was := before.get(row["name"])) is not None and row["verdict"] in _ANSWERS and row["verdict"] != was["verdict"]
    ]
