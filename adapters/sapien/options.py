"""The options: which values they may have, and the vendor's."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

from plumbline.harness.adapter import Settings
from plumbline.harness.adapter.checked_options import Between, checked_options
from plumbline.harness.scene import Effect

INTEGRATOR = "semi_implicit_euler"
SOLVERS = ("tgs", "pgs")
ITERATIONS = 10
"""The vendor's solver_position_iterations."""
KNOWN: Mapping[str, Sequence[Any] | Between] = {
    "velocity_iterations": (0, 1, 2, 4, 8, 16, 32),
    "bounce_threshold": Between(1e-6, 1e3),
    "contact_offset": Between(1e-6, 1.0),
    "sleeping": (True, False),
    "capped": (True, False),
    "damping": ("vendor", "scene"),
    "determinism": (True, False),
    "by_scene": (True, False),
}
"""bounce_threshold [m/s]: the approach below which nothing rebounds. contact_offset [m]: the gap at which contacts begin.
capped: turns at 100 rad/s, rates of joints at 100, as the vendor has them. damping: angular, 0.05 a second by default, of
bodies of which the scene says none. determinism: does a body's motion not depend on what else is in the scene. by_scene:
where the solver is left open, TGS where something rebounds, has torsional friction, hangs on a body that is led, or touches
while it moves at the start without drives, and PGS elsewhere."""
_VENDOR: Mapping[str, Any] = {
    "velocity_iterations": 1,
    "bounce_threshold": 2.0,
    "contact_offset": 0.01,
    "sleeping": True,
    "capped": True,
    "damping": "vendor",
    "determinism": False,
    "by_scene": False,
}


def resolved_settings(settings: Settings, effects: Effect, moving: bool) -> Settings:
    """The settings with the vendor's values where they leave something open. Raises: SettingsError.

    Args: moving: does a joint hold something on a body that is led, or does what touches move without a drive?
    """
    chosen = checked_options("SAPIEN", settings, KNOWN, INTEGRATOR, SOLVERS)
    options = {name: _VENDOR[name] if value is None else value for name, value in chosen.items()}
    moved = Effect.RESTITUTION | Effect.TORSIONAL_FRICTION
    quiet = options["by_scene"] and not moved & effects and not moving
    return replace(
        settings,
        substeps=settings.substeps or 1,
        iterations=settings.iterations or ITERATIONS,
        integrator=INTEGRATOR,
        solver=settings.solver or ("pgs" if quiet else "tgs"),
        options=options,
    )
