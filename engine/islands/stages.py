"""A step island by island: find contacts, wake, group; solve the islands in turn or on several threads; let them sleep."""

from collections.abc import Callable

from numba import prange

from plumbline.engine.compile.jit import kernel, template
from plumbline.engine.constrain.stages import Held
from plumbline.engine.contact.find_contacts import find_contacts, keep_contacts
from plumbline.engine.integrate.all_bodies import advance_untouched
from plumbline.engine.integrate.semi_implicit_euler import drift
from plumbline.engine.islands.contacts import advance_island
from plumbline.engine.islands.islands import (
    connect,
    ends_of,
    group_bodies,
    group_links,
    linked_by_contacts,
    linked_by_joints,
    number_islands,
    share,
    start_islands,
)
from plumbline.engine.islands.sleep import fall_asleep, mark_changed, mark_touched, remember, wake_marked
from plumbline.engine.maths.rows import Floats, Ints
from plumbline.engine.memory import arena as at
from plumbline.engine.memory.carve import floats_of, ints_of
from plumbline.engine.memory.status import DIVERGED, DONE, FULL
from plumbline.engine.memory.tables import bodies_of
from plumbline.engine.steps.count_step import count_step


@kernel
def skip_sleep(floats: Floats, ints: Ints, steps: int) -> int:
    """Let `steps` steps pass in which all bodies sleep and no fixed body moves. Returns: 1, or 0 if there is work to do."""
    tally, sleep = ints_of(ints, at.TALLY), floats_of(floats, ints, at.SLEEP)
    if sleep[0, at.SLEEP_TIME] == 0.0 or tally[0, at.AWAKE] > 0 or ints_of(ints, at.COUNT)[0, at.STEPS] == 0:
        return 0
    if mark_changed(floats, ints) > 0 or tally[0, at.RESTLESS_BODIES] > 0:
        return 0
    ints_of(ints, at.COUNT)[0, at.STEPS] += steps
    return 1


@kernel
def meet(floats: Floats, ints: Ints, keeping: bool) -> int:
    """Keep or find the contacts of this step, until none of them reaches a body asleep. Returns: as `begin_islands`."""
    count, tally = ints_of(ints, at.COUNT), ints_of(ints, at.TALLY)
    sleeps = floats_of(floats, ints, at.SLEEP)[0, at.SLEEP_TIME] > 0.0
    searching = not keeping or not keep_contacts(floats, ints)
    while True:
        if searching:
            status = find_contacts(floats, ints)
            if status != DONE:
                return status
            tally[0, at.AROUSED] += count[0, at.NEW]
        if not sleeps or mark_touched(floats, ints) == 0:
            return DONE
        if wake_marked(floats, ints) == FULL:
            return FULL
        searching = True


@kernel
def begin_islands(floats: Floats, ints: Ints, keeping: bool) -> int:
    """Find the contacts of this step, wake whom they reach, move the bodies that nothing touches, and group the others.

    Args: keeping: whether to keep the contacts of the last step where all bodies are still.
    Returns: as `find_contacts`, or SEARCH_PENDING if pairs must be found anew before the step, since bodies woke.
    """
    bodies, setting = bodies_of(floats, ints), floats_of(floats, ints, at.SETTING)
    kind, count, tally = bodies.kind, ints_of(ints, at.COUNT), ints_of(ints, at.TALLY)
    last = count[0, at.BODIES]
    if floats_of(floats, ints, at.SLEEP)[0, at.SLEEP_TIME] > 0.0:
        mark_changed(floats, ints)
        if wake_marked(floats, ints) == FULL:
            return FULL
    status = meet(floats, ints, keeping)
    if status != DONE:
        return status
    joint_kind = ints_of(ints, at.JOINT_KIND)
    for j in range(count[0, at.JOINTS]):
        if kind[joint_kind[j, at.PARENT], at.MOTION] == at.DYNAMIC or kind[joint_kind[j, at.CHILD], at.MOTION] == at.DYNAMIC:
            kind[joint_kind[j, at.PARENT], at.TOUCHED] = 1
            kind[joint_kind[j, at.CHILD], at.TOUCHED] = 1
    advance_untouched(bodies, setting, count, ints_of(ints, at.BODY_ORDER))
    contacts, joints = linked_by_contacts(ints), linked_by_joints(ints)
    island, span = ints_of(ints, at.ISLAND), ints_of(ints, at.SPAN_OF_ISLAND)
    start_islands(island, last + 1)
    for links in (contacts, joints):
        for k in range(len(links.bodies)):
            a, b = ends_of(links, k)
            connect(island, kind, a, b)
    n = number_islands(island, kind, last)
    group_bodies(island, kind, ints_of(ints, at.BODY_ORDER), span, n)
    group_links(island, span, n, contacts, at.FIRST_MANIFOLD)
    group_links(island, span, n, joints, at.FIRST_JOINT)
    manifold = floats_of(floats, ints, at.MANIFOLD)
    tally[0, at.ISLANDS], tally[0, at.ELASTIC] = n, 0
    for m in range(count[0, at.MANIFOLDS]):
        if manifold[m, at.LAW + 2] > 0.0:
            tally[0, at.ELASTIC] = 1
    return DONE


