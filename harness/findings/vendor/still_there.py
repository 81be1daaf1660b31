"""Whether a finding is still there: its script, run alone in a fresh process."""

import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Literal

from plumbline.harness.findings.vendor.finding import Finding

SECONDS = 60.0
"""After which a script counts as hung: six times what one may take on a machine that does nothing else."""

Verdict = Literal["still there", "gone", "unavailable", "failed"]
"""unavailable: what the script needs is not installed; failed: it ended without an answer."""

_UNAVAILABLE = "ModuleNotFoundError"


@dataclass(frozen=True)
class Standing:
    """What a script said.

    finding: which. verdict: of it. figure: in the script's own words, or why there is none. version: of the engine that is
    installed, '' where none is. seconds: how long it took, by the wall."""

    finding: Finding
    verdict: Verdict
    figure: str
    version: str
    seconds: float


def _version(finding: Finding, python: str) -> str:
    """Of the package that the script's first requirement names, in whichever interpreter runs it."""
    package = finding.requires[0].partition("=")[0] if finding.requires else finding.engine
    command = f"import importlib.metadata as m; print(m.version({package!r}))"
    done = subprocess.run([python, "-I", "-c", command], capture_output=True, text=True, timeout=SECONDS, check=False)
    return done.stdout.strip()


def ask(finding: Finding, python: str = sys.executable) -> Standing:
    """Run a script, isolated from this project and from the user's paths.

    Args: python: the interpreter, in whose environment the engine is installed.
    """
    begun = time.monotonic()
    try:
        with tempfile.TemporaryDirectory() as folder:
            done = subprocess.run(
                [python, "-I", str(finding.script)], cwd=folder, capture_output=True, text=True, timeout=SECONDS, check=False
            )
    except subprocess.TimeoutExpired:
        return Standing(finding, "failed", f"no answer within {SECONDS:g} s", _version(finding, python), SECONDS)
    took = time.monotonic() - begun
    # A vendor's library may end its own lines on the console without a line break.
    last = done.stdout.rstrip().rpartition("\n")[2]
    for verdict in ("still there", "gone"):
        _, said, figure = last.partition(f"{verdict}: ")
        if done.returncode == 0 and said:
            return Standing(finding, verdict, figure, _version(finding, python), took)
    why = (done.stderr.strip() or done.stdout.strip() or "no output").rpartition("\n")[2]
    missing = why.startswith(_UNAVAILABLE)
    reason = why if done.returncode >= 0 else f"ended by signal {-done.returncode}"
    return Standing(finding, "unavailable" if missing else "failed", reason, _version(finding, python), took)


def ask_all(findings: Sequence[Finding], python: str = sys.executable) -> Iterator[Standing]:
    """Each in its turn, as it is known."""
    for finding in findings:
        yield ask(finding, python)
