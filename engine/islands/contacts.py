"""An island as ranges of bodies, contacts and joints, and its step in stages: what it moves is apart from all other islands.

The sweeps are those of a whole world in the same order, so the bits are the same, whoever solves the island. Each
has its own matrix of joints, so that the direct solve costs the sum of the cubes of the islands' rows and not that of the sum.
"""

from collections.abc import Callable

from plumbline.engine.compile.jit import inlined, kernel
from plumbline.engine.constrain.stages import Held
from plumbline.engine.maths.rows import Floats, Ints
from plumbline.engine.memory import arena as at
from plumbline.engine.memory.carve import floats_of, ints_of, table_within
from plumbline.engine.memory.tables import Joints, Rows, bodies_of, contacts_of, in_order, joints_of, some_contacts
from plumbline.engine.respond.manifold_sweeps import as_found
from plumbline.engine.respond.share_loads import list_sharing
from plumbline.engine.respond.softness import softness_of
from plumbline.engine.respond.substep import end_step
from plumbline.engine.steps.stages import Group, begin_island, effort_of, release_island, solve_island

ROOM = (9, 6, 8, 8, 4)
"""The most rows of a joint of each type: its equalities, and one each for limits, spring and drive; what else it has adds."""


@kernel
def make_room_for_rows(ints: Ints) -> None:
    """Write where the rows of every island's joints begin."""
    span, joint_kind, order = ints_of(ints, at.SPAN_OF_ISLAND), ints_of(ints, at.JOINT_KIND), ints_of(ints, at.JOINT_ORDER)
    row, islands = 0, ints_of(ints, at.TALLY)[0, at.ISLANDS]
    for i in range(islands):
        span[i, at.FIRST_ROW] = row
        for rank in range(span[i, at.FIRST_JOINT], span[i + 1, at.FIRST_JOINT]):
            kind, has = joint_kind[order[rank, 0], at.JOINT_TYPE], joint_kind[order[rank, 0], at.HAS]
            row += ROOM[kind] + (has & at.HAS_ARMATURE != 0) + (has & at.HAS_FRICTION != 0)
            row += 2 * (has & at.HAS_SPEED_LIMIT != 0)
    span[islands, at.FIRST_ROW] = row


@inlined
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


@inlined
def island_group(floats: Floats, ints: Ints, i: int) -> Group:
    """What island i is made of."""
    span, joints, bodies = ints_of(ints, at.SPAN_OF_ISLAND), joints_of(floats, ints), bodies_of(floats, ints)
    order = joints.order[span[i, at.FIRST_JOINT] : span[i + 1, at.FIRST_JOINT]]
    first, end, sums = span[i, at.FIRST_MANIFOLD], span[i + 1, at.FIRST_MANIFOLD], floats_of(floats, ints, at.START)
    contacts, room = some_contacts(contacts_of(floats, ints), first, end), ints_of(ints, at.SHARING)[first:end]
    return Group(
        bodies,
        ints_of(ints, at.BODY_ORDER)[span[i, at.FIRST_BODY] : span[i + 1, at.FIRST_BODY]],
        contacts,
        in_order(contacts, room[: list_sharing(bodies, contacts, sums, room)]),
        Joints(joints.joint, joints.kind, order),
        island_rows(floats, ints, i),
        sums,
        ints_of(ints, at.HURRIED)[first:end],
    )


@kernel
def advance_island(floats: Floats, ints: Ints, i: int, first: int, end: int, told: int, holding: Callable[..., Held]) -> None:
    """The stages first..end - 1 of the step of island i.

    Sub-step s begins in stage 2 s, which also ends the one before it, and is solved in stage 2 s + 1; one more stage ends the
    last. All that islands have to know of each other stands between two stages, and is `told`: whether any of them strikes
    before a sub-step is solved, and whether any is to rebound before it ends.
    """
    span, count, setting = ints_of(ints, at.SPAN_OF_ISLAND), ints_of(ints, at.COUNT), floats_of(floats, ints, at.SETTING)
    span[i, at.HIT] = 0
    if span[i, at.FIRST_BODY] == span[i + 1, at.FIRST_BODY]:
        return
    group, soft = island_group(floats, ints, i), softness_of(setting, setting[0, at.DT] / count[0, at.SUBSTEPS])
    for stage in range(first, end):
        held = span[i, at.EQUALITIES], span[i, at.ROWS]
        if stage % 2 == 1:
            # Where anything touches, all joints are held after each sweep: no island hangs on how it was found.
            fresh = stage == 1 and ints_of(ints, at.TALLY)[0, at.AROUSED] > 0
            effort = effort_of(group, count, fresh, told == 1 or count[0, at.JOINTS] == 0)
            span[i, at.HIT] = solve_island(floats, ints, group, held, soft, effort, as_found, holding)
            told = 0
            continue
        if stage > 0:
            release_island(floats, ints, group, held, soft, told == 1, as_found, holding)
        if stage < 2 * count[0, at.SUBSTEPS]:
            strikes, held = begin_island(group, setting, held, soft, holding)
            span[i, at.HIT] = strikes > 0
            span[i, at.EQUALITIES], span[i, at.ROWS] = held
        else:
            end_step(group.contacts)
