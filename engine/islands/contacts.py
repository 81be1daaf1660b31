"""The contacts of one island, solved in memory of its own: what it reads and writes is apart from all other islands.

The sweeps are those of `step_contact` in the same order, so the bits are the same, whoever solves the island.
"""

from collections.abc import Callable
from typing import TypeVar

from plumbline.engine.compile.jit import kernel
from plumbline.engine.constrain.stages import BEGIN, END, KNOWN, NEW
from plumbline.engine.integrate.semi_implicit_euler import drift, kick
from plumbline.engine.maths.rows import Floats, Ints
from plumbline.engine.memory import arena as at
from plumbline.engine.memory.carve import floats_of, ints_of
from plumbline.engine.memory.tables import Bodies, Contacts, shapes_of
from plumbline.engine.respond.arms import refresh
from plumbline.engine.respond.share_loads import share_loads
from plumbline.engine.respond.soft import sweep
from plumbline.engine.respond.softness import FRESH, FRESH_JOINTED, PRESS, REBOUND, RELAX, Softness, slow_approach, softness_of
from plumbline.engine.respond.substep import approach, bounce, end_step, end_substep, friction_mode, warm_start

Table = TypeVar("Table", Floats, Ints)
Copy = Callable[[Floats, Ints, int], None]
Hold = Callable[[Floats, Ints, int, Bodies, int, float], None]


@kernel
def copy_row(source: Table, i: int, target: Table, k: int) -> None:
    """Row i of one table to row k of another of its width."""
    for c in range(target.shape[1]):
        target[k, c] = source[i, c]


@kernel
def island_bodies(floats: Floats, ints: Ints, i: int) -> Bodies:
    """The tables of the bodies of island i."""
    span = ints_of(ints, at.SPAN_OF_ISLAND)
    first, end = span[i, at.FIRST_LOCAL], span[i + 1, at.FIRST_LOCAL]
    return Bodies(
        floats_of(floats, ints, at.LOCAL_STATE)[first:end],
        floats_of(floats, ints, at.LOCAL_BODY)[first:end],
        floats_of(floats, ints, at.LOCAL_TURNED)[first:end],
        floats_of(floats, ints, at.LOCAL_LOAD)[first:end],
        ints_of(ints, at.LOCAL_KIND)[first:end],
    )


@kernel
def island_contacts(floats: Floats, ints: Ints, i: int) -> Contacts:
    """The tables of the contacts of island i. The last step's, which are done with, hold them."""
    span = ints_of(ints, at.SPAN_OF_ISLAND)
    first, end = span[i, at.FIRST_MANIFOLD], span[i + 1, at.FIRST_MANIFOLD]
    return Contacts(
        floats_of(floats, ints, at.OLD_MANIFOLD)[first:end],
        floats_of(floats, ints, at.OLD_POINT)[4 * first : 4 * end],
        ints_of(ints, at.OLD_KEY)[first:end],
        ints_of(ints, at.OLD_POINT_KEY)[4 * first : 4 * end],
    )


@kernel
def island_sums(floats: Floats, ints: Ints, i: int) -> Floats:
    """Room for `share_loads` of island i."""
    span = ints_of(ints, at.SPAN_OF_ISLAND)
    return floats_of(floats, ints, at.LOCAL_SUMS)[span[i, at.FIRST_LOCAL] : span[i + 1, at.FIRST_LOCAL]]


@kernel
def softness_in(floats: Floats, ints: Ints) -> Softness:
    """The softness of contacts over a sub-step."""
    setting = floats_of(floats, ints, at.SETTING)
    return softness_of(setting, setting[0, at.DT] / ints_of(ints, at.COUNT)[0, at.SUBSTEPS])


@kernel
def patience_of(ints: Ints, stage: int, strikes: int) -> int:
    """Times as many sweeps: after a blow anywhere, and in the first sub-step with a new contact anywhere."""
    if strikes != 1 and (stage != 1 or ints_of(ints, at.TALLY)[0, at.AROUSED] == 0):
        return 1
    return FRESH_JOINTED if ints_of(ints, at.COUNT)[0, at.JOINTS] > 0 else FRESH


