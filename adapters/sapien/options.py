"""The options: which values they may have, and the vendor's."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from typing import Any

from plumbline.adapters.sapien.suited import PARTING, TOUCH, iterations_for, suited
from plumbline.harness.adapter import Settings
from plumbline.harness.adapter.checked_options import Between, checked_options
from plumbline.harness.adapter.reduced_trees import JointTree
from plumbline.harness.scene import Effect, Scene

INTEGRATOR = "semi_implicit_euler"
SOLVERS = ("tgs", "pgs")
ITERATIONS = 10
"""The vendor's solver_position_iterations."""
UNBOUNDED = 1e32
"""A speed [m/s] that stands for none, in PhysX too."""
KNOWN: Mapping[str, Sequence[Any] | Between] = {
    "velocity_iterations": (0, 1, 2, 4, 8, 16, 32),
    "bounce_threshold": Between(1e-6, 1e3),
    "contact_offset": Between(1e-6, 1.0),
    "max_depenetration_velocity": Between(1e-6, UNBOUNDED),
    "sleeping": (True, False),
    "capped": (True, False),
    "damping": ("vendor", "scene"),
    "determinism": (True, False),
    "by_scene": (True, False),
}
"""bounce_threshold [m/s]: the approach below which nothing rebounds. contact_offset [m]: the gap at which contacts begin.
max_depenetration_velocity [m/s]: the most at which bodies inside each other are moved apart. capped: turns at 100 rad/s, rates
of joints at 100, as the vendor has them. damping: 0.05 a second by default, of bodies of which the scene says none, of turns
and of the speed of links too. determinism: does a body's motion not depend on what else is in the scene. by_scene: where solver
and iterations are left open, and that speed and gap under PGS, what suits the scene."""
_VENDOR: Mapping[str, Any] = {
    "velocity_iterations": 1,
    "bounce_threshold": 2.0,
    "contact_offset": 0.01,
    "max_depenetration_velocity": UNBOUNDED,
    "sleeping": True,
    "capped": True,
    "damping": "vendor",
    "determinism": False,
    "by_scene": False,
}


def resolved_settings(settings: Settings, scene: Scene, constrained: bool, trees: Iterable[JointTree] = ()) -> Settings:
    """The settings with the vendor's values where they leave something open. Raises: SettingsError.

    Args: constrained: is a joint not in reduced coordinates? trees: those that are.
    """
    chosen = checked_options("SAPIEN", settings, KNOWN, INTEGRATOR, SOLVERS)
    by_scene = chosen["by_scene"] is True
    solver = settings.solver or (suited(scene, constrained) if by_scene else "tgs")
    left_open = dict(_VENDOR)
    if by_scene and solver == "pgs":
        left_open["max_depenetration_velocity"] = PARTING
        if Effect.RESTITUTION in scene.effects:
            left_open["contact_offset"] = TOUCH
    return replace(
        settings,
        substeps=settings.substeps or 1,
        iterations=settings.iterations or (iterations_for(scene, trees) if by_scene else ITERATIONS),
        integrator=INTEGRATOR,
        solver=solver,
        options={name: left_open[name] if value is None else value for name, value in chosen.items()},
    )
