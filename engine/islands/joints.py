"""The contacts and joints of one island, solved in memory of its own, as `contacts` does for contacts alone.

Each island has its own matrix, so that the direct solve costs the sum of the cubes of the islands' rows and not the cube of
their sum.
"""

from engine.compile.jit import kernel
from engine.constrain.bounded import KNOWN, NEW
from engine.constrain.hold_joints import hold_joints, keep_rotors, write_rows
from engine.constrain.reactions import clear_reactions
from engine.integrate.semi_implicit_euler import drift
from engine.islands.contacts import (
    copy_row,
    give_island,
    island_bodies,
    island_contacts,
    island_sums,
    kick_island,
    patience_of,
    softness_in,
    take_island,
)
from engine.maths.rows import Floats, Ints
from engine.memory import arena as at
from engine.memory.carve import floats_of, ints_of, table_within
from engine.memory.tables import Joints, Rows, shapes_of
from engine.respond.arms import refresh
from engine.respond.share_loads import share_loads
from engine.respond.soft import sweep
from engine.respond.softness import FRESH, PRESS, REBOUND, RELAX
from engine.respond.substep import bounce, end_substep, friction_mode, warm_start

ROOM = (9, 6, 8, 8, 4)
"""The most rows of a joint of each type: its equalities, and one each for limits, spring and drive; what else it has adds."""


@kernel
def make_room_for_rows(ints: Ints) -> None:
    """Write where the rows of every island begin."""
    span, joint_kind = ints_of(ints, at.SPAN_OF_ISLAND), ints_of(ints, at.JOINT_KIND)
    grouped, islands = ints_of(ints, at.GROUPED_JOINT), ints_of(ints, at.TALLY)[0, at.ISLANDS]
    row = 0
    for i in range(islands):
        span[i, at.FIRST_ROW] = row
        for rank in range(span[i, at.FIRST_JOINT], span[i + 1, at.FIRST_JOINT]):
            j = grouped[rank, 0]
            row += ROOM[joint_kind[j, at.JOINT_TYPE]]
            row += (joint_kind[j, at.HAS] & at.HAS_ARMATURE != 0) + (joint_kind[j, at.HAS] & at.HAS_FRICTION != 0)
            row += 2 * (joint_kind[j, at.HAS] & at.HAS_SPEED_LIMIT != 0)
    span[islands, at.FIRST_ROW] = row


@kernel
def island_joints(floats: Floats, ints: Ints, i: int) -> Joints:
    """The tables of the joints of island i."""
    span = ints_of(ints, at.SPAN_OF_ISLAND)
    first, end = span[i, at.FIRST_JOINT], span[i + 1, at.FIRST_JOINT]
    return Joints(floats_of(floats, ints, at.LOCAL_JOINT)[first:end], ints_of(ints, at.LOCAL_JOINT_KIND)[first:end])


@kernel
def island_rows(floats: Floats, ints: Ints, i: int) -> Rows:
    """The tables of the r rows of island i: matrix (r, r), factor (r, r) and vectors (10, r) lie in those of all rows."""
    span = ints_of(ints, at.SPAN_OF_ISLAND)
    first, end = span[i, at.FIRST_ROW], span[i + 1, at.FIRST_ROW]
    r = end - first
    offset = first * floats_of(floats, ints, at.MATRIX).shape[1]
    return Rows(
        floats_of(floats, ints, at.ROW)[first:end],
        ints_of(ints, at.ROW_BODY)[first:end],
        floats_of(floats, ints, at.REACH)[first:end],
        table_within(floats, ints[3 * at.MATRIX] + offset, r, r),
        table_within(floats, ints[3 * at.FACTOR] + offset, r, r),
        table_within(floats, ints[3 * at.VECTOR] + 10 * first, 10, r),
    )


@kernel
def take_jointed_island(floats: Floats, ints: Ints, i: int) -> None:
    """Copy the bodies, contacts and joints of island i into its own memory."""
    take_island(floats, ints, i)
    joint, joint_kind = island_joints(floats, ints, i)
    first, grouped, all_kinds = (
        ints_of(ints, at.SPAN_OF_ISLAND)[i, at.FIRST_JOINT],
        ints_of(ints, at.GROUPED_JOINT),
        ints_of(ints, at.JOINT_KIND),
    )
    all_joints = floats_of(floats, ints, at.JOINT)
    for k in range(joint.shape[0]):
        j = grouped[first + k, 0]
        copy_row(all_joints, j, joint, k)
        for c in range(joint_kind.shape[1]):
            if c not in (at.PARENT, at.CHILD):
                joint_kind[k, c] = all_kinds[j, c]
    clear_reactions(Joints(joint, joint_kind))