@kernel
def take_island(floats: Floats, ints: Ints, i: int) -> None:
    """Copy the bodies and contacts of island i into its own memory."""
    state, body, turned, load, kind = island_bodies(floats, ints, i)
    manifold, point, key, _ = island_contacts(floats, ints, i)
    span, owner, grouped = ints_of(ints, at.SPAN_OF_ISLAND), ints_of(ints, at.LOCAL_OWNER), ints_of(ints, at.GROUPED)
    first = span[i, at.FIRST_LOCAL]
    all_states, all_bodies = floats_of(floats, ints, at.STATE), floats_of(floats, ints, at.BODY)
    all_kinds = ints_of(ints, at.BODY_KIND)
    all_turned, all_loads = floats_of(floats, ints, at.TURNED), floats_of(floats, ints, at.LOAD)
    for r in range(state.shape[0]):
        b = owner[first + r, 0]
        copy_row(all_states, b, state, r)
        copy_row(all_bodies, b, body, r)
        copy_row(all_turned, b, turned, r)
        copy_row(all_loads, b, load, r)
        copy_row(all_kinds, b, kind, r)
    all_manifolds, all_points = floats_of(floats, ints, at.MANIFOLD), floats_of(floats, ints, at.POINT)
    all_keys = ints_of(ints, at.MANIFOLD_KEY)
    first = span[i, at.FIRST_MANIFOLD]
    for k in range(manifold.shape[0]):
        m = grouped[first + k, 0]
        copy_row(all_manifolds, m, manifold, k)
        for c in range(key.shape[1]):
            if c not in (at.BODY_A, at.BODY_B):
                key[k, c] = all_keys[m, c]
        for p in range(key[k, at.POINTS]):
            copy_row(all_points, 4 * m + p, point, 4 * k + p)


@kernel
def kick_island(floats: Floats, ints: Ints, i: int) -> int:
    """Begin a sub-step of island i: gravity and loads. Returns: how many points are about to strike."""
    bodies, contacts = island_bodies(floats, ints, i), island_contacts(floats, ints, i)
    setting, h = floats_of(floats, ints, at.SETTING), softness_in(floats, ints).h
    for b in range(bodies.state.shape[0]):
        kick(bodies, setting, b, h)
    return int(approach(bodies, contacts, contacts.manifold.shape[0], setting, h, slow_approach(setting, h)))


@kernel
def hold_nothing(_floats: Floats, _ints: Ints, _i: int, _bodies: Bodies, _stage: int, _h: float) -> None:
    """There are no joints."""
    return


@kernel
def press_island(floats: Floats, ints: Ints, i: int, patience: int, hold: Hold) -> bool:
    """Solve with the position error, drift, and relax island i. Returns: whether it is to bounce."""
    bodies, contacts = island_bodies(floats, ints, i), island_contacts(floats, ints, i)
    count, n, soft = ints_of(ints, at.COUNT), contacts.manifold.shape[0], softness_in(floats, ints)
    hold(floats, ints, i, bodies, BEGIN, soft.h)
    share_loads(bodies, contacts, n, island_sums(floats, ints, i))
    warm_start(bodies, contacts, n)
    hold(floats, ints, i, bodies, NEW, soft.h)
    # Where anything touches, all joints are held after each sweep: what one island does must not hang on how it was found.
    sweeps = patience if count[0, at.MANIFOLDS] > 0 else 0
    for _ in range(count[0, at.ITERATIONS] * sweeps):
        sweep(bodies, contacts, n, soft, PRESS)
        hold(floats, ints, i, bodies, KNOWN, soft.h)
    for b in range(bodies.state.shape[0]):
        drift(bodies, b, soft.h, count[0, at.GYROSCOPIC])
    refresh(bodies.state, shapes_of(floats, ints), contacts, n)
    share_loads(bodies, contacts, n, island_sums(floats, ints, i))
    for _ in range(count[0, at.RELAXATIONS] * sweeps):
        sweep(bodies, contacts, n, soft, RELAX)
        hold(floats, ints, i, bodies, KNOWN, soft.h)
    return bounce(contacts, n)


