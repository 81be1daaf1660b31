"""Engine options: what there is, what pybullet starts from, what is asked for and what comes of it."""

import math
from collections.abc import Mapping
from dataclasses import replace
from typing import Any

from plumbline.adapters.bullet.trees import fast_tops
from plumbline.adapters.bullet.vendor import CONTACT_BREAKING, LIFTED, Port, break_contacts_at, silenced
from plumbline.harness.adapter import Settings, SettingsError
from plumbline.harness.adapter.fast_rotors import fast_rotors
from plumbline.harness.scene import Effect, Scene

VENDOR_STEP = 1 / 240
"""The time step [s] that the Quickstart Guide says is best left as it is: solver iterations and ERPs are tuned to it."""
TOP_STEP = 1 / 960
"""The longest (sub)step [s] of a fast top or rotor on `joints` = "scene": a top errs by up to 6 m/s times it at any spin."""
REBOUND_LOSS = 1e-6
"""What a rebound may lose [m/s] by the contact slop: Bullet takes slop/dt from it."""
LEAST_ITERATIONS, MOST_ITERATIONS = 200, 1200
"""Of the solver on `iterations` = "scene"."""
PER_RATIO = 0.6
"""Iterations for each unit of mass ratio. An iteration takes the light body's share of both masses from the error: a stack of
two errs by iterations over ratio alone, by 1.7e-3 of its height at 0.6 and 1/240 s, and may tremble at 0.5."""
OPTIONS: Mapping[str, tuple[type, ...]] = {
    "coordinates": (str,),
    "iterations": (str,),
    "restitution": (str,),
    "damping": (str,),
    "joints": (str,),
    "drives": (str,),
    "longest_step": (int, float),
    "velocity_limit": (int, float),
    "erp": (int, float),
    "contact_erp": (int, float),
    "friction_erp": (int, float),
    "contact_slop": (int, float),
    "cfm": (int, float),
    "restitution_threshold": (int, float),
    "warm_starting": (int, float),
    "contact_breaking": (int, float),
    "split_impulse": (bool,),
    "cone_friction": (bool,),
    "margin": (int, float),
}
ENGINE_PARAMETERS: Mapping[str, str] = {
    "erp": "erp",
    "contact_erp": "contactERP",
    "friction_erp": "frictionERP",
    "contact_slop": "contactSlop",
    "cfm": "globalCFM",
    "restitution_threshold": "restitutionVelocityThreshold",
    "warm_starting": "warmStartingFactor",
}
VENDOR_OPTIONS: Mapping[str, Any] = {
    "coordinates": "multibody",
    "iterations": "vendor",
    "restitution": "vendor",
    "damping": "vendor",
    "joints": "links",
    "drives": "torque",
    "longest_step": LIFTED,
    "velocity_limit": 100.0,
    "erp": 0.2,
    "contact_erp": 0.08,
    "friction_erp": 0.2,
    "contact_slop": 1e-5,
    "cfm": 0.0,
    "restitution_threshold": 0.2,
    "warm_starting": 0.1,
    "contact_breaking": CONTACT_BREAKING,
    "split_impulse": True,
    "cone_friction": True,
    "margin": 0.001,
}
"""What pybullet 3.2.7 starts from: createEmptyDynamicsWorld and btContactSolverInfo of its sources."""
SOLVERS = {"si": "CONSTRAINT_SOLVER_LCP_SI", "dantzig": "CONSTRAINT_SOLVER_LCP_DANTZIG", "pgs": "CONSTRAINT_SOLVER_LCP_PGS"}


def checked(settings: Settings) -> dict[str, Any]:
    """All options, the vendor's where the settings leave them open. Raises: SettingsError."""
    if settings.integrator not in (None, "semi_implicit_euler"):
        raise SettingsError(f"settings: integrator {settings.integrator!r}, expected 'semi_implicit_euler', Bullet's only one")
    if settings.solver is not None and settings.solver not in SOLVERS:
        raise SettingsError(f"settings: solver {settings.solver!r}, expected one of {', '.join(SOLVERS)}")
    for name, value in settings.options.items():
        if name not in OPTIONS:
            raise SettingsError(f"settings: option {name!r} is unknown, expected some of {', '.join(OPTIONS)}")
        if not isinstance(value, OPTIONS[name]) or (isinstance(value, bool) and bool not in OPTIONS[name]):
            raise SettingsError(
                f"settings: option {name} = {value!r}, expected {' or '.join(t.__name__ for t in OPTIONS[name])}"
            )
        if isinstance(value, int | float) and not (math.isfinite(value) and value >= 0):
            raise SettingsError(f"settings: option {name} = {value!r}, expected a finite number of at least 0")
    options = {**VENDOR_OPTIONS, **settings.options}
    if options["longest_step"] == 0:
        raise SettingsError("settings: option longest_step = 0, expected a step above 0 s")
    for name, choices in (
        ("coordinates", ("multibody", "maximal", "scene")),
        ("iterations", ("vendor", "scene")),
        ("damping", ("vendor", "scene")),
        ("restitution", ("vendor", "touching")),
        ("joints", ("links", "constraints", "scene")),
        ("drives", ("torque", "motor")),
    ):
        if options[name] not in choices:
            raise SettingsError(f"settings: option {name} = {options[name]!r}, expected one of {', '.join(choices)}")
    return options


