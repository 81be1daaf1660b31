"""The contacts and joints of one island, solved in memory of its own, as `contacts` does for contacts alone.

Each island has its own matrix, so that the direct solve costs the sum of the cubes of the islands' rows and not the cube of
their sum.
"""

from plumbline.engine.compile.jit import kernel
from plumbline.engine.constrain.hold_joints import hold
from plumbline.engine.constrain.reactions import clear_reactions
from plumbline.engine.islands.contacts import advance_stages, copy_row, give_island, take_island
from plumbline.engine.maths.rows import Floats, Ints
from plumbline.engine.memory import arena as at
from plumbline.engine.memory.carve import floats_of, ints_of, table_within
from plumbline.engine.memory.tables import Bodies, Joints, Rows

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
    first, grouped = ints_of(ints, at.SPAN_OF_ISLAND)[i, at.FIRST_JOINT], ints_of(ints, at.GROUPED_JOINT)
    all_kinds = ints_of(ints, at.JOINT_KIND)
    all_joints = floats_of(floats, ints, at.JOINT)
    for k in range(joint.shape[0]):
        j = grouped[first + k, 0]
        copy_row(all_joints, j, joint, k)
        for c in range(joint_kind.shape[1]):
            if c not in (at.PARENT, at.CHILD):
                joint_kind[k, c] = all_kinds[j, c]
    clear_reactions(Joints(joint, joint_kind))


@kernel
def hold_island(floats: Floats, ints: Ints, i: int, bodies: Bodies, stage: int, h: float) -> None:
    """As `hold`, the joints of island i."""
    span = ints_of(ints, at.SPAN_OF_ISLAND)
    held = span[i, at.EQUALITIES], span[i, at.ROWS]
    held = hold(bodies, island_joints(floats, ints, i), island_rows(floats, ints, i), held, stage, h)
    span[i, at.EQUALITIES], span[i, at.ROWS] = held


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
    """As `advance_stages`, of contacts and joints."""
    advance_stages(floats, ints, i, (first, end), told, take_jointed_island, hold_island, give_jointed_island)
