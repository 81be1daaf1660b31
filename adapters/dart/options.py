"""The options: which values they may have."""

from typing import Any

from plumbline.adapters.dart.detectors import DETECTORS
from plumbline.adapters.dart.solvers import SOLVERS
from plumbline.harness.adapter import Settings, SettingsError

INTEGRATOR = "semi_implicit_euler"
DRIVES = ("spring", "stable", "servo")
"""How springs and drives act: as DART's joint springs, or as torques of the velocity foreseen for the end of the step; or,
drives alone, by DART's own motor, which holds a velocity."""
JOINTS = ("constraints", "coordinates")
"""How a tree holds together: where DART has one for the joint, by constraints on free bodies, or by joints' coordinates.

In this order, since a search that stands at 'auto' turns to the first, and 'auto' mostly is the second.
"""


def validated(settings: Settings) -> dict[str, Any]:
    """The options with their defaults. Raises: SettingsError."""
    known = {
        "detector": (None, "auto", *DETECTORS),
        "deactivation": (None, True, False),
        "split_impulse": (None, True, False),
        "drives": (None, "auto", *DRIVES),
        "joints": (None, "auto", *JOINTS),
    }
    share = settings.options.get("error_reduction")
    if share is not None and not (type(share) in (int, float) and 0 <= share <= 1):
        raise SettingsError(f"settings: option 'error_reduction' {share!r}, expected a share of an error, 0..1")
    for name, value in settings.options.items():
        if name == "error_reduction":
            continue
        if name not in known:
            raise SettingsError(
                f"settings: option '{name}' is unknown to dart, expected some of {', '.join(known)}, error_reduction"
            )
        allowed = known[name]
        if not any(value is choice or (isinstance(choice, str) and value == choice) for choice in allowed):
            raise SettingsError(f"settings: option '{name}' {value!r}, expected one of {allowed}")
    if settings.integrator not in (None, INTEGRATOR):
        raise SettingsError(f"settings: integrator '{settings.integrator}', expected '{INTEGRATOR}', the only one of dart")
    if settings.solver not in (None, "auto", *SOLVERS):
        raise SettingsError(f"settings: solver '{settings.solver}', expected one of auto, {', '.join(SOLVERS)}")
    if settings.solver in (None, "dantzig") and (settings.iterations is not None or settings.tolerance is not None):
        raise SettingsError("settings: iterations or tolerance; dantzig pivots to the exact solution, expected neither")
    return {name: settings.options.get(name) for name in (*known, "error_reduction")}