@kernel
def release_island(floats: Floats, ints: Ints, i: int, hit: int, hold: Hold) -> None:
    """Restitution of island i, where any was hit, and the end of the sub-step."""
    bodies, contacts, count = island_bodies(floats, ints, i), island_contacts(floats, ints, i), ints_of(ints, at.COUNT)
    n, soft = contacts.manifold.shape[0], softness_in(floats, ints)
    if hit == 1:
        for _ in range(FRESH * (count[0, at.ITERATIONS] + count[0, at.RELAXATIONS])):
            sweep(bodies, contacts, n, soft, REBOUND)
            hold(floats, ints, i, bodies, KNOWN, soft.h)
    friction_mode(bodies, contacts, n)
    end_substep(contacts, n)
    hold(floats, ints, i, bodies, END, soft.h)


@kernel
def give_island(floats: Floats, ints: Ints, i: int) -> None:
    """End the step of island i, and copy its dynamic bodies and its contacts back from its own memory."""
    state, _, turned, _, kind = island_bodies(floats, ints, i)
    contacts = island_contacts(floats, ints, i)
    manifold, point, key, _ = contacts
    span, owner, grouped = ints_of(ints, at.SPAN_OF_ISLAND), ints_of(ints, at.LOCAL_OWNER), ints_of(ints, at.GROUPED)
    first = span[i, at.FIRST_LOCAL]
    all_states, all_turned = floats_of(floats, ints, at.STATE), floats_of(floats, ints, at.TURNED)
    for r in range(state.shape[0]):
        if kind[r, at.MOTION] == at.DYNAMIC:
            copy_row(state, r, all_states, owner[first + r, 0])
            copy_row(turned, r, all_turned, owner[first + r, 0])
    all_manifolds, all_points = floats_of(floats, ints, at.MANIFOLD), floats_of(floats, ints, at.POINT)
    all_keys = ints_of(ints, at.MANIFOLD_KEY)
    end_step(contacts, manifold.shape[0])
    first = span[i, at.FIRST_MANIFOLD]
    for k in range(manifold.shape[0]):
        m = grouped[first + k, 0]
        copy_row(manifold, k, all_manifolds, m)
        for c in range(key.shape[1]):
            if c not in (at.BODY_A, at.BODY_B):
                all_keys[m, c] = key[k, c]
        for p in range(key[k, at.POINTS]):
            copy_row(point, 4 * k + p, all_points, 4 * m + p)


@kernel
def advance_stages(
    floats: Floats, ints: Ints, i: int, stages: tuple[int, int], told: int, take: Copy, hold: Hold, give: Copy
) -> None:
    """Some stages of the step of island i.

    Sub-step s begins in stage 2 s, which also ends the one before it, and is solved in stage 2 s + 1; one more stage ends the
    last. All that islands have to know of each other stands between two stages, and is `told`: whether any of them strikes
    before a sub-step is solved, and whether any is to bounce before it ends.

    Args: stages: their first and end; take, give: copy the island into its own memory and back; hold: holds its joints in a
        stage of a sub-step.
    """
    span, last = ints_of(ints, at.SPAN_OF_ISLAND), 2 * ints_of(ints, at.COUNT)[0, at.SUBSTEPS]
    span[i, at.HIT] = 0
    if span[i, at.FIRST_LOCAL] == span[i + 1, at.FIRST_LOCAL]:
        return
    for stage in range(stages[0], stages[1]):
        if stage % 2 == 1:
            span[i, at.HIT] = press_island(floats, ints, i, patience_of(ints, stage, told), hold)
            told = 0
            continue
        if stage == 0:
            take(floats, ints, i)
        else:
            release_island(floats, ints, i, told, hold)
        if stage < last:
            span[i, at.HIT] = kick_island(floats, ints, i) > 0
        else:
            give(floats, ints, i)


@kernel
def advance_island(floats: Floats, ints: Ints, i: int, first: int, end: int, told: int) -> None:
    """As `advance_stages`, of contacts alone."""
    advance_stages(floats, ints, i, (first, end), told, take_island, hold_nothing, give_island)
