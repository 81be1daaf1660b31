"""The options: which values they may have, and what they tell a world."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

from plumbline.harness.adapter import Settings
from plumbline.harness.adapter.checked_options import Between, checked_options
from plumbline.harness.scene import Effect

INTEGRATOR = "semi_implicit_euler"
SOLVER = "tgs_soft"
FRICTION = ("simplified", "coulomb")
JOINTS = ("impulse", "multibody")
KNOWN: Mapping[str, Sequence[Any] | Between] = {
    "sleeping": (True, False),
    "friction_model": FRICTION,
    "friction_in_bias": (True, False),
    "contact_rate": Between(1e-3, 1.0),
    "contact_damping_ratio": Between(0.1, 100.0),
    "recycling": (True, False),
    "clustering": (True, False),
    "capped": (True, False),
    "soft_ccd": (True, False),
    "inner_edges": (True, False),
    "joints": JOINTS,
    "on_path": (True, False),
    "by_scene": (True, False),
    "detect_every": (0, 1, 2, 3, 4),
    "prediction": Between(1e-6, 1.0),
}
"""sleeping: do bodies sleep. friction_in_bias: is friction solved in the pass of each sub-step that corrects positions too.
contact_rate: natural frequency of contacts over the rate of sub-steps; contact_damping_ratio: theirs, where that is told.
recycling, clustering: of contact points. capped: speeds at 400 m/s, turns at 45 degrees a step, as the vendor has them.
soft_ccd: predict contacts as far as a body moves in a step, where the scene calls for continuous collision. inner_edges: do the
inner edges of meshes push bodies that slide over them. joints: as constraints between free bodies, or trees of them in reduced
coordinates. on_path: are bodies that are led put back on their path before each step. by_scene: where the settings leave them
open, BUSY sub-steps in scenes with contacts or joints, and a contact_rate. detect_every: sub-steps of a step of the vendor's,
which finds contacts anew; all of them with 0, and where they cannot be shared out so. prediction: the gap [m] from which
contacts are foreseen."""
_VENDOR: Mapping[str, Any] = {
    "sleeping": True,
    "friction_model": "simplified",
    "friction_in_bias": False,
    "contact_damping_ratio": 10.0,
    "recycling": True,
    "clustering": True,
    "capped": True,
    "soft_ccd": False,
    "inner_edges": True,
    "joints": "impulse",
    "on_path": False,
    "by_scene": False,
    "detect_every": 0,
    "prediction": 0.02,
}
SUBSTEPS, ITERATIONS = 4, 1
"""The vendor's num_solver_iterations, each of which is a sub-step, and num_internal_pgs_iterations of each."""
BUSY = 12
"""Sub-steps where something has to be solved. A free body has its rounding from each: 7 times the error of 4 at 1/480 s."""
_UNCAPPED = 1e20
"""A speed [m/s] that nothing reaches."""


def resolved_settings(settings: Settings, effects: Effect) -> Settings:
    """The settings with the vendor's values where they leave something open. Raises: SettingsError."""
    parameters = checked_options("Rapier", settings, KNOWN, INTEGRATOR, (SOLVER,))
    options = {name: _VENDOR.get(name) if value is None else value for name, value in parameters.items()}
    busy = options["by_scene"] and (Effect.CONTACT | Effect.JOINTS) & effects
    if options["by_scene"] and parameters["contact_rate"] is None:
        # At a quarter an arch of hulls trembles; at an eighth a robot that is hit goes astray by ten times as much.
        options["contact_rate"] = 0.25 if (Effect.CONTACT | Effect.DRIVES) in effects else 0.125
    return replace(
        settings,
        substeps=settings.substeps or (BUSY if busy else SUBSTEPS),
        iterations=settings.iterations or ITERATIONS,
        integrator=INTEGRATOR,
        solver=SOLVER,
        options={name: value for name, value in options.items() if value is not None},
    )


def vendor_steps(used: Settings) -> int:
    """Of the vendor in a time step: as often are contacts found."""
    substeps, every = used.substeps or 1, used.options["detect_every"]
    return substeps // every if every and substeps % every == 0 else 1


def set_parameters(rapier: Any, world: Any, used: Settings) -> None:
    """Tell a world what it is to use."""
    parameters, options, steps = world.integration_parameters, used.options, vendor_steps(used)
    assert used.substeps is not None
    parameters.dt = used.dt / steps
    parameters.num_solver_iterations, parameters.num_internal_pgs_iterations = used.substeps // steps, used.iterations
    parameters.normalized_prediction_distance = options["prediction"]
    parameters.friction_model = getattr(rapier.FrictionModel, options["friction_model"].upper())
    parameters.friction_in_bias_pass = options["friction_in_bias"]
    parameters.contact_recycling, parameters.contact_clustering = options["recycling"], options["clustering"]
    if "contact_rate" in options:
        spring = rapier.SpringCoefficients(options["contact_rate"] / used.substep, options["contact_damping_ratio"])
        parameters.contact_softness = parameters.static_contact_softness = spring
    if not options["capped"]:
        parameters.normalized_max_linear_velocity = _UNCAPPED
