"""All checks, in the order in which they are run and shown."""

from importlib import import_module

from harness.conformance import check

_SUBJECTS = (
    *("contract.protocol", "contract.arguments", "contract.features"),
    *("motion.frames", "motion.dynamics", "motion.stepping", "motion.precision", "motion.mass_points"),
    *("contact.shapes", "contact.compounds", "contact.resting", "contact.rocking", "contact.contacts"),
    *("motion.prescribed", "contact.pairs", "contact.balance", "contact.friction"),
    *("joints.constraints", "joints.coordinates", "joints.distance_springs", "joints.drives", "joints.along_coordinates"),
    *("joints.joint_states", "joints.reactions"),
    *("sensing.rays", "sensing.images", "sensing.present", "sensing.inertial"),
    *("contract.effects", "contract.robustness", "contract.saves"),
)
"""The files of checks in the order of a reader: what is declared, how a body moves, touches, is joined and is seen."""

for subject in _SUBJECTS:
    import_module(f"harness.conformance.checks.{subject}")

CHECKS = tuple(check.CHECKS)
"""Every check; names are stable identifiers."""