@kernel
def next_meeting(ints: Ints, stage: int) -> int:
    """The stage before which all islands must have told each other what they met with since `stage`.

    They do so before a sub-step is solved where there are joints, whose sweeps a blow anywhere multiplies; before it ends where
    surfaces bounce; and kinematic bodies are carried on before each is solved. Elsewhere no island asks for another.
    """
    count, tally, kind = ints_of(ints, at.COUNT), ints_of(ints, at.TALLY), ints_of(ints, at.BODY_KIND)
    if tally[0, at.ELASTIC] == 1:
        return stage + 1
    carried = count[0, at.JOINTS] > 0
    for b in range(count[0, at.BODIES]):
        carried |= kind[b, at.TOUCHED] == 1 and kind[b, at.MOTION] == at.KINEMATIC
    if not carried:
        return int(2 * count[0, at.SUBSTEPS] + 1)
    return stage + 1 if stage % 2 == 0 else stage + 2


@kernel
def any_hit(ints: Ints) -> int:
    """1 if any island has something to tell."""
    span, hit = ints_of(ints, at.SPAN_OF_ISLAND), 0
    for i in range(ints_of(ints, at.TALLY)[0, at.ISLANDS]):
        hit |= span[i, at.HIT]
    return hit


@kernel
def carry_kinematic(floats: Floats, ints: Ints) -> None:
    """Move the kinematic bodies that islands lean on by a sub-step, before any of them is solved."""
    bodies, count = bodies_of(floats, ints), ints_of(ints, at.COUNT)
    h = floats_of(floats, ints, at.SETTING)[0, at.DT] / count[0, at.SUBSTEPS]
    for b in range(count[0, at.BODIES]):
        if bodies.kind[b, at.TOUCHED] == 1 and bodies.kind[b, at.MOTION] == at.KINEMATIC:
            drift(bodies, b, h, count[0, at.GYROSCOPIC])


@kernel
def end_islands(floats: Floats, ints: Ints) -> int:
    """Count the step, and let calm islands sleep. Returns: DONE, or DIVERGED, or FULL."""
    count, tally = ints_of(ints, at.COUNT), ints_of(ints, at.TALLY)
    tally[0, at.AROUSED] = 0
    if count_step(floats_of(floats, ints, at.STATE), count) == DIVERGED:
        return DIVERGED
    if floats_of(floats, ints, at.SLEEP)[0, at.SLEEP_TIME] == 0.0:
        return DONE
    status = fall_asleep(floats, ints)
    remember(floats, ints)
    return status


@template
def in_turn(floats: Floats, ints: Ints, holding: Callable[..., Held], first: int, end: int, hit: int) -> None:
    """Advance all islands, one after the other."""
    for i in range(ints_of(ints, at.TALLY)[0, at.ISLANDS]):
        advance_island(floats, ints, i, first, end, hit, holding)


@template
def on_threads(floats: Floats, ints: Ints, holding: Callable[..., Held], first: int, end: int, hit: int) -> None:
    """As `in_turn`, to the last bit, with neighbouring islands of about as many contacts on each thread."""
    span, tally = ints_of(ints, at.SPAN_OF_ISLAND), ints_of(ints, at.TALLY)
    for t in prange(tally[0, at.THREADS]):
        for i in range(share(span, tally, t), share(span, tally, t + 1)):
            advance_island(floats, ints, i, first, end, hit, holding)


@template
def step_by_islands(
    floats: Floats,
    ints: Ints,
    steps: int,
    begin: Callable[[Floats, Ints], int],
    run: Callable[..., None],
    holding: Callable[..., Held],
) -> tuple[int, int]:
    """Advance a world by `steps` steps.

    They meet where one has something to tell the others: see `next_meeting`.

    Args: begin: finds the contacts of a step and groups the bodies, as `begin_islands`; run: `in_turn` or `on_threads`;
        holding: holds joints, as `hold`.
    Returns: steps done, and the status of the last one.
    """
    stages = ints_of(ints, at.COUNT)[0, at.SUBSTEPS] * 2 + 1
    for step in range(steps):
        if skip_sleep(floats, ints, steps - step):
            return steps, DONE
        status = begin(floats, ints)
        if status != DONE:
            return step, status
        first, hit = 0, 0
        while first < stages:
            end = next_meeting(ints, first)
            if first % 2 == 1:
                carry_kinematic(floats, ints)
            run(floats, ints, holding, first, end, hit)
            first, hit = end, any_hit(ints)
        status = end_islands(floats, ints)
        if status != DONE:
            return step + 1, status
    return steps, DONE
