"""Steps of worlds of spheres: as `contact`, over contacts of one point whose arms lie along the normal.

It serves worlds whose moving bodies are single spheres about their centres of mass, of the same inertia about every axis, among
static spheres, boxes and planes, without joints, rolling or torsional friction.
"""

import math

from engine.compile.jit import entry, kernel
from engine.contact.sphere_contacts import find_touches
from engine.integrate.all_bodies import advance_untouched
from engine.integrate.finite_state import is_finite
from engine.maths.vec import Floats, Ints, axpy, load3, load4, quat_spin, quat_unit, scale, store3, store4
from engine.memory.arena import (
    ANGULAR_DAMPING,
    BODIES,
    COUNT,
    DAMPING_RATIO,
    DT,
    DYNAMIC,
    GRAVITY,
    HERTZ,
    ITERATIONS,
    LINEAR_DAMPING,
    M_INV_INERTIA,
    M_INV_MASS,
    MANIFOLDS,
    MAX_PUSH,
    MOTION,
    MOVER,
    NEW,
    R_RESTITUTION,
    R_SPIKE,
    R_STRUCK,
    RELAXATIONS,
    SETTING,
    STEPS,
    SUBSTEPS,
    SURFACE,
    TOUCH,
    TOUCH_KEY,
    TOUCH_REST,
    TOUCHED,
    P,
    Q,
    V,
    W,
)  # fmt: skip
from engine.memory.carve import floats_of, ints_of
from engine.memory.tables import bodies_of
from engine.respond.spheres import close_substep, note_strikes, press_spheres, push_again, relax_spheres, turn_normals
from engine.steps.contact import FRESH, slow_approach, soft_factors

__all__ = ["step_spheres"]

MANY = 16
"""New or struck contacts get more sweeps where they are one in so many: elsewhere the others' impulses carry the load."""


@kernel
def kick_spheres(
    body: Floats, kind: Ints, load: Floats, setting: Floats, mover: Floats, bodies: int, h: float
) -> None:  # fmt: skip
    """Gravity, applied loads and damping for h seconds on all bodies in contact."""
    g = load3(setting, 0, GRAVITY)
    for b in range(bodies):
        if kind[b, TOUCHED] == 1 and kind[b, MOTION] == DYNAMIC:
            v = axpy(h, axpy(mover[b, M_INV_MASS], load3(load, b, 0), g), load3(mover, b, 0))
            w = axpy(h * mover[b, M_INV_INERTIA], load3(load, b, 3), load3(mover, b, 3))
            if body[b, LINEAR_DAMPING] > 0.0:
                v = scale(math.exp(-h * body[b, LINEAR_DAMPING]), v)
            if body[b, ANGULAR_DAMPING] > 0.0:
                w = scale(math.exp(-h * body[b, ANGULAR_DAMPING]), w)
            store3(mover, b, 0, v)
            store3(mover, b, 3, w)


@kernel
def drift_spheres(state: Floats, kind: Ints, mover: Floats, bodies: int, h: float) -> None:
    """Move all bodies in contact for h seconds; the step's end makes the quaternions unit."""
    for b in range(bodies):
        if kind[b, TOUCHED] == 1 and kind[b, MOTION] == DYNAMIC:
            store3(state, b, P, axpy(h, load3(mover, b, 0), load3(state, b, P)))
            store4(state, b, Q, quat_spin(load4(state, b, Q), load3(mover, b, 3), h))


@kernel
def has_restitution(surface: Floats) -> bool:
    """Whether any law bounces."""
    most = 0.0
    for law in range(surface.shape[0]):
        most = max(most, surface[law, 2])
    return most > 0.0


@kernel
def any_struck(touches: int, rest: Floats) -> bool:
    """Whether a contact with restitution was struck in this sub-step."""
    struck = False
    for t in range(touches):
        struck = struck or (rest[t, R_RESTITUTION] > 0.0 and rest[t, R_STRUCK] == 1.0 and rest[t, R_SPIKE] > 0.0)
    return struck


@entry
def step_spheres(floats: Floats, ints: Ints, steps: int) -> tuple[int, int]:
    """Advance spheres in contact. Returns: as `step_contact`."""
    bodies = bodies_of(floats, ints)
    state, body, _, load, kind = bodies
    setting, mover = floats_of(floats, ints, SETTING), floats_of(floats, ints, MOVER)
    touch, rest, key = floats_of(floats, ints, TOUCH), floats_of(floats, ints, TOUCH_REST), ints_of(ints, TOUCH_KEY)
    count = ints_of(ints, COUNT)
    last, substeps = count[0, BODIES], count[0, SUBSTEPS]
    h = setting[0, DT] / substeps
    rate, mass, keep = soft_factors(setting[0, HERTZ], setting[0, DAMPING_RATIO], h)
    slow, most = slow_approach(setting, h), setting[0, MAX_PUSH]
    striking = 1 if has_restitution(floats_of(floats, ints, SURFACE)) else 0
    for step in range(steps):
        status = find_touches(floats, ints)
        if status != 0:
            return step, status
        n = count[0, MANIFOLDS]
        advance_untouched(bodies, setting, count)
        for substep in range(substeps):
            if n == 0:
                break
            fresh = count[0, NEW] if substep == 0 else 0
            kick_spheres(body, kind, load, setting, mover, last, h)
            if striking == 1:
                fresh = max(fresh, note_strikes(n, touch, rest, key, mover, setting, h, slow))
            patience = FRESH if fresh * MANY >= n else 1
            push_again(n, touch, key, mover)
            for _ in range(count[0, ITERATIONS] * patience):
                press_spheres(n, touch, rest, key, mover, h, rate, mass, keep, most, striking)
            drift_spheres(state, kind, mover, last, h)
            turn_normals(n, touch, rest, key, mover, state, striking)
            for _ in range(count[0, RELAXATIONS] * patience):
                relax_spheres(n, touch, rest, key, mover, 0, striking)
            if striking == 1 and any_struck(n, rest):
                for _ in range(FRESH * (count[0, ITERATIONS] + count[0, RELAXATIONS])):
                    relax_spheres(n, touch, rest, key, mover, 1, striking)
            close_substep(n, touch, rest, key, mover, striking)
        for b in range(last):
            if kind[b, TOUCHED] == 1 and kind[b, MOTION] == DYNAMIC:
                store4(state, b, Q, quat_unit(load4(state, b, Q)))
                store3(state, b, V, load3(mover, b, 0))
                store3(state, b, W, load3(mover, b, 3))
        count[0, STEPS] += 1
        if not is_finite(state, last):
            return step + 1, 1
    return steps, 0
