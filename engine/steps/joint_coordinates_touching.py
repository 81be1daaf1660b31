"""Steps of worlds whose joints make trees, in joint coordinates, with soft contacts of these trees and of free bodies."""

from engine.articulated.advance import is_finite_forest, write_state
from engine.articulated.bases import take_jumps
from engine.articulated.contact_euler import Mechanisms, forget_responses, touching_substep
from engine.articulated.momenta import begin_momenta, damp_over, write_kept_velocities
from engine.articulated.tables import tables_of
from engine.articulated.touched import find_touched
from engine.compile.jit import entry
from engine.constrain.reactions import clear_reactions
from engine.integrate.semi_implicit_euler import drift_free
from engine.maths.vec import Floats, Ints
from engine.memory.arena import COUNT, DT, DYNAMIC, GYROSCOPIC, MANIFOLDS, MOTION, SETTING, START, STEPS, SUBSTEPS, TOUCHED
from engine.memory.carve import floats_of, ints_of
from engine.memory.status import DIVERGED, DONE, UNSOLVED
from engine.memory.tables import bodies_of, contacts_of, joints_of, shapes_of
from engine.respond.softness import softness_of
from engine.respond.substep import end_step
from engine.steps.count_step import count_step
from engine.steps.stages import meet

__all__ = ["step_joint_coordinates_touching"]


@entry
def step_joint_coordinates_touching(floats: Floats, ints: Ints, steps: int) -> tuple[int, int]:
    """Advance trees and free bodies in contact, by semi-implicit Euler in sub-steps.

    Returns: steps done, and DONE, DIVERGED, UNSOLVED, FULL or CONVEX_PENDING.
    """
    bodies, joints, tables = bodies_of(floats, ints), joints_of(floats, ints), tables_of(floats, ints)
    contacts, shapes, sums = contacts_of(floats, ints), shapes_of(floats, ints), floats_of(floats, ints, START)
    setting, count = floats_of(floats, ints, SETTING), ints_of(ints, COUNT)
    dt, substeps, gyroscopic = setting[0, DT], count[0, SUBSTEPS], count[0, GYROSCOPIC]
    soft = softness_of(setting, dt / substeps)
    damp_over(tables, soft.h)
    if count[0, STEPS] == 0:
        take_jumps(tables, bodies, joints)
        begin_momenta(tables, bodies, gyroscopic)
    for step in range(steps):
        status = meet(floats, ints, bodies, contacts)
        if status != DONE:
            return step, status
        mechanisms = Mechanisms(tables, bodies, joints, shapes, contacts, find_touched(tables, bodies))
        forget_responses(tables)
        clear_reactions(joints)
        for substep in range(substeps):
            if status == DONE and not touching_substep(mechanisms, setting, count, sums, soft, substep, step == steps - 1):
                status = UNSOLVED
        end_step(contacts, count[0, MANIFOLDS])
        for n in range(tables.other.shape[0]):
            b = tables.other[n, 0]
            if bodies.kind[b, MOTION] == DYNAMIC and bodies.kind[b, TOUCHED] == 0:
                drift_free(bodies, setting, b, dt, substeps, gyroscopic)
        write_state(tables, bodies, joints)
        write_kept_velocities(tables, bodies, gyroscopic)
        finite = is_finite_forest(tables)
        if count_step(bodies.state, count) == DIVERGED or not finite:
            status = DIVERGED
        if status != DONE:
            return step + 1, status
    return steps, DONE
