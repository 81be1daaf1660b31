"""Steps of worlds of spheres: as `contact`, over contacts of one point whose arms lie along the normal.

It serves worlds whose moving bodies are single spheres about their centres of mass, of the same inertia about every axis, among
static spheres, boxes and planes, without joints, rolling or torsional friction.
"""

from engine.compile.jit import entry
from engine.contact.sphere_contacts import find_touches
from engine.integrate.all_bodies import advance_untouched
from engine.maths.vec import Floats, Ints
from engine.memory.arena import COUNT, DT, ITERATIONS, MANIFOLDS, NEW, RELAXATIONS, SETTING, SUBSTEPS
from engine.memory.carve import floats_of, ints_of
from engine.memory.status import DIVERGED, DONE
from engine.memory.tables import bodies_of
from engine.respond.softness import FRESH, REBOUND, RELAX, slow_approach, softness_of
from engine.respond.sphere_motion import drift_spheres, end_spheres, kick_spheres
from engine.respond.spheres import (
    any_struck,
    choose_friction,
    drop_blows,
    note_strikes,
    press_spheres,
    push_again,
    relax_spheres,
    touches_of,
    turn_normals,
)
from engine.steps.count_step import count_step

__all__ = ["step_spheres"]

MANY = 16
"""New or struck contacts get more sweeps where they are one in so many: elsewhere the others' impulses carry the load."""


@entry
def step_spheres(floats: Floats, ints: Ints, steps: int) -> tuple[int, int]:
    """Advance spheres in contact. Returns: as `step_contact`."""
    bodies, touches = bodies_of(floats, ints), touches_of(floats, ints)
    setting, count, mover = floats_of(floats, ints, SETTING), ints_of(ints, COUNT), touches.mover
    soft = softness_of(setting, setting[0, DT] / count[0, SUBSTEPS])
    slow = slow_approach(setting, soft.h)
    for step in range(steps):
        status = find_touches(floats, ints)
        if status != DONE:
            return step, status
        advance_untouched(bodies, setting, count)
        n = count[0, MANIFOLDS]
        for substep in range(count[0, SUBSTEPS]):
            if n == 0:
                break
            fresh, share = (count[0, NEW], 0.0) if substep == 0 else (0, 1.0)
            kick_spheres(bodies, mover, setting, count, soft.h)
            if touches.elastic == 1:
                fresh = max(fresh, note_strikes(touches, n, setting, soft.h, slow, share))
            times = FRESH if fresh * MANY >= n else 1
            push_again(touches, n, share)
            for _ in range(count[0, ITERATIONS] * times):
                press_spheres(touches, n, soft)
            drift_spheres(bodies, mover, count, soft.h)
            turn_normals(touches, n, bodies.state)
            slipping = count[0, RELAXATIONS] == 0  # nothing looks at it then
            for _ in range(count[0, RELAXATIONS] * times):
                slipping = relax_spheres(touches, n, RELAX)
            if touches.elastic == 1 and any_struck(touches, n):
                for _ in range(FRESH * (count[0, ITERATIONS] + count[0, RELAXATIONS])):
                    slipping = relax_spheres(touches, n, REBOUND)
            if slipping:
                choose_friction(touches, n)
            if touches.elastic == 1:
                drop_blows(touches, n)
        end_spheres(bodies, mover, count)
        if count_step(bodies.state, count) == DIVERGED:
            return step + 1, DIVERGED
    return steps, DONE
