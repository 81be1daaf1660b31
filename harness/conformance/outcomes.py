"""Putting the checks to an adapter: one outcome per track and check, whatever the adapter does."""

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Literal

from plumbline.harness.adapter import Adapter, SettingsError, Unsupported
from plumbline.harness.conformance.catalogue import CHECKS
from plumbline.harness.conformance.check import CheckResult, ConformanceCheck, NotApplicable
from plumbline.harness.conformance.checks.contract.features import NotRefused, refused
from plumbline.harness.conformance.engine import Engine

Status = Literal["passed", "failed", "known", "improved", "not_applicable"]
_UNFIT: dict[str, tuple[Status, str]] = {
    "passed": ("improved", "it passes: drop the declaration"),
    "not_applicable": ("failed", "it does not apply"),
}
"""What a finding makes of a declaration that it does not fit, and why in words."""


@dataclass(frozen=True, slots=True, kw_only=True)
class CheckOutcome:
    """How one check went on one track of one engine.

    Terms:
        status: passed; failed; known (fails as declared in `known_failures`); improved (declared, but passes: the declaration
        must go); not_applicable (the engine does not claim what the check needs, and refuses it; or it refuses this scene).
        message: got against expected, or why.
    """

    engine: str
    track: str
    check: str
    question: str
    status: Status
    message: str


_WORST_FIRST = ("failed", "improved", "known", "passed", "not_applicable")
_ENDED = {"failed": "fail", "improved": "pass though declared to fail", "known": "fail as declared", "passed": "pass"}


def in_brief(outcomes: Iterable[CheckOutcome]) -> str:
    """'80 of 203 checks apply; all 80 pass': each check counts once, by its worst outcome on any track."""
    worst: dict[str, str] = {}
    for outcome in outcomes:
        known = worst.get(outcome.check, "not_applicable")
        worst[outcome.check] = min(known, outcome.status, key=_WORST_FIRST.index)
    counts = {status: sum(of == status for of in worst.values()) for status in reversed(_WORST_FIRST[:-1])}
    apply = sum(counts.values())
    told = [f"{count} {_ENDED[status]}" for status, count in counts.items() if count]
    ended = f"all {told[0]}" if len(told) == 1 else ", ".join(told) or "nothing to check"
    return f"{apply} of {len(worst)} checks apply; {ended}"


def _finding(adapter: Adapter, track: str, check: ConformanceCheck) -> CheckResult:
    """The check's own verdict; every exception is a failure that names it."""
    try:
        settings = adapter.tracks[track]
        missing = check.needs & ~adapter.features
        if missing:
            return CheckResult("not_applicable", refused(Engine(adapter, settings), missing))
        return check.run(adapter, settings)
    except NotApplicable as reason:
        return CheckResult("not_applicable", str(reason))
    except NotRefused as error:
        return CheckResult("failed", str(error))
    except Unsupported as error:
        claimed = ", ".join(check.needs.names) or "nothing in particular"
        return CheckResult("failed", f"Unsupported: {error}; the check needs {claimed}, which the engine claims")
    except SettingsError as error:
        return CheckResult("failed", f"SettingsError on the track's own settings: {error}")
    except Exception as error:
        return CheckResult("failed", f"{type(error).__name__}: {error}")


def run_check(adapter: Adapter, track: str, check: ConformanceCheck) -> CheckOutcome:
    """One check on one track; declared failures are strict expectations."""
    finding = _finding(adapter, track, check)
    reason = adapter.known_failures.get(f"{track}/{check.name}")
    status: Status = finding.status
    message = finding.message
    if reason is not None and check.excusable and finding.status == "failed":
        status, message = "known", f"{reason}; {message}"
    elif reason is not None:
        status, but = _UNFIT[finding.status] if check.excusable else ("failed", "this must hold on every track")
        message = f"declared as a known failure ({reason}), but {but}; {message}"
    return as_outcome(adapter.name, track, check, status, message)


def as_outcome(engine: str, track: str, check: ConformanceCheck, status: Status, message: str) -> CheckOutcome:
    """How a check went."""
    return CheckOutcome(engine=engine, track=track, check=check.name, question=check.question, status=status, message=message)


def run_conformance(
    adapter: Adapter, tracks: tuple[str, ...] = ("default", "tuned"), checks: Iterable[ConformanceCheck] = CHECKS
) -> tuple[CheckOutcome, ...]:
    """All checks on the given tracks.

    Raises:
        Unavailable: where the engine is not installed, so that nothing could be asked.
    """
    adapter.version()
    chosen = tuple(checks)
    return tuple(run_check(adapter, track, check) for track in tracks for check in chosen)


def gate(outcomes: Iterable[CheckOutcome]) -> bool:
    """May this adapter be scored? Every outcome is passed, not applicable, or failing as declared; and there is one at all."""
    seen = tuple(outcomes)
    return bool(seen) and all(outcome.status in {"passed", "known", "not_applicable"} for outcome in seen)
