"""Planted faults on engines that are installed when they are asked for: the checks that the control names see them too."""

from typing import Any

import pytest

from plumbline.harness.conformance import CHECKS, run_check
from tests.conformance.engines import NAMES, adapter, outcome_of, why_unavailable
from tests.planted_faults import FAULTS, Fault

EXTRAS = tuple(name for name in NAMES if adapter(name).extra is not None)
CHECK = {check.name: check for check in CHECKS}


UNSEEN = {
    ("rapier", "damping_of_1e-5_a_second"): "1e-5 a second at 1/240 s is less than half of the last digit of single precision"
}


def _pairs() -> list[Any]:
    """Faults that can show on an engine: it claims what they need and passes each of their checks on 'tuned'."""
    return [
        pytest.param(
            name, fault, marks=pytest.mark.xfail(reason=UNSEEN[name, fault.name]) if (name, fault.name) in UNSEEN else ()
        )
        for name in EXTRAS
        for fault in FAULTS
        if not fault.on_trajectory
        and fault.needs in adapter(name).features
        and all(CHECK[check].needs in adapter(name).features for check in fault.seen_by)
        and not {f"tuned/{check}" for check in fault.seen_by} & set(adapter(name).known_failures)
    ]


@pytest.mark.slow
@pytest.mark.parametrize(("engine", "fault"), _pairs(), ids=lambda value: getattr(value, "name", value))
def test_a_planted_fault_is_named_on_an_engine_of_its_own_environment(engine: str, fault: Fault) -> None:
    if reason := why_unavailable(engine):
        pytest.skip(reason)
    sound = {check: outcome_of(engine, "tuned", check) for check in fault.seen_by}
    asked = [check for check, outcome in sound.items() if outcome.status != "not_applicable"]
    if not asked:
        pytest.skip(f"{engine} refuses by name what {fault.name} needs")
    assert {sound[check].status for check in asked} == {"passed"}
    missed = [check for check in asked if run_check(fault.plant(adapter(engine)), "tuned", CHECK[check]).status != "failed"]
    assert not missed, f"{fault.words} on {engine} went unnoticed by {missed}"
