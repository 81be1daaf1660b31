"""The solver for a scene, as the track 'tuned' chooses it."""

from dataclasses import replace
from math import ceil, sqrt
from typing import TYPE_CHECKING

from plumbline.adapters.reference.options import (
    EULER,
    EXACT,
    SEQUENTIAL,
    SOFT,
    SOFT_OPTIONS,
    SWEEPS,
    UNSET,
    UNSUBSTEPPED,
    WHOLE_STEPS,
    engine_options,
)
from plumbline.adapters.reference.scene_estimates import (
    half_width,
    heap_gives_way,
    length,
    mass_ratio,
    quickest_turn,
    way_through,
)
from plumbline.adapters.reference.world import make_world
from plumbline.harness.adapter import Settings, Unsupported
from plumbline.harness.scene import Effect, Scene

if TYPE_CHECKING:
    from plumbline import engine

__all__ = ["on_feet", "suited"]

DEEP = 0.05
"""Share of the half width of the thinner body [1] beyond which an overlap at the start is worked off by `SEQUENTIAL`."""
FEW = 16
"""Movable bodies up to which `SUITED` takes exact contacts: their cost grows with the cube of the number of contacts."""
ROUNDED = 1e-15
"""Least tolerance of exact contacts over the ratio of masses: impulses are known to rounding of the heaviest load, and
residuals are relative to the light body's; for two boxes of 100 : 1 to 1e6 : 1 the least are 2e-16 to 6e-16 of the ratio."""
MERGED = 8
"""Sub-steps that are taken as one where trees of joints, in joint coordinates, may touch something."""
TURNING = sqrt(2.0)
"""Turn in a step [rad] up to which Runge-Kutta is trusted: half of 2 sqrt(2), where its region of stability ends."""
FAR = 1.0
"""Turn in a step [rad] from which implicit midpoint is taken: at 1.04 a heavy top's precession errs by 2.0e-5 of its rate, and
by 5.3e-4 under Runge-Kutta, at .52 by 1.9e-5 and 3.5e-5, for some 3.8 and 2.5 times the time of a step."""


def suited(scene: Scene, settings: Settings) -> "tuple[Settings, engine.World | None]":
    """The settings with the solver that suits the scene, and a world under them at its start, where one was made to see.

    Unlike masses: a soft contact of a body of mass m is a spring of stiffness m w^2, w h = pi/2 in each of n sub-steps h of
    dt. Under a body r times heavier it gives by r g/w^2 = 4 r/(pi n)^2 g dt^2, and Gauss-Seidel sweeps need the more steps to
    load it the larger r is. Up to r = n^2 that is less than half of g dt^2, one step of falling; above, contacts are exact.

    Soft springs: where a step is long or gravity strong they give way under what rests on them, and a tower topples
    (`heap_gives_way`); there too contacts are exact.

    Whole steps: sub-steps divide the response to contacts alone. Where a body turns farther in dt than Runge-Kutta is trusted
    with, or without continuous collision goes through what it may meet, each sub-step is made a step of its own.

    Where joints turn it farther than `FAR` in each of these steps: implicit midpoint, which keeps the angular momentum that
    nothing changes, and so does not lose a top that spins 5 rad a step.

    Dry friction and limits of speed in joints are not smooth: Runge-Kutta does not know them, semi-implicit Euler does, and
    tendons alike.

    Trees of joints: the track asks for joint coordinates, in which semi-implicit Euler is the same motion and Runge-Kutta one
    of the same order, at a fraction of the time (docs/decisions/0020 says where its constants are larger).

    Trees of joints that touch something: `on_feet`. At half of the time stands err from a quarter to five times as much as in
    four sub-steps of two (docs/decisions/0022).

    Bodies inside each other: a spring gives them the speed of its push, which relaxing sweeps take away in part only.
    Sequential impulses correct positions apart from velocities; they leave a tenth of the margin as it is, which is made
    g dt^2 here.
    """
    effects = scene.effects
    laws = ("friction_loss", "speed_limit")
    unsmooth = any(getattr(joint, law, None) for joint in scene.joints for law in laws)
    if settings.integrator == "rk4" and (unsmooth or scene.tendons):
        settings = replace(settings, integrator=EULER)
    springs = replace(settings, solver=SOFT)
    if settings.integrator in ("rk4", EULER):
        feet, world = on_feet(scene, replace(springs, integrator=EULER))
        if world is not None:
            return feet, world
    kept = {name: value for name, value in settings.options.items() if name not in SOFT_OPTIONS}
    substeps = settings.substeps or UNSUBSTEPPED
    if _outpaced(scene, settings):
        springs = replace(springs, options={**springs.options, WHOLE_STEPS: substeps})
        if Effect.JOINTS in effects and Effect.CONTACT not in effects and quickest_turn(scene) * settings.dt > FAR * substeps:
            middle = replace(springs, integrator="implicit_midpoint")
            try:
                return middle, make_world(scene, engine_options(scene, middle))
            except Unsupported:  # loops
                return springs, None
    if Effect.CONTACT not in effects or Effect.GRAVITY not in effects or Effect.JOINTS in effects:
        return springs, None
    if _exact_knows(scene):  # of few bodies, each pair of which may be looked at
        ratio = mass_ratio(scene)
        if ratio > substeps * substeps or heap_gives_way(scene, settings.dt / substeps):
            tolerance = settings.tolerance or max(1e-11, ROUNDED * ratio)
            return replace(settings, solver=EXACT, substeps=1, iterations=None, tolerance=tolerance, options=kept), None
    world = make_world(scene, engine_options(scene, springs))
    start = world.save()
    if _overlaps(scene, world):
        margin = min(1e-3, length(scene.gravity) * settings.dt * settings.dt)
        unset = UNSET[SEQUENTIAL]
        return replace(settings, solver=SEQUENTIAL, **unset, options={"margin": margin, **kept}), None
    if world.impacts is not None:
        # What swept steps remember stands beside the saved state.
        return springs, None
    world.restore(start)
    return springs, world


