"""Steps of worlds with contact under sequential impulses: find contacts, kick, sweep velocities, drift, part."""

from plumbline.engine.compile.jit import entry
from plumbline.engine.integrate.all_bodies import advance_untouched, drift_all, kick_all, touched_of
from plumbline.engine.maths.rows import Floats, Ints
from plumbline.engine.memory import arena as at
from plumbline.engine.memory.carve import floats_of, ints_of
from plumbline.engine.memory.status import DIVERGED, DONE
from plumbline.engine.memory.tables import bodies_of, present_contacts, shapes_of
from plumbline.engine.respond.arms import refresh
from plumbline.engine.respond.sequential_impulses import push_apart, sweep_both_ways
from plumbline.engine.respond.share_loads import share_loads
from plumbline.engine.respond.softness import PRESS, REBOUND, slow_approach
from plumbline.engine.respond.substep import approach, bounce, end_step, end_substep, friction_mode, warm_start
from plumbline.engine.steps.count_step import count_step
from plumbline.engine.steps.stages import meet

SLOP = 0.1
"""Share of the margin [1] that bodies may overlap, so that contacts last from step to step."""


@entry
def step_sequential_impulses(floats: Floats, ints: Ints, steps: int) -> tuple[int, int]:
    """Advance bodies in contact. Returns: as `step_contact`."""
    bodies, pseudo = bodies_of(floats, ints), floats_of(floats, ints, at.START)
    shapes, setting, count = shapes_of(floats, ints), floats_of(floats, ints, at.SETTING), ints_of(ints, at.COUNT)
    h, iterations = setting[0, at.DT] / count[0, at.SUBSTEPS], count[0, at.ITERATIONS]
    slow, slop = slow_approach(setting, h), SLOP * setting[0, at.MARGIN]
    for step in range(steps):
        status = meet(floats, ints)
        if status != DONE:
            return step, status
        advance_untouched(bodies, setting, count, ints_of(ints, at.BODY_ORDER))
        contacts, touched = present_contacts(floats, ints), touched_of(ints)
        if count[0, at.MANIFOLDS] > 0:
            for _ in range(count[0, at.SUBSTEPS]):
                kick_all(bodies, touched, setting, h)
                approach(bodies, contacts, setting, h, slow)
                share_loads(bodies, contacts, pseudo)
                warm_start(bodies, contacts)
                sweep_both_ways(bodies, contacts, h, PRESS, iterations)
                drift_all(bodies, touched, count, h)
                refresh(bodies.state, shapes, contacts)
                if push_apart(bodies, contacts, pseudo, h, iterations, slop):
                    refresh(bodies.state, shapes, contacts)
                if bounce(contacts):
                    sweep_both_ways(bodies, contacts, h, REBOUND, iterations)
                friction_mode(bodies, contacts)
                end_substep(contacts)
            end_step(contacts)
        if count_step(bodies.state, count) == DIVERGED:
            return step + 1, DIVERGED
    return steps, DONE
