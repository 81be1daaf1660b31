"""The compiled parts of an exact step: find contacts, kick, drift, the stages of the soft solver, one by one; and, where there
are joints, their rows and a last look at their gaps."""

from plumbline.engine.compile.jit import entry
from plumbline.engine.constrain.coordinate import bounded_rows
from plumbline.engine.constrain.joint_rows import equality_rows
from plumbline.engine.constrain.open_joints import open_joint
from plumbline.engine.contact.find_contacts import find_contacts
from plumbline.engine.integrate import all_bodies
from plumbline.engine.maths.rows import Floats, Ints
from plumbline.engine.memory import arena as at
from plumbline.engine.memory.carve import floats_of, ints_of
from plumbline.engine.memory.status import DONE
from plumbline.engine.memory.tables import bodies_of, joints_of, present_contacts, rows_of, shapes_of
from plumbline.engine.respond.arms import refresh
from plumbline.engine.respond.softness import slow_approach
from plumbline.engine.respond.substep import approach, sum_impulses
from plumbline.engine.steps.count_step import count_step


@entry
def begin_step(floats: Floats, ints: Ints) -> int:
    """Find the contacts of a step and advance the bodies that neither they nor joints touch. Returns: as `find_contacts`."""
    status = find_contacts(floats, ints)
    if status == DONE:
        bodies, joints, count = bodies_of(floats, ints), joints_of(floats, ints), ints_of(ints, at.COUNT)
        for j in range(count[0, at.JOINTS]):
            bodies.kind[joints.kind[j, at.PARENT], at.TOUCHED] = 1
            bodies.kind[joints.kind[j, at.CHILD], at.TOUCHED] = 1
        all_bodies.advance_untouched(bodies, floats_of(floats, ints, at.SETTING), count, ints_of(ints, at.BODY_ORDER))
    return status


@entry
def kick_touched(floats: Floats, ints: Ints, h: float) -> float:
    """Gravity, loads and damping for h seconds on the bodies in contact, and note the points that will strike.

    Returns: the approach speed [m/s] below which nothing bounces.
    """
    bodies, setting = bodies_of(floats, ints), floats_of(floats, ints, at.SETTING)
    all_bodies.kick_all(bodies, all_bodies.touched_of(ints), setting, h)
    slow = slow_approach(setting, h)
    approach(bodies, present_contacts(floats, ints), setting, h, slow)
    return slow


@entry
def drift_touched(floats: Floats, ints: Ints, h: float, last: int) -> int:
    """Move the bodies in contact for h seconds. Args: last: 1 to end the step. Returns: DONE, or DIVERGED."""
    bodies, contacts, count = bodies_of(floats, ints), present_contacts(floats, ints), ints_of(ints, at.COUNT)
    all_bodies.drift_all(bodies, all_bodies.touched_of(ints), count, h)
    refresh(bodies.state, shapes_of(floats, ints), contacts)
    sum_impulses(contacts)
    return int(count_step(bodies.state, count)) if last == 1 else DONE


@entry
def write_joint_rows(floats: Floats, ints: Ints, h: float) -> tuple[int, int]:
    """Write the rows of all joints for the present pose, over h seconds. Returns: how many are equalities, and of all."""
    bodies, joints, rows = bodies_of(floats, ints), joints_of(floats, ints), rows_of(floats, ints)
    equalities = equality_rows(bodies.state, joints, rows)
    return equalities, bounded_rows(bodies.state, joints, rows, equalities, h, stiff_alone=False)


@entry
def look_at_joints(floats: Floats, ints: Ints) -> int:
    """Returns: as `open_joint`."""
    return open_joint(floats, ints, touching=True)
