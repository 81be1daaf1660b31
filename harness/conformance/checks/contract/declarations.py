"""The check of what an adapter declares about itself: tracks, names, and failures that may be excused."""

from collections.abc import Sequence
from functools import partial

from harness.adapter import Adapter, Settings
from harness.conformance.check import ConformanceCheck, Finding, judge, that

__all__ = ["declarations_check"]


def _well_formed(checks: Sequence[ConformanceCheck], adapter: Adapter, _settings: Settings) -> Finding:
    known = {f"{track}/{check.name}" for track in adapter.tracks for check in checks}
    firm = {f"{track}/{check.name}" for track in adapter.tracks for check in checks if not check.excusable}
    declared = set(adapter.known_failures)
    return judge(
        that({"default", "tuned"} <= set(adapter.tracks), f"tracks: got {sorted(adapter.tracks)}, expected default and tuned"),
        that(declared <= known, f"known_failures names no check: {sorted(declared - known)}"),
        that(not declared & firm, f"known_failures excuses what must hold on every track: {sorted(declared & firm)}"),
        that(
            all(reason.strip() for reason in adapter.known_failures.values()),
            f"known_failures without a reason: {sorted(k for k, v in adapter.known_failures.items() if not v.strip())}",
        ),
        that(bool(adapter.name and adapter.title and adapter.distribution), "name, title and distribution are given"),
    )


def declarations_check(checks: Sequence[ConformanceCheck]) -> ConformanceCheck:
    """The check that every declared failure names one of `checks` that may be excused."""
    return ConformanceCheck(
        name="declarations_are_well_formed",
        question="Are both tracks there, and does every declared failure name a check that may be excused, with a reason?",
        run=partial(_well_formed, tuple(checks)),
        excusable=False,
    )
