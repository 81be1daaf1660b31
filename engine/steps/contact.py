"""Steps of worlds with contact, without joints: find contacts, advance what is free, solve what is touched in sub-steps."""

from engine.compile.jit import entry
from engine.integrate.all_bodies import advance_untouched, drift_touched, kick_touched
from engine.maths.vec import Floats, Ints
from engine.memory.arena import COUNT, DT, ITERATIONS, MANIFOLDS, RELAXATIONS, SETTING, START, SUBSTEPS
from engine.memory.carve import floats_of, ints_of
from engine.memory.status import DIVERGED, DONE
from engine.memory.tables import bodies_of, contacts_of, shapes_of
from engine.respond.arms import refresh
from engine.respond.share_loads import share_loads
from engine.respond.soft import sweep
from engine.respond.softness import FRESH, PRESS, REBOUND, RELAX, slow_approach, softness_of
from engine.respond.substep import approach, bounce, end_step, end_substep, friction_mode, warm_start
from engine.steps.count_step import count_step
from engine.steps.stages import meet, patience

__all__ = ["step_contact"]


@entry
def step_contact(floats: Floats, ints: Ints, steps: int) -> tuple[int, int]:
    """Advance bodies in contact. Returns: steps done, and DONE, DIVERGED, FULL or CONVEX_PENDING."""
    bodies, contacts, sums = bodies_of(floats, ints), contacts_of(floats, ints), floats_of(floats, ints, START)
    shapes, setting, count = shapes_of(floats, ints), floats_of(floats, ints, SETTING), ints_of(ints, COUNT)
    soft = softness_of(setting, setting[0, DT] / count[0, SUBSTEPS])
    slow = slow_approach(setting, soft.h)
    for step in range(steps):
        status = meet(floats, ints, bodies, contacts)
        if status != DONE:
            return step, status
        advance_untouched(bodies, setting, count)
        n = count[0, MANIFOLDS]
        if n > 0:
            for substep in range(count[0, SUBSTEPS]):
                kick_touched(bodies, setting, count, soft.h)
                strikes = approach(bodies, contacts, n, setting, soft.h, slow)
                times = patience(count, substep, strikes)
                share_loads(bodies, contacts, n, sums)
                warm_start(bodies, contacts, n)
                for _ in range(count[0, ITERATIONS] * times):
                    sweep(bodies, contacts, n, soft, PRESS)
                drift_touched(bodies, count, soft.h)
                refresh(bodies.state, shapes, contacts, n)
                share_loads(bodies, contacts, n, sums)
                for _ in range(count[0, RELAXATIONS] * times):
                    sweep(bodies, contacts, n, soft, RELAX)
                if bounce(contacts, n):
                    for _ in range(FRESH * (count[0, ITERATIONS] + count[0, RELAXATIONS])):
                        sweep(bodies, contacts, n, soft, REBOUND)
                friction_mode(bodies, contacts, n)
                end_substep(contacts, n)
            end_step(contacts, n)
        if count_step(bodies.state, count) == DIVERGED:
            return step + 1, DIVERGED
    return steps, DONE
