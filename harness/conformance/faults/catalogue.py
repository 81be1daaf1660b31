"""Planted faults: engines broken in exactly one way each, which the checks must catch and name."""

from harness.conformance.faults.control import Control
from harness.conformance.faults.controls_along_coordinates import COORDINATE_CONTROLS
from harness.conformance.faults.controls_of_contact import CONTACT_CONTROLS
from harness.conformance.faults.controls_of_contract import CONTRACT_CONTROLS
from harness.conformance.faults.controls_of_joints import JOINT_CONTROLS
from harness.conformance.faults.controls_of_motion import MOTION_CONTROLS
from harness.conformance.faults.controls_of_sensing import SENSING_CONTROLS

__all__ = ["CONTROLS"]

CONTROLS: tuple[Control, ...] = (
    *MOTION_CONTROLS,
    *CONTACT_CONTROLS,
    *JOINT_CONTROLS,
    *COORDINATE_CONTROLS,
    *SENSING_CONTROLS,
    *CONTRACT_CONTROLS,
)
"""Every planted fault."""
