"""The list of all checks, in the order in which they are run and shown."""

from harness.conformance import (
    contact,
    contract,
    dynamics,
    effects,
    features,
    frames,
    friction,
    joints,
    resting,
    robustness,
    sensing,
    shapes,
)
from harness.conformance.check import ConformanceCheck
from harness.conformance.declarations import declarations_check

__all__ = ["CHECKS"]

_ASKED: tuple[ConformanceCheck, ...] = (
    *contract.CHECKS,
    *features.CHECKS,
    *frames.CHECKS,
    *dynamics.CHECKS,
    *shapes.CHECKS,
    *resting.CHECKS,
    *contact.CHECKS,
    *friction.CHECKS,
    *joints.CHECKS,
    *sensing.CHECKS,
    *effects.CHECKS,
    *robustness.CHECKS,
)

CHECKS: tuple[ConformanceCheck, ...] = (declarations_check(_ASKED), *_ASKED)
"""Every check; names are stable identifiers."""
