"""The conformance kit: what every adapter, built in or third-party, must answer rightly before it is scored.

`plumbline check ENGINE` runs it. A third party puts its adapter into the entry-point group `plumbline.adapters` and tests it by

    import pytest

    from plumbline.harness.conformance import CHECKS, run_check
    from my_engine.plumbline import ADAPTER


    @pytest.mark.parametrize("track", ["default", "tuned"])
    @pytest.mark.parametrize("check", CHECKS, ids=lambda check: check.name)
    def test_my_engine_conforms(track, check):
        outcome = run_check(ADAPTER, track, check)
        if outcome.status == "not_applicable":
            pytest.skip(outcome.message)
        if outcome.status == "known":
            pytest.xfail(outcome.message)
        assert outcome.status == "passed", outcome.message

A feature that the adapter does not claim makes the checks that need it not applicable, provided that the engine refuses it by
`Unsupported`. What a vendor's defaults do to the physics is declared in `Adapter.known_failures` and must then really fail.
"""

from plumbline.harness.conformance.catalogue import CHECKS
from plumbline.harness.conformance.check import CheckResult, ConformanceCheck
from plumbline.harness.conformance.checks.sensing.inertial import noise_axes_are_independent
from plumbline.harness.conformance.outcomes import CheckOutcome, gate, run_check, run_conformance

__all__ = [
    "CHECKS",
    "ConformanceCheck",
    "CheckResult",
    "CheckOutcome",
    "gate",
    "noise_axes_are_independent",
    "run_check",
    "run_conformance",
]
