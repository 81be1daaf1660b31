"""Islands that have come to rest stand still until something outside of them changes.

An island falls asleep when each of its bodies has had a kinetic energy below m s^2 / 2, with the speed s of the options, for
their whole sleep_time, and no fixed body that moves is near. Its bodies then count as static, with no velocity, so that no
stage of a step has work with them; its contacts are moved aside with the forces they had. It wakes as a whole, in the step
in which

* one of its bodies gets a contact with an awake body,
* the load on one of its bodies, or its state, is changed from outside,
* a static or kinematic body that it leans on, or whose bounds meet those of one of its bodies, moves or was moved.

Contacts that it wakes with start from the impulses that they fell asleep with.

Source: Catto, Box2D, 2007 (islands, sleep); Schmidl, Optimization-Based Animation, 2002 (freezing by kinetic energy).
"""

import math

from plumbline.engine.compile.jit import kernel
from plumbline.engine.contact.warm_starting import copy_contact
from plumbline.engine.integrate.semi_implicit_euler import angular_momentum
from plumbline.engine.maths.rows import Floats, Ints, load3, store3
from plumbline.engine.maths.vec import dot
from plumbline.engine.memory import arena as at
from plumbline.engine.memory.carve import floats_of, ints_of
from plumbline.engine.memory.status import DONE, FULL
from plumbline.engine.memory.tables import Contacts, contacts_of


@kernel
def mark(island: Ints, b: int) -> int:
    """Let the island of body b wake. Returns: 1 if b slept."""
    if island[b, at.ASLEEP] == 0:
        return 0
    island[island[b, at.ASLEEP] - 1, at.WAKES] = 1
    return 1


@kernel
def has_changed(state: Floats, load: Floats, remembered: Floats, b: int) -> bool:
    """Whether the state of body b or the load on it is not that of the last step's end."""
    changed = False
    for c in range(13):
        changed = changed or state[b, c] != remembered[b, c]
    for c in range(6):
        changed = changed or load[b, c] != remembered[b, 13 + c]
    return changed


@kernel
def is_moving(state: Floats, b: int) -> bool:
    """Whether body b has a velocity."""
    moving = False
    for c in range(at.V, at.W + 3):
        moving = moving or state[b, c] != 0.0
    return moving


@kernel
def mark_changed(floats: Floats, ints: Ints) -> int:
    """Mark the islands that a change from outside reaches, and the fixed bodies that move. Returns: how many bodies woke."""
    state, load = floats_of(floats, ints, at.STATE), floats_of(floats, ints, at.LOAD)
    remembered = floats_of(floats, ints, at.REMEMBERED)
    kind, count, island = ints_of(ints, at.BODY_KIND), ints_of(ints, at.COUNT), ints_of(ints, at.ISLAND)
    tally = ints_of(ints, at.TALLY)
    key, joint_kind = ints_of(ints, at.RESTING_KEY), ints_of(ints, at.JOINT_KIND)
    marked, restless = 0, 0
    for b in range(count[0, at.BODIES]):
        island[b, at.RESTLESS] = 0
        if kind[b, at.MOTION] != at.DYNAMIC:
            changed = has_changed(state, load, remembered, b)
            if island[b, at.ASLEEP] > 0:
                if changed:
                    marked += mark(island, b)
            elif changed or is_moving(state, b):
                island[b, at.RESTLESS] = 1
                restless += 1
    tally[0, at.RESTLESS_BODIES] = restless
    if restless > 0:
        for m in range(tally[0, at.RESTING]):
            if island[key[m, at.BODY_A], at.RESTLESS] == 1 or island[key[m, at.BODY_B], at.RESTLESS] == 1:
                marked += mark(island, key[m, at.BODY_A]) + mark(island, key[m, at.BODY_B])
        for j in range(count[0, at.JOINTS]):
            a, b = joint_kind[j, at.PARENT], joint_kind[j, at.CHILD]
            if island[a, at.RESTLESS] == 1 or island[b, at.RESTLESS] == 1:
                marked += mark(island, a) + mark(island, b)
    return marked


