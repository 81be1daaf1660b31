"""Steps of worlds with contact: find contacts, advance what is free, solve what is touched in sub-steps."""

from collections.abc import Callable

from plumbline.engine.compile.jit import entry, template
from plumbline.engine.constrain.stages import BEGIN, END, KNOWN, NEW, Held, hold_nothing
from plumbline.engine.contact.colours import leave_as_found
from plumbline.engine.integrate.all_bodies import advance_untouched, drift_touched, kick_touched
from plumbline.engine.maths.rows import Floats, Ints
from plumbline.engine.memory import arena as at
from plumbline.engine.memory.carve import floats_of, ints_of
from plumbline.engine.memory.status import DIVERGED, DONE
from plumbline.engine.memory.tables import Bodies, Contacts, bodies_of, contacts_of, joints_of, rows_of
from plumbline.engine.respond.manifold_sweeps import as_found
from plumbline.engine.respond.share_loads import share_loads
from plumbline.engine.respond.softness import FRESH, PRESS, PUSH, REBOUND, RELAX, TURN, slow_approach, softness_of
from plumbline.engine.respond.substep import approach, bounce, end_step, end_substep, friction_mode
from plumbline.engine.steps.count_step import count_step
from plumbline.engine.steps.stages import meet, patience


@template
def advance_contacts(
    floats: Floats,
    ints: Ints,
    steps: int,
    meeting: Callable[[Floats, Ints, Bodies, Contacts], int],
    mark: Callable[[Floats, Ints], None],
    visit: Callable[..., None],
    holding: Callable[..., Held],
) -> tuple[int, int]:
    """Advance bodies in contact.

    Args: meeting: keeps or finds the contacts of a step; mark: notes their colours; visit: does to all what is to be done to
        each, as `as_found`; holding: holds joints, as `hold`. Returns: as `step_contact`.
    """
    bodies, contacts, sums = bodies_of(floats, ints), contacts_of(floats, ints), floats_of(floats, ints, at.START)
    joints, rows, held = joints_of(floats, ints), rows_of(floats, ints), (0, 0)
    setting, count = floats_of(floats, ints, at.SETTING), ints_of(ints, at.COUNT)
    soft = softness_of(setting, setting[0, at.DT] / count[0, at.SUBSTEPS])
    slow = slow_approach(setting, soft.h)
    for step in range(steps):
        status = meeting(floats, ints, bodies, contacts)
        if status != DONE:
            return step, status
        advance_untouched(bodies, setting, count)
        n = count[0, at.MANIFOLDS]
        if n > 0:
            mark(floats, ints)
        for substep in range(count[0, at.SUBSTEPS] if n > 0 or count[0, at.JOINTS] > 0 else 0):
            kick_touched(bodies, setting, count, soft.h)
            held = holding(bodies, joints, rows, held, BEGIN, soft.h)
            strikes = approach(bodies, contacts, n, setting, soft.h, slow)
            times = patience(count, substep, strikes) if n > 0 else 0
            share_loads(bodies, contacts, n, sums)
            visit(floats, ints, bodies, contacts, soft, PUSH)
            holding(bodies, joints, rows, held, NEW, soft.h)
            for _ in range(count[0, at.ITERATIONS] * times):
                visit(floats, ints, bodies, contacts, soft, PRESS)
                holding(bodies, joints, rows, held, KNOWN, soft.h)
            drift_touched(bodies, count, soft.h)
            visit(floats, ints, bodies, contacts, soft, TURN)
            share_loads(bodies, contacts, n, sums)
            for _ in range(count[0, at.RELAXATIONS] * times):
                visit(floats, ints, bodies, contacts, soft, RELAX)
                holding(bodies, joints, rows, held, KNOWN, soft.h)
            if bounce(contacts, n):
                for _ in range(FRESH * (count[0, at.ITERATIONS] + count[0, at.RELAXATIONS])):
                    visit(floats, ints, bodies, contacts, soft, REBOUND)
                    holding(bodies, joints, rows, held, KNOWN, soft.h)
            friction_mode(bodies, contacts, n)
            end_substep(contacts, n)
            holding(bodies, joints, rows, held, END, soft.h)
        end_step(contacts, n)
        if count_step(bodies.state, count) == DIVERGED:
            return step + 1, DIVERGED
    return steps, DONE


@entry
def step_contact(floats: Floats, ints: Ints, steps: int) -> tuple[int, int]:
    """Advance bodies in contact. Returns: steps done, and DONE, DIVERGED, FULL or CONVEX_PENDING."""
    return advance_contacts(floats, ints, steps, meet, leave_as_found, as_found, hold_nothing)
