"""Steps of worlds with contact and joints: in each sub-step, contact sweeps alternate with a direct solve of all joints."""

from engine.compile.jit import entry
from engine.constrain.bounded import KNOWN, NEW
from engine.constrain.hold_joints import hold_joints, keep_rotors, write_rows
from engine.constrain.open_joints import open_joint
from engine.constrain.reactions import clear_reactions
from engine.contact.find_contacts import find_contacts
from engine.integrate.all_bodies import advance_untouched, drift_touched, kick_touched
from engine.maths.rows import Floats, Ints
from engine.memory import arena as at
from engine.memory.carve import floats_of, ints_of
from engine.memory.status import DIVERGED, DONE
from engine.memory.tables import bodies_of, contacts_of, joints_of, rows_of, shapes_of
from engine.respond.arms import refresh
from engine.respond.share_loads import share_loads
from engine.respond.soft import sweep
from engine.respond.softness import FRESH, PRESS, REBOUND, RELAX, slow_approach, softness_of
from engine.respond.substep import approach, bounce, end_step, end_substep, friction_mode, warm_start
from engine.steps.count_step import count_step
from engine.steps.stages import patience


@entry
def step_contact_jointed(floats: Floats, ints: Ints, steps: int) -> tuple[int, int]:
    """Advance bodies in contact and held by joints. Returns: as `step_contact`, and `open_joint`."""
    bodies, contacts, sums = bodies_of(floats, ints), contacts_of(floats, ints), floats_of(floats, ints, at.START)
    joints, rows = joints_of(floats, ints), rows_of(floats, ints)
    shapes, setting, count = shapes_of(floats, ints), floats_of(floats, ints, at.SETTING), ints_of(ints, at.COUNT)
    soft = softness_of(setting, setting[0, at.DT] / count[0, at.SUBSTEPS])
    slow = slow_approach(setting, soft.h)
    for step in range(steps):
        status = find_contacts(floats, ints)
        if status != DONE:
            return step, status
        for j in range(count[0, at.JOINTS]):
            bodies.kind[joints.kind[j, at.PARENT], at.TOUCHED] = 1
            bodies.kind[joints.kind[j, at.CHILD], at.TOUCHED] = 1
        advance_untouched(bodies, setting, count)
        clear_reactions(joints)
        n = count[0, at.MANIFOLDS]
        for substep in range(count[0, at.SUBSTEPS]):
            kick_touched(bodies, setting, count, soft.h)
            equalities, all_rows = write_rows(bodies, joints, rows, soft.h)
            strikes = approach(bodies, contacts, n, setting, soft.h, slow)
            times = patience(count, substep, strikes)
            share_loads(bodies, contacts, n, sums)
            warm_start(bodies, contacts, n)
            hold_joints(bodies, joints, rows, equalities, all_rows, NEW)
            for _ in range(count[0, at.ITERATIONS] * times):
                if n > 0:
                    sweep(bodies, contacts, n, soft, PRESS)
                    hold_joints(bodies, joints, rows, equalities, all_rows, KNOWN)
            drift_touched(bodies, count, soft.h)
            if n > 0:
                refresh(bodies.state, shapes, contacts, n)
                share_loads(bodies, contacts, n, sums)
                for _ in range(count[0, at.RELAXATIONS] * times):
                    sweep(bodies, contacts, n, soft, RELAX)
                    hold_joints(bodies, joints, rows, equalities, all_rows, KNOWN)
                if bounce(contacts, n):
                    for _ in range(FRESH * (count[0, at.ITERATIONS] + count[0, at.RELAXATIONS])):
                        sweep(bodies, contacts, n, soft, REBOUND)
                        hold_joints(bodies, joints, rows, equalities, all_rows, KNOWN)
                friction_mode(bodies, contacts, n)
                end_substep(contacts, n)
            keep_rotors(joints, rows, equalities)
        end_step(contacts, n)
        if count_step(bodies.state, count) == DIVERGED:
            return step + 1, DIVERGED
    return steps, open_joint(floats, ints, touching=True)