@kernel
def mark_touched(floats: Floats, ints: Ints) -> int:
    """Mark the islands that an awake body touches or a moving fixed body comes near; the latter keeps awake ones from sleep.

    Returns: how many times an asleep body was met.
    """
    bounds, calm = floats_of(floats, ints, at.BOUNDS), floats_of(floats, ints, at.CALM)
    count, island, tally = ints_of(ints, at.COUNT), ints_of(ints, at.ISLAND), ints_of(ints, at.TALLY)
    key, shape_kind = ints_of(ints, at.MANIFOLD_KEY), ints_of(ints, at.SHAPE_KIND)
    marked = 0
    for m in range(count[0, at.MANIFOLDS]):
        marked += mark(island, key[m, at.BODY_A]) + mark(island, key[m, at.BODY_B])
    if tally[0, at.RESTLESS_BODIES] == 0:
        return marked
    for s in range(count[0, at.SHAPES]):
        if island[shape_kind[s, at.OWNER], at.RESTLESS] == 1:
            for t in range(count[0, at.SHAPES]):
                b = shape_kind[t, at.OWNER]
                meets = True
                for c in range(3):
                    meets = meets and bounds[s, c] <= bounds[t, c + 3] and bounds[t, c] <= bounds[s, c + 3]
                if meets:
                    calm[b, 0] = 0.0
                    marked += mark(island, b)
    return marked


@kernel
def resting_contacts_of(floats: Floats, ints: Ints) -> Contacts:
    """The contacts of asleep islands."""
    return Contacts(
        floats_of(floats, ints, at.RESTING_MANIFOLD),
        floats_of(floats, ints, at.RESTING_POINT),
        ints_of(ints, at.RESTING_KEY),
        ints_of(ints, at.RESTING_POINT_KEY),
        ints_of(ints, at.MANIFOLD_ORDER)[:0],
    )


@kernel
def wake_marked(floats: Floats, ints: Ints) -> int:
    """Wake the marked islands, and put their contacts back among those of the last step.

    Returns: DONE, or FULL where there is no room for them; then nothing has changed.
    """
    kind, count, island = ints_of(ints, at.BODY_KIND), ints_of(ints, at.COUNT), ints_of(ints, at.ISLAND)
    tally = ints_of(ints, at.TALLY)
    contacts, resting = contacts_of(floats, ints), resting_contacts_of(floats, ints)
    calm, key, rest = floats_of(floats, ints, at.CALM), resting.key, floats_of(floats, ints, at.REST)
    rising = 0
    for m in range(tally[0, at.RESTING]):
        rising += island[max(island[key[m, at.BODY_A], at.ASLEEP], island[key[m, at.BODY_B], at.ASLEEP]) - 1, at.WAKES]
    if count[0, at.MANIFOLDS] + rising > key.shape[0]:
        return FULL
    still = 0
    for m in range(tally[0, at.RESTING]):
        if island[max(island[key[m, at.BODY_A], at.ASLEEP], island[key[m, at.BODY_B], at.ASLEEP]) - 1, at.WAKES] == 1:
            copy_contact(resting, m, contacts, count[0, at.MANIFOLDS])
            count[0, at.MANIFOLDS] += 1
        else:
            copy_contact(resting, m, resting, still)
            still += 1
    tally[0, at.RESTING] = still
    for b in range(count[0, at.BODIES]):
        if island[b, at.ASLEEP] > 0 and island[island[b, at.ASLEEP] - 1, at.WAKES] == 1:
            island[b, at.ASLEEP], kind[b, at.MOTION], calm[b, 0], rest[b, 0] = 0, at.DYNAMIC, 0.0, math.inf
            tally[0, at.AWAKE] += 1
            tally[0, at.SEARCHED], ints_of(ints, at.PROGRESS)[0, at.CANDIDATES] = 0, -1
    for b in range(count[0, at.BODIES]):
        island[b, at.WAKES] = 0
    return DONE