def on_feet(scene: Scene, settings: Settings) -> "tuple[Settings, engine.World | None]":
    """The settings in fewer sub-steps, and a world under them, where trees of joints may touch something; else None.

    Joint coordinates know contacts under semi-implicit Euler alone, and what a tree does to its contacts is answered whole in a
    sub-step of any length: as many are taken as unlike masses call for, r = n^2, and else one for `MERGED` of those asked for,
    a single one with twice the sweeps.
    """
    if (Effect.CONTACT | Effect.JOINTS) not in scene.effects or WHOLE_STEPS in settings.options:
        return settings, None
    asked = settings.substeps or UNSUBSTEPPED
    substeps = min(asked, max(1, asked // MERGED, ceil(sqrt(mass_ratio(scene)))))
    few = replace(settings, substeps=substeps)
    if substeps == 1:
        few = replace(few, iterations=2 * (settings.iterations or SWEEPS))
    world = make_world(scene, engine_options(scene, few))
    return (few, world) if world.in_joint_coordinates else (settings, None)


def _outpaced(scene: Scene, settings: Settings) -> bool:
    """Whether a step of dt is too long for how fast a body turns or, without continuous collision, goes."""
    if Effect.CONTACT not in scene.effects:
        return settings.integrator == "rk4" and quickest_turn(scene) * settings.dt > TURNING
    return Effect.CONTINUOUS_COLLISION not in scene.effects and way_through(scene) * settings.dt > 1.0


def _exact_knows(scene: Scene) -> bool:
    """Whether the exact solver has all of the scene's laws, for few bodies."""
    return sum(body.movable for body in scene.bodies) <= FEW and not any(
        law.static_friction > law.kinetic_friction or law.rolling_friction or law.torsional_friction for law in scene.surfaces
    )


def _overlaps(scene: Scene, world: "engine.World") -> bool:
    """Whether two bodies start deeper in each other than `DEEP`, as the first step of a world, taken here, finds them."""
    from plumbline import engine

    try:
        world.step(1)
    except (engine.Diverged, engine.NotSupported):
        return False
    thin = [half_width(body) for body in scene.bodies]
    contacts = world.contacts()
    return any(-gap > DEEP * min(thin[a], thin[b]) for gap, (a, b) in zip(contacts.gap, contacts.bodies, strict=True))
