"""The options: which values they may have, and the vendor's."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

from plumbline.harness.adapter import Settings, SettingsError
from plumbline.harness.adapter.checked_options import Between, checked_options
from plumbline.harness.scene import Effect

SOLVERS = ("mujoco", "xpbd")
INTEGRATORS = {"mujoco": ("implicitfast", "euler", "rk4"), "xpbd": ("semi_implicit_euler",)}
"""By solver, the vendor's first."""
ITERATIONS = {"mujoco": 100, "xpbd": 2}
KNOWN: Mapping[str, Sequence[Any] | Between] = {
    "by_scene": (True, False),
    "contacts": ("mujoco", "newton"),
    "multiccd": (True, False),
    "cone": ("pyramidal", "elliptic"),
    "impratio": Between(1e-6, 1e4),
    "rolling_impratio": Between(1e-6, 1e4),
    "noslip_iterations": (0, 1, 2, 5, 10, 20),
    "contact_steps": Between(0.5, 1e4),
    "contact_damping_ratio": Between(0.1, 10.0),
    "contact_impedance": Between(0.001, 0.9999),
    "limit_steps": Between(0.5, 1e4),
    "contact_relaxation": Between(1e-3, 1.0),
    "contact_weighting": (True, False),
    "restitution_iterations": (1, 2, 4, 8, 16),
}
"""by_scene: where the integrator is left open, RK4 of what moves smoothly, and Euler elsewhere. contacts: who finds
those that MuJoCo-Warp solves. multiccd: does it look for up to four of its own in each pair. cone, impratio: of its friction;
rolling_impratio: the second, with the slip correction, where balls alone touch what holds them. noslip_iterations: of that.
contact_steps: the time constant of its contacts in steps, at most the vendor's; contact_damping_ratio, contact_impedance: of
them. limit_steps: of its joint limits. contact_relaxation, contact_weighting: the share of each contact's correction that
XPBD takes, and whether it is divided by the contacts of a body. restitution_iterations: of XPBD."""
_VENDOR: Mapping[str, Mapping[str, Any]] = {
    "mujoco": {
        "by_scene": False,
        "contacts": "mujoco",
        "multiccd": False,
        "cone": "pyramidal",
        "impratio": 1.0,
        "rolling_impratio": None,
        "noslip_iterations": 0,
        "contact_steps": None,
        "contact_damping_ratio": 1.0,
        "contact_impedance": None,
        "limit_steps": None,
    },
    "xpbd": {"contact_relaxation": 0.8, "contact_weighting": True, "restitution_iterations": 2},
}


def resolved_settings(settings: Settings, fits: str, effects: Effect, smooth: bool = False) -> Settings:
    """The settings with the vendor's values where they leave something open. Raises: SettingsError.

    Options of the other solver than that which is used are left out.

    Args: fits: the solver where none is told. smooth: do joints move freely between no stops?
    """
    solver = settings.solver or fits
    integrators = INTEGRATORS.get(solver, ("",))
    integrator = settings.integrator or integrators[0]
    if settings.options.get("by_scene") and settings.integrator is None and solver == "mujoco":
        integrator = "rk4" if Effect.CONTACT not in effects and (smooth or Effect.JOINTS not in effects) else "euler"
    if integrator not in integrators and solver in SOLVERS:
        # An integrator of the other solver that was told without one says nothing here.
        is_chosen = settings.solver is not None or all(integrator not in names for names in INTEGRATORS.values())
        if is_chosen:
            expected = " or ".join(map(repr, integrators))
            raise SettingsError(f"settings: integrator '{integrator}', expected {expected} of solver '{solver}'")
        integrator = integrators[0]
    chosen = checked_options("Newton", replace(settings, integrator=None), KNOWN, integrator, SOLVERS)
    vendor = _VENDOR[solver]
    return replace(
        settings,
        substeps=settings.substeps or 1,
        iterations=settings.iterations or ITERATIONS[solver],
        integrator=integrator,
        solver=solver,
        options={name: value if chosen[name] is None else chosen[name] for name, value in vendor.items()},
    )
