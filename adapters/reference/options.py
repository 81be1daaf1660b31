"""Engine options: what there is, what is asked for and what comes of it."""

from collections.abc import Mapping
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from plumbline.harness.adapter import Settings, SettingsError
from plumbline.harness.adapter.settings import BITS, OF_ONE_MACHINE
from plumbline.harness.scene import Effect, Scene

if TYPE_CHECKING:
    from plumbline import engine

__all__ = [
    "EULER",
    "EXACT",
    "SEQUENTIAL",
    "SOFT",
    "SOFT_OPTIONS",
    "SUITED",
    "SWEEPS",
    "UNSET",
    "UNSUBSTEPPED",
    "WHOLE_STEPS",
    "engine_options",
    "resolved_settings",
    "steps_in",
]

SOFT = "tgs_soft"
EXACT = "exact"
SEQUENTIAL = "sequential_impulses"
EULER = "semi_implicit_euler"
SUITED = "suited"
"""Not a solver but the choice of one by the scene: exact contacts for few bodies of very unlike masses or under which springs
give way, sequential impulses for bodies that start inside each other, else soft contacts."""
OPTIONS: Mapping[str, type] = {
    "steps": int,
    "relaxations": int,
    "step_tolerance": float,
    "broad_phase": str,
    "continuous": str,
    "bounding_volume": str,
    "level_of_detail": str,
    "threads": int,
    "sweeps": str,
    "contact_hertz": float,
    "contact_damping_ratio": float,
    "max_push": float,
    "bounce_speed": float,
    "margin": float,
    "sleeping": bool,
    "sleep_speed": float,
    "sleep_time": float,
    "coordinates": str,
    "effort": float,
    BITS: str,
}

WHOLE_STEPS = "steps"
"""An option of the adapter's own: the steps of the engine that make one dt, a divisor of its sub-steps. Each finds contacts
anew, as sub-steps do not, and divides what Runge-Kutta would take whole."""
LEFT_OUT = 1e-8
"""Share of a sub-step's way that semi-implicit Euler may leave out in joint coordinates: what its first order errs by, h times
the angular velocities, is larger at any step above a microsecond."""
UNSUBSTEPPED, SWEEPS = 4, 2
"""Sub-steps of the soft solver, and sweeps of each, where the settings leave them open and no tree of joints touches
anything."""
CONTINUOUS = ("speculative", "swept")
"""What the effect of continuous collision may mean; the first unless set."""
SOFT_OPTIONS = (
    "relaxations", "sweeps", "contact_hertz", "contact_damping_ratio", "max_push", "sleeping", "sleep_speed", "sleep_time",
)  # fmt: skip
"""Options of the soft solver alone."""
EXACT_OPTIONS = ("effort", BITS)
"""Options of the exact solver alone; the last is a promise, which nobody can change."""
UNSET: Mapping[str, Mapping[str, Any]] = {SOFT: {}, EXACT: {"substeps": 1}, SEQUENTIAL: {"substeps": 1, "iterations": 10}}
"""What a solver takes where the settings leave it open; ten sweeps are Bullet's default as well."""


