"""All checks, in the order in which they are run and shown."""

from importlib import import_module

from plumbline.harness.conformance import check

SUBJECTS = (
    "contract.protocol", "contract.features",
    "motion.frames", "motion.dynamics", "motion.precision", "motion.mass_points",
    "contact.shapes", "contact.compounds", "contact.resting", "contact.contacts",
    "motion.prescribed", "contact.forces", "contact.friction",
    "joints.constraints", "joints.coordinates", "joints.distance_springs", "joints.along_coordinates", "joints.tendons",
    "joints.joint_states", "joints.pairs",
    "sensing.rays", "sensing.images", "sensing.inertial", "sensing.mounted", "sensing.mounted_cameras",
    "contract.effects", "contract.robustness",
)  # fmt: skip
"""The files of checks in the order of a reader: what is declared, how a body moves, touches, is joined and is seen."""

for subject in SUBJECTS:
    import_module(f"plumbline.harness.conformance.checks.{subject}")

CHECKS = tuple(check.CHECKS)
"""Every check; names are stable identifiers."""
NAMED = {check.name: check for check in CHECKS}
