"""The list of all checks, in the order in which they are run and shown."""

from harness.conformance import (
    balance,
    compounds,
    contact,
    contract,
    door,
    drives,
    dynamics,
    effects,
    features,
    frames,
    friction,
    inertial,
    joints,
    memory,
    pairs,
    precision,
    present,
    resting,
    robustness,
    sensing,
    shapes,
    stepping,
)
from harness.conformance.check import ConformanceCheck
from harness.conformance.declarations import declarations_check

__all__ = ["CHECKS"]

_ASKED: tuple[ConformanceCheck, ...] = (
    *contract.CHECKS,
    *door.CHECKS,
    *features.CHECKS,
    *frames.CHECKS,
    *dynamics.CHECKS,
    *stepping.CHECKS,
    *precision.CHECKS,
    *shapes.CHECKS,
    *compounds.CHECKS,
    *resting.CHECKS,
    *contact.CHECKS,
    *pairs.CHECKS,
    *balance.CHECKS,
    *friction.CHECKS,
    *joints.CHECKS,
    *drives.CHECKS,
    *sensing.CHECKS,
    *present.CHECKS,
    *inertial.CHECKS,
    *effects.CHECKS,
    *robustness.CHECKS,
    *memory.CHECKS,
)

CHECKS: tuple[ConformanceCheck, ...] = (declarations_check(_ASKED), *_ASKED)
"""Every check; names are stable identifiers."""
