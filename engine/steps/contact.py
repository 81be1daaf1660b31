"""Steps of worlds with contact: find contacts, advance what is free, solve what is touched in sub-steps."""

from collections.abc import Callable

from plumbline.engine.compile.jit import entry, template
from plumbline.engine.constrain.stages import Held, hold_nothing
from plumbline.engine.contact.colours import leave_as_found
from plumbline.engine.integrate.all_bodies import advance_untouched, touched_of
from plumbline.engine.maths.rows import Floats, Ints
from plumbline.engine.memory import arena as at
from plumbline.engine.memory.carve import floats_of, ints_of
from plumbline.engine.memory.status import DIVERGED, DONE
from plumbline.engine.memory.tables import bodies_of, in_order, joints_of, present_contacts, rows_of
from plumbline.engine.respond.manifold_sweeps import as_found
from plumbline.engine.respond.share_loads import list_sharing
from plumbline.engine.respond.softness import softness_of
from plumbline.engine.respond.substep import end_step
from plumbline.engine.steps.count_step import count_step
from plumbline.engine.steps.stages import Group, begin_world, effort_of, meet, release_world, solve_world


@template
def advance_contacts(
    floats: Floats,
    ints: Ints,
    steps: int,
    meeting: Callable[[Floats, Ints], int],
    mark: Callable[[Floats, Ints], None],
    visit: Callable[..., None],
    holding: Callable[..., Held],
) -> tuple[int, int]:
    """Advance bodies in contact.

    Args: meeting: keeps or finds the contacts of a step; mark: notes their colours; visit: does to all what is to be done to
        each, as `as_found`; holding: holds joints, as `hold`. Returns: as `step_contact`.
    """
    bodies, joints, rows, held = bodies_of(floats, ints), joints_of(floats, ints), rows_of(floats, ints), (0, 0)
    setting, count, sums = floats_of(floats, ints, at.SETTING), ints_of(ints, at.COUNT), floats_of(floats, ints, at.START)
    soft = softness_of(setting, setting[0, at.DT] / count[0, at.SUBSTEPS])
    for step in range(steps):
        status = meeting(floats, ints)
        if status != DONE:
            return step, status
        advance_untouched(bodies, setting, count, ints_of(ints, at.BODY_ORDER))
        n = count[0, at.MANIFOLDS]
        contacts, room = present_contacts(floats, ints), ints_of(ints, at.SHARING)
        sharing = in_order(contacts, room[: list_sharing(bodies, contacts, sums, room)])
        group = Group(bodies, touched_of(ints), contacts, sharing, joints, rows, sums, ints_of(ints, at.HURRIED))
        if n > 0:
            mark(floats, ints)
        for substep in range(count[0, at.SUBSTEPS] if n > 0 or count[0, at.JOINTS] > 0 else 0):
            strikes, held = begin_world(group, setting, held, soft, holding)
            effort = effort_of(group, count, substep == 0 and count[0, at.NEW] > 0, strikes > 0)
            struck = solve_world(floats, ints, group, held, soft, effort, visit, holding)
            release_world(floats, ints, group, held, soft, struck, visit, holding)
        end_step(group.contacts)
        if count_step(bodies.state, count) == DIVERGED:
            return step + 1, DIVERGED
    return steps, DONE


@entry
def step_contact(floats: Floats, ints: Ints, steps: int) -> tuple[int, int]:
    """Advance bodies in contact. Returns: steps done, and DONE, DIVERGED, FULL or CONVEX_PENDING."""
    return advance_contacts(floats, ints, steps, meet, leave_as_found, as_found, hold_nothing)