@kernel
def fall_asleep(floats: Floats, ints: Ints) -> int:
    """Count for how long every body has been slow, and put to sleep the islands of which all have been for long enough.

    Returns: DONE, or FULL where there is no room for their contacts; then the islands stay awake for now.
    """
    state, body = floats_of(floats, ints, at.STATE), floats_of(floats, ints, at.BODY)
    setting = floats_of(floats, ints, at.SETTING)
    calm, sleep = floats_of(floats, ints, at.CALM), floats_of(floats, ints, at.SLEEP)
    kind, count, island = ints_of(ints, at.BODY_KIND), ints_of(ints, at.COUNT), ints_of(ints, at.ISLAND)
    tally = ints_of(ints, at.TALLY)
    contacts, resting = contacts_of(floats, ints), resting_contacts_of(floats, ints)
    key, span = contacts.key, ints_of(ints, at.SPAN_OF_ISLAND)
    for i in range(tally[0, at.ISLANDS]):
        span[i, at.UNEASY] = 0
    awake = 0
    for b in range(count[0, at.BODIES]):
        if kind[b, at.MOTION] == at.DYNAMIC:
            awake += 1
            v, w = load3(state, b, at.V), load3(state, b, at.W)
            energy = dot(v, v) + dot(w, angular_momentum(state, body, b)) / body[b, at.MASS]
            calm[b, 0] = calm[b, 0] + setting[0, at.DT] if energy < sleep[0, at.SLEEP_SPEED] * sleep[0, at.SLEEP_SPEED] else 0.0
            if calm[b, 0] < sleep[0, at.SLEEP_TIME]:
                span[island[b, at.NUMBER], at.UNEASY] += 1
    tally[0, at.AWAKE] = awake
    leaving = 0
    for m in range(count[0, at.MANIFOLDS]):
        leaving += int(span[max(island[key[m, at.BODY_A], at.NUMBER], island[key[m, at.BODY_B], at.NUMBER]), at.UNEASY] == 0)
    if tally[0, at.RESTING] + leaving > resting.key.shape[0]:
        return FULL
    staying = 0
    for m in range(count[0, at.MANIFOLDS]):
        if span[max(island[key[m, at.BODY_A], at.NUMBER], island[key[m, at.BODY_B], at.NUMBER]), at.UNEASY] == 0:
            copy_contact(contacts, m, resting, tally[0, at.RESTING])
            tally[0, at.RESTING] += 1
        else:
            if staying < m:
                copy_contact(contacts, m, contacts, staying)
            staying += 1
    count[0, at.MANIFOLDS] = staying
    for b in range(count[0, at.BODIES]):
        if kind[b, at.MOTION] == at.DYNAMIC and span[island[b, at.NUMBER], at.UNEASY] == 0:
            root = b
            while island[root, at.ROOT] != root:
                root = island[root, at.ROOT]
            island[b, at.ASLEEP], kind[b, at.MOTION] = root + 1, at.STATIC
            ints_of(ints, at.PROGRESS)[0, at.CANDIDATES] = -1
            store3(state, b, at.V, (0.0, 0.0, 0.0))
            store3(state, b, at.W, (0.0, 0.0, 0.0))
            tally[0, at.AWAKE] -= 1
    return DONE


@kernel
def remember(floats: Floats, ints: Ints) -> None:
    """Note state and load of all bodies that do not move by themselves."""
    state, load = floats_of(floats, ints, at.STATE), floats_of(floats, ints, at.LOAD)
    remembered = floats_of(floats, ints, at.REMEMBERED)
    kind = ints_of(ints, at.BODY_KIND)
    for b in range(ints_of(ints, at.COUNT)[0, at.BODIES]):
        if kind[b, at.MOTION] != at.DYNAMIC:
            for c in range(13):
                remembered[b, c] = state[b, c]
            for c in range(6):
                remembered[b, 13 + c] = load[b, c]
