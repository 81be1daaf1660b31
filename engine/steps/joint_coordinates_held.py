"""Steps of trees in joint coordinates that more than their joints hold: soft contacts, and joints that close loops."""

from collections.abc import Callable

from plumbline.engine.articulated.advance import is_finite_forest, take_jumps, write_state
from plumbline.engine.articulated.contact_euler import Touching, forget_responses
from plumbline.engine.articulated.contact_sweeps import under_machines
from plumbline.engine.articulated.loops import touch_loops
from plumbline.engine.articulated.momenta import begin_momenta, damp_over, write_kept_velocities
from plumbline.engine.articulated.responses import find_touched
from plumbline.engine.articulated.semi_implicit_euler import semi_implicit_euler
from plumbline.engine.articulated.tables import trees_of
from plumbline.engine.compile.jit import entry, kernel, template
from plumbline.engine.constrain.open_joints import open_joint
from plumbline.engine.constrain.reactions import clear_reactions
from plumbline.engine.integrate.semi_implicit_euler import drift_free
from plumbline.engine.maths.rows import Floats, Ints
from plumbline.engine.memory import arena as at
from plumbline.engine.memory.carve import floats_of, ints_of
from plumbline.engine.memory.status import DIVERGED, DONE, UNSOLVED
from plumbline.engine.memory.tables import Rows, bodies_of, present_contacts, rows_of, shapes_of
from plumbline.engine.respond.softness import softness_of
from plumbline.engine.respond.substep import end_step
from plumbline.engine.steps.stages import meet


@kernel
def touch_nothing(floats: Floats, ints: Ints) -> int:
    """In place of `meet`, where nothing can touch."""
    bodies = bodies_of(floats, ints)
    for b in range(bodies.kind.shape[0]):
        bodies.kind[b, at.TOUCHED] = 0
    return DONE


@kernel
def no_rows(_floats: Floats, _ints: Ints) -> None:
    """In place of `rows_of`, where no joint closes a loop."""
    return


@kernel
def left_open(floats: Floats, ints: Ints, rows: Rows | None, status: int) -> int:
    """How all steps ended: as the last one did, or with a joint that closes a loop and is open."""
    if rows is None:
        return status
    return open_joint(floats, ints, touching=True) if status == DONE else status


@template
def advance_held(
    floats: Floats, ints: Ints, steps: int, meeting: Callable[[Floats, Ints], int], room: Callable[[Floats, Ints], Rows | None]
) -> tuple[int, int]:
    """The loop of all these steps.

    Args: meeting: finds the contacts of a step, or says why not; room: the rows of joints that close loops, or None.
    """
    trees = trees_of(floats, ints)
    bodies = trees.bodies
    shapes, sums = shapes_of(floats, ints), floats_of(floats, ints, at.START)
    setting, count, rows = floats_of(floats, ints, at.SETTING), ints_of(ints, at.COUNT), room(floats, ints)
    dt, substeps, gyroscopic = setting[0, at.DT], count[0, at.SUBSTEPS], count[0, at.GYROSCOPIC]
    soft = softness_of(setting, dt / substeps)
    firm = under_machines(setting, soft)
    damp_over(trees, soft.h)
    if count[0, at.STEPS] == 0:
        take_jumps(trees)
        begin_momenta(trees)
    done, status = 0, DONE
    while done < steps and status == DONE:
        status = meeting(floats, ints)
        if status == DONE:
            done += 1
            contacts = present_contacts(floats, ints)
            touch_loops(trees)
            touching = Touching(shapes, contacts, find_touched(trees), rows, sums, count, soft, firm)
            forget_responses(trees)
            clear_reactions(trees.joints)
            for substep in range(substeps):
                if status == DONE and not semi_implicit_euler(trees, soft.h, done == steps, touching, substep):
                    status = UNSOLVED
            end_step(contacts)
            for n in range(trees.other.shape[0]):
                b = trees.other[n, 0]
                if bodies.kind[b, at.MOTION] == at.DYNAMIC and bodies.kind[b, at.TOUCHED] == 0:
                    drift_free(bodies, setting, b, dt, substeps, gyroscopic)
            write_state(trees)
            write_kept_velocities(trees)
            count[0, at.STEPS] += 1
            if not is_finite_forest(trees):
                status = DIVERGED
    return done, left_open(floats, ints, rows, status)


@entry
def step_joint_coordinates_touching(floats: Floats, ints: Ints, steps: int) -> tuple[int, int]:
    """Advance trees and free bodies in contact, by semi-implicit Euler in sub-steps.

    Returns: steps done, and DONE, DIVERGED, UNSOLVED, FULL or CONVEX_PENDING.
    """
    return advance_held(floats, ints, steps, meet, no_rows)


@entry
def step_joint_coordinates_touching_and_closing(floats: Floats, ints: Ints, steps: int) -> tuple[int, int]:
    """As `step_joint_coordinates_touching`, with joints that close loops. Returns: as it does; or as `open_joint`."""
    return advance_held(floats, ints, steps, meet, rows_of)


@entry
def step_joint_coordinates_closing(floats: Floats, ints: Ints, steps: int) -> tuple[int, int]:
    """As `step_joint_coordinates_touching_and_closing`, where nothing touches."""
    return advance_held(floats, ints, steps, touch_nothing, rows_of)
