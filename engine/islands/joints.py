"""The contacts and joints of one island, solved in memory of its own, as `contacts` does for contacts alone.

Each island has its own matrix, so that the direct solve costs the sum of the cubes of the islands' rows and not the cube of
their sum.
"""

from engine.compile.jit import kernel
from engine.constrain.hold_joints import KNOWN, NEW, hold_joints, write_rows
from engine.integrate.semi_implicit_euler import drift
from engine.islands.contacts import (
    contacts_of,
    copy_row,
    give_island,
    island_bodies,
    kick_island,
    patience_of,
    substep_of,
    take_island,
)
from engine.maths.vec import Floats, Ints
from engine.memory.arena import (
    CHILD,
    COUNT,
    DAMPING_RATIO,
    EQUALITIES,
    FACTOR,
    FIRST_JOINT,
    FIRST_LOCAL,
    FIRST_ROW,
    GROUPED_JOINT,
    GYROSCOPIC,
    HERTZ,
    HIT,
    ISLANDS,
    ITERATIONS,
    JOINT,
    JOINT_KIND,
    JOINT_TYPE,
    LOCAL_JOINT,
    LOCAL_JOINT_KIND,
    MANIFOLDS,
    MATRIX,
    MAX_PUSH,
    PARENT,
    REACH,
    RELAXATIONS,
    ROW,
    ROW_BODY,
    ROWS,
    SETTING,
    SPAN_OF_ISLAND,
    SUBSTEPS,
    TALLY,
    VECTOR,
)  # fmt: skip
from engine.memory.carve import floats_of, ints_of
from engine.memory.tables import Joints, Rows
from engine.respond.soft import bounce, end_substep, friction_mode, refresh, sweep, warm_start
from engine.steps.contact import FRESH, soft_factors

__all__ = ["advance_jointed_island", "make_room_for_rows"]

ROOM = (9, 6, 8, 8, 4)
"""The most rows of a joint of each type: its equalities, and one each for limits, spring and drive."""


@kernel
def make_room_for_rows(ints: Ints) -> None:
    """Write where the rows of every island begin."""
    span, joint_kind = ints_of(ints, SPAN_OF_ISLAND), ints_of(ints, JOINT_KIND)
    grouped, islands = ints_of(ints, GROUPED_JOINT), ints_of(ints, TALLY)[0, ISLANDS]
    row = 0
    for i in range(islands):
        span[i, FIRST_ROW] = row
        for at in range(span[i, FIRST_JOINT], span[i + 1, FIRST_JOINT]):
            row += ROOM[joint_kind[grouped[at, 0], JOINT_TYPE]]
    span[islands, FIRST_ROW] = row


@kernel
def island_joints(floats: Floats, ints: Ints, i: int) -> Joints:
    """The tables of the joints of island i."""
    span = ints_of(ints, SPAN_OF_ISLAND)
    first, end = span[i, FIRST_JOINT], span[i + 1, FIRST_JOINT]
    return Joints(floats_of(floats, ints, LOCAL_JOINT)[first:end], ints_of(ints, LOCAL_JOINT_KIND)[first:end])


@kernel
def island_rows(floats: Floats, ints: Ints, i: int) -> Rows:
    """The tables of the r rows of island i: matrix (r, r), factor (r, r) and vectors (10, r) lie in those of all rows."""
    span = ints_of(ints, SPAN_OF_ISLAND)
    first, end = span[i, FIRST_ROW], span[i + 1, FIRST_ROW]
    r = end - first
    matrix, factor, vector = floats_of(floats, ints, MATRIX), floats_of(floats, ints, FACTOR), floats_of(floats, ints, VECTOR)
    at = first * matrix.shape[1]
    return Rows(
        floats_of(floats, ints, ROW)[first:end],
        ints_of(ints, ROW_BODY)[first:end],
        floats_of(floats, ints, REACH)[first:end],
        matrix.reshape(-1)[at : at + r * r].reshape((r, r)),
        factor.reshape(-1)[at : at + r * r].reshape((r, r)),
        vector.reshape(-1)[10 * first : 10 * (first + r)].reshape((10, r)),
    )


@kernel
def take_jointed_island(floats: Floats, ints: Ints, i: int) -> None:
    """Copy the bodies, contacts and joints of island i into its own memory."""
    take_island(floats, ints, i)
    joint, joint_kind = island_joints(floats, ints, i)
    first, grouped, all_kinds = (
        ints_of(ints, SPAN_OF_ISLAND)[i, FIRST_JOINT],
        ints_of(ints, GROUPED_JOINT),
        ints_of(ints, JOINT_KIND),
    )
    all_joints = floats_of(floats, ints, JOINT)
    for k in range(joint.shape[0]):
        j = grouped[first + k, 0]
        copy_row(all_joints, j, joint, k)
        for c in range(joint_kind.shape[1]):
            if c not in (PARENT, CHILD):
                joint_kind[k, c] = all_kinds[j, c]


