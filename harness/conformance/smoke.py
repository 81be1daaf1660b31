"""Does an adapter carry the engine that is installed here? `python -m harness.conformance.smoke ENGINE OUT` says why not.

What it writes is JSON: the version, the reason why the engine is unavailable ('' where it is not), and where Python looks for
modules. A dozen checks of the kit are put to it, a few seconds in all, one or two of each subject; the whole kit is
`plumbline check`.
"""

import json
import sys
from pathlib import Path

from plumbline.harness.conformance.catalogue import CHECKS
from plumbline.harness.conformance.outcomes import run_check
from plumbline.harness.study import plugins

SMOKE = (
    "resolved_settings_are_complete",
    "initial_state_comes_back",
    "quaternion_is_wxyz",
    "angular_velocity_is_in_W",
    "free_fall_has_the_size_and_sign_of_g",
    "step_advances_exactly_dt",
    "box_rests_on_plane",
    "contact_forces_carry_the_weight",
    "friction_has_its_size",
    "joint_pendulum_period",
    "drive_reaches_its_target",
    "nan_is_reported",
    "same_input_same_hash",
)
"""The checks that an engine has to pass before it is run: what it says must be readable at all."""


def smoke(engine: str) -> tuple[str, str]:
    """The version of an engine, and why it is unavailable: '' where it is not. A declared failure that passes is none."""
    adapter = plugins.adapter(engine)
    version, reason = plugins.version_of(adapter)
    if reason is not None:
        return "", reason
    for check in (check for check in CHECKS if check.name in SMOKE):
        for track in adapter.tracks:
            outcome = run_check(adapter, track, check)
            if outcome.status == "failed":
                return version, f"the adapter does not carry {version}: {check.name} on {track}: {outcome.message}"
    return version, ""


if __name__ == "__main__":
    found, why = smoke(sys.argv[1])
    Path(sys.argv[2]).write_text(json.dumps({"version": found, "reason": why, "path": sys.path}), encoding="utf-8")