def engine_options(scene: Scene, settings: Settings) -> "engine.Options":
    """The engine's options for a solver of its own, under the effects of the scene. Raises: SettingsError."""
    from plumbline import engine

    solver = settings.solver or SOFT
    if solver not in UNSET:
        raise SettingsError(f"settings: solver '{solver}', expected one of {', '.join((*UNSET, SUITED))}")
    exact = solver == EXACT
    if settings.tolerance is not None and not exact:
        raise SettingsError(f"settings: tolerance {settings.tolerance}, but the solver sweeps a fixed number of times")
    if settings.iterations is not None and exact:
        raise SettingsError(f"settings: iterations {settings.iterations}, but '{EXACT}' goes on until its tolerance is met")
    chosen: dict[str, Any] = {"dt": settings.dt, "solver": solver, "continuous": CONTINUOUS[0], **UNSET[solver]}
    if settings.tolerance is not None:
        chosen["tolerance"] = settings.tolerance
    for name in ("substeps", "iterations", "integrator"):
        if getattr(settings, name) is not None:
            chosen[name] = getattr(settings, name)
    for name, value in settings.options.items():
        kind = OPTIONS.get(name)
        if kind is None:
            raise SettingsError(f"settings: option '{name}' is unknown, expected one of {', '.join(OPTIONS)}")
        if solver != SOFT and name in SOFT_OPTIONS:
            raise SettingsError(f"settings: option '{name}' belongs to the solver '{SOFT}', '{solver}' has no use for it")
        if not exact and name in EXACT_OPTIONS:
            raise SettingsError(f"settings: option '{name}' belongs to the solver '{EXACT}', '{solver}' has no use for it")
        if isinstance(value, bool) != (kind is bool) or not isinstance(value, (int, float) if kind is float else kind):
            raise SettingsError(f"settings: option '{name}' is {value!r}, expected {kind.__name__}")
        chosen[name] = value
    if (promised := chosen.pop(BITS, OF_ONE_MACHINE)) != OF_ONE_MACHINE:
        raise SettingsError(f"settings: option '{BITS}' is {promised!r}, expected {OF_ONE_MACHINE!r}")
    if chosen.get("integrator", EULER) == EULER:
        chosen.setdefault("step_tolerance", LEFT_OUT)
    steps, substeps = chosen.pop(WHOLE_STEPS, 1), chosen.get("substeps", UNSUBSTEPPED)
    if steps < 1 or substeps % steps:
        raise SettingsError(f"settings: option '{WHOLE_STEPS}' is {steps}, expected a divisor of the {substeps} sub-steps")
    chosen["dt"], chosen["substeps"] = settings.dt / steps, substeps // steps
    effects = scene.effects
    if chosen["continuous"] not in CONTINUOUS:
        raise SettingsError(f"settings: option 'continuous' is {chosen['continuous']!r}, expected {' or '.join(CONTINUOUS)}")
    if Effect.CONTINUOUS_COLLISION not in effects:
        chosen["continuous"] = "off"
    try:
        return engine.Options(
            **chosen,
            contacts=Effect.CONTACT in effects,
            gyroscopic=Effect.GYROSCOPIC in effects,
        )
    except ValueError as error:
        raise SettingsError(str(error)) from error


def steps_in(settings: Settings, used: "engine.Options") -> int:
    """How many steps of the engine make one dt."""
    return round(settings.dt / used.dt)


def resolved_settings(settings: Settings, used: "engine.Options", world: "engine.World") -> Settings:
    """What the engine uses, defaults filled in."""
    soft, exact = used.solver == SOFT, used.solver == EXACT
    others = (() if soft else SOFT_OPTIONS) + (() if exact else EXACT_OPTIONS)
    filled = {name: getattr(used, name) for name in OPTIONS if name not in (*others, WHOLE_STEPS, BITS)}
    steps = steps_in(settings, used)
    filled[WHOLE_STEPS] = steps if steps > 1 else None
    filled["broad_phase"] = world.broad_phase
    if soft:
        stiffest = replace(used, substeps=world.substeps).stiffest_hertz
        filled["contact_hertz"] = min(stiffest, used.contact_hertz or stiffest)
    filled["step_tolerance"] = used.used_step_tolerance if used.integrator != EULER or world.in_joint_coordinates else None
    if soft and not used.sleeping:
        del filled["sleep_speed"], filled["sleep_time"]
    filled["coordinates"] = "joint" if world.in_joint_coordinates else None
    filled[BITS] = OF_ONE_MACHINE if exact else None
    if used.continuous == "off":
        del filled["continuous"]
    return replace(
        settings,
        substeps=world.substeps * steps,
        iterations=None if exact else used.iterations,
        integrator=used.integrator,
        solver=used.solver,
        tolerance=used.tolerance if exact else None,
        options={name: value for name, value in filled.items() if value is not None},
    )
