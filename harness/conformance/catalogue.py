"""The list of all checks, in the order in which they are run and shown."""

from harness.conformance.check import ConformanceCheck
from harness.conformance.checks.contact import balance, compounds, contacts, friction, pairs, resting, rocking, shapes
from harness.conformance.checks.contract import arguments, effects, features, protocol, robustness, saves
from harness.conformance.checks.contract.declarations import declarations_check
from harness.conformance.checks.joints import (
    along_coordinates,
    constraints,
    coordinates,
    distance_springs,
    drives,
    joint_states,
    reactions,
)
from harness.conformance.checks.motion import dynamics, frames, mass_points, precision, prescribed, stepping
from harness.conformance.checks.sensing import images, inertial, present, rays

__all__ = ["CHECKS"]

_ASKED: tuple[ConformanceCheck, ...] = (
    *protocol.CHECKS,
    *arguments.CHECKS,
    *features.CHECKS,
    *frames.CHECKS,
    *dynamics.CHECKS,
    *stepping.CHECKS,
    *precision.CHECKS,
    *mass_points.CHECKS,
    *shapes.CHECKS,
    *compounds.CHECKS,
    *resting.CHECKS,
    *rocking.CHECKS,
    *contacts.CHECKS,
    *prescribed.CHECKS,
    *pairs.CHECKS,
    *balance.CHECKS,
    *friction.CHECKS,
    *constraints.CHECKS,
    *coordinates.CHECKS,
    *distance_springs.CHECKS,
    *drives.CHECKS,
    *along_coordinates.CHECKS,
    *joint_states.CHECKS,
    *reactions.CHECKS,
    *rays.CHECKS,
    *images.CHECKS,
    *present.CHECKS,
    *inertial.CHECKS,
    *effects.CHECKS,
    *robustness.CHECKS,
    *saves.CHECKS,
)

CHECKS: tuple[ConformanceCheck, ...] = (declarations_check(_ASKED), *_ASKED)
"""Every check; names are stable identifiers."""