def substeps_of(scene: Scene, settings: Settings, options: Mapping[str, Any]) -> int:
    """What was asked for, or as many as bring the step down to the longest one."""
    if settings.substeps is not None:
        return settings.substeps
    longest: float = options["longest_step"]
    if options["joints"] == "scene" and Effect.JOINTS in scene.effects and (fast_tops(scene) or fast_rotors(scene)):
        longest = min(longest, TOP_STEP)
    # 4 dt longest steps are 4, whatever rounding adds.
    return max(1, math.ceil(settings.dt / longest * (1 - 1e-9)))


def iterations_of(scene: Scene, settings: Settings, options: Mapping[str, Any]) -> int | None:
    """What was asked for, or as many as the masses of free bodies call for that may lie on each other; None: the vendor's."""
    if settings.iterations is not None or options["iterations"] == "vendor":
        return settings.iterations
    joined = {name for joint in scene.joints for name in (joint.parent, joint.child)}
    masses = [body.mass for body in scene.bodies if body.movable and body.collision and body.name not in joined]
    if not masses or Effect.GRAVITY not in scene.effects or Effect.CONTACT not in scene.effects:
        return LEAST_ITERATIONS
    return min(max(LEAST_ITERATIONS, math.ceil(PER_RATIO * max(masses) / min(masses))), MOST_ITERATIONS)


def substep(settings: Settings) -> float:
    """The length of a (sub)step [s]."""
    return settings.dt / (settings.substeps or 1)


def with_slop(settings: Settings, options: Mapping[str, Any]) -> Mapping[str, Any]:
    """Options with as little contact slop as rebounds bear, unless the settings say how much."""
    if "contact_slop" in settings.options:
        return options
    return {**options, "contact_slop": REBOUND_LOSS * substep(settings)}


def set_parameters(port: Port, settings: Settings, options: Mapping[str, Any], touching: bool) -> None:
    """Tell a world its time step and solver.

    Args: touching: do contacts wait until bodies touch? Penetration is then corrected apart from velocity.
    """
    named: dict[str, Any] = {"fixedTimeStep": substep(settings), "numSubSteps": 0}
    named |= {ENGINE_PARAMETERS[name]: value for name, value in settings.options.items() if name in ENGINE_PARAMETERS}
    if settings.iterations is not None:
        named["numSolverIterations"] = settings.iterations
    if settings.tolerance is not None:
        named["solverResidualThreshold"] = settings.tolerance
    if "split_impulse" in settings.options:
        named["useSplitImpulse"] = int(options["split_impulse"])
    if "cone_friction" in settings.options:
        named["enableConeFriction"] = int(options["cone_friction"])
    if touching:
        named |= {"useSplitImpulse": 1, "splitImpulsePenetrationThreshold": 0.0, "contactSlop": options["contact_slop"]}
    if settings.solver is not None:
        named["constraintSolverType"] = getattr(port.bullet, SOLVERS[settings.solver])
    with silenced():
        port.call("setPhysicsEngineParameter", **named)
    break_contacts_at(port, options["contact_breaking"])


def resolved_settings(port: Port, settings: Settings, options: Mapping[str, Any]) -> Settings:
    """What Bullet says of itself, and what was told to it where it keeps silent. Raises: SettingsError."""
    parameters = port.call("getPhysicsEngineParameters")
    substeps = settings.substeps or 1
    if abs(parameters["fixedTimeStep"] * substeps - settings.dt) > 1e-12 * settings.dt:
        raise SettingsError(f"settings: dt {settings.dt} s, but Bullet steps by {parameters['fixedTimeStep'] * substeps} s")
    return replace(
        settings,
        dt=parameters["fixedTimeStep"] * substeps,
        substeps=substeps,
        iterations=parameters["numSolverIterations"],
        integrator="semi_implicit_euler",
        solver=settings.solver or "si",
        tolerance=1e-7 if settings.tolerance is None else settings.tolerance,
        options=dict(options),
    )