@kernel
def press_jointed_island(floats: Floats, ints: Ints, i: int, patience: int) -> bool:
    """Solve with the position error, drift, and relax island i. Returns: whether it is to bounce."""
    bodies, contacts = island_bodies(floats, ints, i), island_contacts(floats, ints, i)
    joints, rows = island_joints(floats, ints, i), island_rows(floats, ints, i)
    count, n, soft = ints_of(ints, at.COUNT), contacts.manifold.shape[0], softness_in(floats, ints)
    equalities, all_rows = write_rows(bodies, joints, rows, soft.h)
    share_loads(bodies, contacts, n, island_sums(floats, ints, i))
    warm_start(bodies, contacts, n)
    hold_joints(bodies, joints, rows, equalities, all_rows, NEW)
    # Where anything touches, all joints are held after each sweep: what one island does must not hang on how it was found.
    sweeps = patience if count[0, at.MANIFOLDS] > 0 else 0
    for _ in range(count[0, at.ITERATIONS] * sweeps):
        sweep(bodies, contacts, n, soft, PRESS)
        hold_joints(bodies, joints, rows, equalities, all_rows, KNOWN)
    for b in range(bodies.state.shape[0]):
        drift(bodies, b, soft.h, count[0, at.GYROSCOPIC])
    refresh(bodies.state, shapes_of(floats, ints), contacts, n)
    share_loads(bodies, contacts, n, island_sums(floats, ints, i))
    for _ in range(count[0, at.RELAXATIONS] * sweeps):
        sweep(bodies, contacts, n, soft, RELAX)
        hold_joints(bodies, joints, rows, equalities, all_rows, KNOWN)
    span = ints_of(ints, at.SPAN_OF_ISLAND)
    span[i, at.EQUALITIES], span[i, at.ROWS] = equalities, all_rows
    return bounce(contacts, n)


@kernel
def release_jointed_island(floats: Floats, ints: Ints, i: int, hit: int) -> None:
    """Restitution of island i, where any island was hit, and the end of the sub-step."""
    bodies, contacts = island_bodies(floats, ints, i), island_contacts(floats, ints, i)
    joints, rows = island_joints(floats, ints, i), island_rows(floats, ints, i)
    count, span = ints_of(ints, at.COUNT), ints_of(ints, at.SPAN_OF_ISLAND)
    n, soft = contacts.manifold.shape[0], softness_in(floats, ints)
    if hit == 1:
        for _ in range(FRESH * (count[0, at.ITERATIONS] + count[0, at.RELAXATIONS])):
            sweep(bodies, contacts, n, soft, REBOUND)
            hold_joints(bodies, joints, rows, span[i, at.EQUALITIES], span[i, at.ROWS], KNOWN)
    friction_mode(bodies, contacts, n)
    end_substep(contacts, n)
    keep_rotors(joints, rows, span[i, at.EQUALITIES])


@kernel
def give_jointed_island(floats: Floats, ints: Ints, i: int) -> None:
    """Copy the dynamic bodies, the contacts and the joints of island i back from its own memory."""
    give_island(floats, ints, i)
    joint = island_joints(floats, ints, i).joint
    first, grouped = ints_of(ints, at.SPAN_OF_ISLAND)[i, at.FIRST_JOINT], ints_of(ints, at.GROUPED_JOINT)
    all_joints = floats_of(floats, ints, at.JOINT)
    for k in range(joint.shape[0]):
        copy_row(joint, k, all_joints, grouped[first + k, 0])


@kernel
def advance_jointed_island(floats: Floats, ints: Ints, i: int, first: int, end: int, told: int) -> None:
    """The stages first..end - 1 of the step of island i, as `advance_island`."""
    span, last = ints_of(ints, at.SPAN_OF_ISLAND), 2 * ints_of(ints, at.COUNT)[0, at.SUBSTEPS]
    span[i, at.HIT] = 0
    if span[i, at.FIRST_LOCAL] == span[i + 1, at.FIRST_LOCAL]:
        return
    for stage in range(first, end):
        if stage % 2 == 1:
            span[i, at.HIT] = press_jointed_island(floats, ints, i, patience_of(ints, stage, told))
            told = 0
            continue
        if stage == 0:
            take_jointed_island(floats, ints, i)
        else:
            release_jointed_island(floats, ints, i, told)
        if stage < last:
            span[i, at.HIT] = kick_island(floats, ints, i) > 0
        else:
            give_jointed_island(floats, ints, i)
