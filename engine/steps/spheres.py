"""Steps of worlds of spheres: as `contact`, over contacts of one point whose arms lie along the normal.

It serves worlds whose moving bodies are single spheres about their centres of mass, of the same inertia about every axis, among
static spheres, boxes and planes, without joints, rolling or torsional friction.
"""

from collections.abc import Callable

from plumbline.engine.compile.jit import entry, template
from plumbline.engine.contact.colours import leave_as_found
from plumbline.engine.contact.sphere_contacts import find_touches
from plumbline.engine.integrate.all_bodies import advance_untouched
from plumbline.engine.maths.rows import Floats, Ints
from plumbline.engine.memory import arena as at
from plumbline.engine.memory.carve import floats_of, ints_of
from plumbline.engine.memory.status import DIVERGED, DONE
from plumbline.engine.memory.tables import bodies_of
from plumbline.engine.respond.softness import FRESH, PRESS, PUSH, REBOUND, RELAX, TURN, slow_approach, softness_of
from plumbline.engine.respond.sphere_sweeps import as_found
from plumbline.engine.respond.spheres import (
    any_struck,
    choose_friction,
    drift_spheres,
    drop_blows,
    end_spheres,
    kick_spheres,
    note_strikes,
    touches_of,
)
from plumbline.engine.steps.count_step import count_step

MANY = 16
"""New or struck contacts get more sweeps where they are one in so many: elsewhere the others' impulses carry the load."""


@template
def advance_spheres(
    floats: Floats, ints: Ints, steps: int, mark: Callable[[Floats, Ints], None], visit: Callable[..., bool]
) -> tuple[int, int]:
    """Advance spheres in contact.

    Args: mark: notes the colours of a step's contacts; visit: does to all what is to be done to each, as
        `as_found`. Returns: as `step_contact`.
    """
    bodies, touches = bodies_of(floats, ints), touches_of(floats, ints)
    setting, count, mover = floats_of(floats, ints, at.SETTING), ints_of(ints, at.COUNT), touches.mover
    soft = softness_of(setting, setting[0, at.DT] / count[0, at.SUBSTEPS])
    slow = slow_approach(setting, soft.h)
    for step in range(steps):
        status = find_touches(floats, ints)
        if status != DONE:
            return step, status
        advance_untouched(bodies, setting, count, ints_of(ints, at.BODY_ORDER))
        n = count[0, at.MANIFOLDS]
        if n > 0:
            mark(floats, ints)
        for substep in range(count[0, at.SUBSTEPS]):
            if n == 0:
                break
            fresh, share = (count[0, at.NEW], 0.0) if substep == 0 else (0, 1.0)
            kick_spheres(bodies, mover, setting, count, soft.h)
            if touches.elastic == 1:
                fresh = max(fresh, note_strikes(touches, n, setting, soft.h, slow, share))
            times = FRESH if fresh * MANY >= n else 1
            visit(floats, ints, touches, soft, PUSH, share)
            for _ in range(count[0, at.ITERATIONS] * times):
                visit(floats, ints, touches, soft, PRESS, share)
            drift_spheres(bodies, mover, count, soft.h)
            visit(floats, ints, touches, soft, TURN, share)
            slipping = count[0, at.RELAXATIONS] == 0  # nothing looks at it then
            for _ in range(count[0, at.RELAXATIONS] * times):
                slipping = visit(floats, ints, touches, soft, RELAX, share)
            if touches.elastic == 1 and any_struck(touches, n):
                for _ in range(FRESH * (count[0, at.ITERATIONS] + count[0, at.RELAXATIONS])):
                    slipping = visit(floats, ints, touches, soft, REBOUND, share)
            if slipping:
                choose_friction(touches, n)
            if touches.elastic == 1:
                drop_blows(touches, n)
        end_spheres(bodies, mover, count)
        if count_step(bodies.state, count) == DIVERGED:
            return step + 1, DIVERGED
    return steps, DONE


@entry
def step_spheres(floats: Floats, ints: Ints, steps: int) -> tuple[int, int]:
    """Advance spheres in contact. Returns: as `step_contact`."""
    return advance_spheres(floats, ints, steps, leave_as_found, as_found)
