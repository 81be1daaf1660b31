"""All findings that the project has, or those that were asked for."""

from collections.abc import Sequence
from pathlib import Path

from plumbline.harness.findings.vendor.finding import Finding, FindingError, read_finding

FOLDER = Path(__file__).resolve().parents[3] / "findings"
"""Where the scripts lie, a folder an engine."""


def shelf(folder: Path = FOLDER) -> list[Finding]:
    """Every finding by name. Raises: FindingError, OSError."""
    return [read_finding(path) for path in sorted(folder.glob("*/*.py"))]


def chosen(findings: Sequence[Finding], asked: str) -> list[Finding]:
    """Those of an engine, or the one of this name. Raises: FindingError, with what there is."""
    found = [finding for finding in findings if asked in (finding.engine, finding.name)]
    if not found:
        names = sorted({finding.engine for finding in findings}) + [finding.name for finding in findings]
        raise FindingError(f"no engine and no finding is called '{asked}'; there are {', '.join(names)}")
    return found
