"""Whether a finding is still there, and whether its mend cures it: its script, run alone in a fresh process."""

import re
import sys
import tempfile
import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Literal, get_args

from plumbline.harness.findings.vendor.finding import Finding
from plumbline.harness.intake.bounded import bounded

SECONDS = 60.0
"""After which a script counts as hung: six times what one may take on a machine that does nothing else."""

ScriptVerdict = Literal["still there", "gone", "stands", "unavailable", "failed"]
"""stands: it is there with its mend; unavailable: what the script needs is not installed; failed: no answer."""

_UNAVAILABLE = "ModuleNotFoundError"
_PRICE = re.compile(r"price: (\S+) of an? (\w+)$", re.MULTILINE)


@dataclass(frozen=True)
class Mended:
    """What a script said of its mend.

    verdict: 'gone' if the mend cures it. figure: in the script's own words. price: time of a `unit` (step, ray, loading, ...)
    with the mend over that without, clocked in turns in one process; None without an answer."""

    verdict: ScriptVerdict
    figure: str
    price: float | None = None
    unit: str = ""

    @property
    def cures(self) -> bool:
        """Is the finding gone with its mend?"""
        return self.verdict == "gone"


@dataclass(frozen=True)
class ScriptAnswer:
    """What a script said.

    finding: which. verdict: of it. figure: in the script's own words, or why there is none. version: of the engine that is
    installed, '' where none is. seconds: how long it took, by the wall. mended: the same with its mend, None if not asked."""

    finding: Finding
    verdict: ScriptVerdict
    figure: str
    version: str
    seconds: float
    mended: Mended | None = None

    @property
    def broken(self) -> bool:
        """Did the script end without an answer, or does its mend not cure it?"""
        mended = self.mended
        return self.verdict == "failed" or (mended is not None and not mended.cures and mended.verdict != "unavailable")


def _version(finding: Finding, python: str) -> str:
    """Of the package that the script's first requirement names, in whichever interpreter runs it."""
    package = finding.requires[0].partition("=")[0] if finding.requires else finding.engine
    command = f"import importlib.metadata as m; print(m.version({package!r}))"
    return bounded([python, "-I", "-c", command], SECONDS).out.decode("utf-8", "replace").strip()


def _answer(finding: Finding, python: str, *arguments: str) -> tuple[ScriptVerdict, str, str]:
    """Verdict, figure or reason, and all that was printed."""
    with tempfile.TemporaryDirectory() as folder:
        ended = bounded([python, "-I", str(finding.script), *arguments], SECONDS, cwd=folder)
    printed = ended.out.decode("utf-8", "replace")
    if ended.code is None:
        return "failed", f"no answer within {SECONDS:g} s", ""
    # A vendor's library may end its own lines on the console without a line break.
    last = printed.rstrip().rpartition("\n")[2]
    for verdict in get_args(ScriptVerdict)[:3]:
        _, said, figure = last.partition(f"{verdict}: ")
        if ended.code == 0 and said:
            return verdict, figure, printed
    why = ended.last_words or "no output"
    reason = why if ended.code >= 0 else f"ended by signal {-ended.code}"
    return "unavailable" if why.startswith(_UNAVAILABLE) else "failed", reason, printed


def ask(finding: Finding, python: str = sys.executable) -> ScriptAnswer:
    """Run a script, isolated from this project and from the user's paths.

    Args: python: the interpreter, in whose environment the engine is installed.
    """
    begun = time.monotonic()
    verdict, figure, _ = _answer(finding, python)
    took = time.monotonic() - begun
    return ScriptAnswer(finding, verdict, figure, _version(finding, python), took)


def ask_mended(finding: Finding, python: str = sys.executable) -> Mended:
    """Run a script with its mend; one that tells no price of it has failed. Args: see `ask`."""
    verdict, figure, printed = _answer(finding, python, "--mended")
    price = _PRICE.search(printed)
    if verdict in ("gone", "stands") and price is None:
        return Mended("failed", f"no price of the mend, only '{verdict}: {figure}'")
    return Mended(verdict, figure, float(price[1]) if price else None, price[2] if price else "")


def ask_all(findings: Sequence[Finding], python: str = sys.executable) -> Iterator[ScriptAnswer]:
    """Each in its turn, with its mend, as it is known."""
    for finding in findings:
        yield replace(ask(finding, python), mended=ask_mended(finding, python))