@kernel
def press_jointed_island(floats: Floats, ints: Ints, i: int, patience: int) -> bool:
    """Solve with the position error, drift, and relax island i. Returns: whether it is to bounce."""
    bodies, joints, rows = island_bodies(floats, ints, i), island_joints(floats, ints, i), island_rows(floats, ints, i)
    state, body, turned, _, _ = bodies
    manifold, point, key = contacts_of(floats, ints, i)
    setting, count, span = floats_of(floats, ints, SETTING), ints_of(ints, COUNT), ints_of(ints, SPAN_OF_ISLAND)
    n, h, most = manifold.shape[0], substep_of(floats, ints), setting[0, MAX_PUSH]
    rate, mass_scale, keep = soft_factors(setting[0, HERTZ], setting[0, DAMPING_RATIO], h)
    equalities, every = write_rows(bodies, joints, rows, h)
    warm_start(state, body, turned, n, manifold, key, point)
    hold_joints(bodies, rows, equalities, every, NEW)
    # Where anything touches, all joints are held after each sweep: what one island does must not hang on how it was found.
    sweeps = patience if count[0, MANIFOLDS] > 0 else 0
    for _ in range(count[0, ITERATIONS] * sweeps):
        sweep(state, body, turned, n, manifold, key, point, h, rate, mass_scale, keep, most, 1, 0)
        hold_joints(bodies, rows, equalities, every, KNOWN)
    for b in range(state.shape[0]):
        drift(bodies, b, h, count[0, GYROSCOPIC])
    refresh(state, 0, n, manifold, key, point)
    for _ in range(count[0, RELAXATIONS] * sweeps):
        sweep(state, body, turned, n, manifold, key, point, h, rate, mass_scale, keep, most, 0, 0)
        hold_joints(bodies, rows, equalities, every, KNOWN)
    span[i, EQUALITIES], span[i, ROWS] = equalities, every
    return bounce(n, manifold, key, point)


@kernel
def release_jointed_island(floats: Floats, ints: Ints, i: int, hit: int) -> None:
    """Restitution of island i, where any island was hit, and the end of the sub-step."""
    bodies, rows = island_bodies(floats, ints, i), island_rows(floats, ints, i)
    state, body, turned, _, _ = bodies
    manifold, point, key = contacts_of(floats, ints, i)
    setting, count, span = floats_of(floats, ints, SETTING), ints_of(ints, COUNT), ints_of(ints, SPAN_OF_ISLAND)
    n, h = manifold.shape[0], substep_of(floats, ints)
    rate, mass_scale, keep = soft_factors(setting[0, HERTZ], setting[0, DAMPING_RATIO], h)
    if hit == 1:
        for _ in range(FRESH * (count[0, ITERATIONS] + count[0, RELAXATIONS])):
            sweep(state, body, turned, n, manifold, key, point, h, rate, mass_scale, keep, setting[0, MAX_PUSH], 0, 1)
            hold_joints(bodies, rows, span[i, EQUALITIES], span[i, ROWS], KNOWN)
    friction_mode(state, body, n, manifold, key, point)
    end_substep(n, key, point)


@kernel
def give_jointed_island(floats: Floats, ints: Ints, i: int) -> None:
    """Copy the dynamic bodies, the contacts and the joints of island i back from its own memory."""
    give_island(floats, ints, i)
    joint = island_joints(floats, ints, i).joint
    first, grouped = ints_of(ints, SPAN_OF_ISLAND)[i, FIRST_JOINT], ints_of(ints, GROUPED_JOINT)
    all_joints = floats_of(floats, ints, JOINT)
    for k in range(joint.shape[0]):
        copy_row(joint, k, all_joints, grouped[first + k, 0])


@kernel
def advance_jointed_island(floats: Floats, ints: Ints, i: int, first: int, end: int, told: int) -> None:
    """The stages first..end - 1 of the step of island i, as `advance_island`."""
    span, last = ints_of(ints, SPAN_OF_ISLAND), 2 * ints_of(ints, COUNT)[0, SUBSTEPS]
    span[i, HIT] = 0
    if span[i, FIRST_LOCAL] == span[i + 1, FIRST_LOCAL]:
        return
    for stage in range(first, end):
        if stage % 2 == 1:
            span[i, HIT] = press_jointed_island(floats, ints, i, patience_of(ints, stage, told))
            told = 0
            continue
        if stage == 0:
            take_jointed_island(floats, ints, i)
        else:
            release_jointed_island(floats, ints, i, told)
        if stage < last:
            span[i, HIT] = kick_island(floats, ints, i) > 0
        else:
            give_jointed_island(floats, ints, i)
