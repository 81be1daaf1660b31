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
    robustness,
    sensing,
    shapes,
)
from harness.conformance.check import ConformanceCheck

__all__ = ["CHECKS"]

CHECKS: tuple[ConformanceCheck, ...] = (
    *contract.CHECKS,
    *features.CHECKS,
    *frames.CHECKS,
    *dynamics.CHECKS,
    *shapes.CHECKS,
    *contact.CHECKS,
    *friction.CHECKS,
    *joints.CHECKS,
    *sensing.CHECKS,
    *effects.CHECKS,
    *robustness.CHECKS,
)
"""Every check; names are stable identifiers."""
