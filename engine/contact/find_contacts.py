"""The collision stages of a step, in order: poses, bounds, broad phase unless done, narrow phase with matching, preparation.

Where no body has moved more than a little since its contacts were made, a step may keep these and run none of this. The
points of a contact go with their bodies from sub-step to sub-step anyway, so that a kept contact has its gap at the present
poses; only which points there are, and the normal, are those of a pose that differs by less than the tolerance.

Source: Catto, Iterative Dynamics with Temporal Coherence, GDC 2005.
"""

import math

from plumbline.engine.broad.bounds import brute_force
from plumbline.engine.compile.jit import inlined, kernel
from plumbline.engine.contact.manifolds import build_manifolds
from plumbline.engine.contact.warm_starting import keep_old, start_anew
from plumbline.engine.maths.rows import Floats, Ints, load3, load4, store3, store4
from plumbline.engine.maths.vec import norm, sub
from plumbline.engine.memory import arena as at
from plumbline.engine.memory.carve import floats_of, ints_of
from plumbline.engine.memory.status import CONVEX_PENDING, DONE, FULL, SEARCH_PENDING
from plumbline.engine.memory.tables import Bodies, bodies_of, contacts_of, old_contacts_of, pairs_of, rules_of, shapes_of
from plumbline.engine.narrow.collide import is_convex_pair, ordered
from plumbline.engine.narrow.point import points_of

SHARE = 0.01
"""Share of the margin, or of the body's own extent where that is less [1], by which a still body may have moved.

Far less than the margin, by which contacts are made ahead: no pair that was too far apart can touch meanwhile.
"""


@kernel
def mark_still(bodies: Bodies, rest: Floats, setting: Floats, count: int) -> bool:
    """Mark the bodies of which no point moved further than the tolerance since `keep_rest`, nor will in this step.

    Returns: whether all are still.
    """
    state, body, kind, every = bodies.state, bodies.body, bodies.kind, True
    for b in range(count):
        if kind[b, at.MOTION] == at.STATIC:
            kind[b, at.STILL] = 1
            continue
        extent = body[b, at.EXTENT]
        turned = 0.0
        for c in range(4):
            apart = state[b, at.Q + c] - rest[b, 3 + c]
            turned += apart * apart
        way = norm(sub(load3(state, b, at.P), load3(rest, b, 0))) + 2.0 * extent * math.sqrt(turned)
        way += setting[0, at.DT] * (norm(load3(state, b, at.V)) + extent * norm(load3(state, b, at.W)))
        kind[b, at.STILL] = 1 if way < SHARE * min(setting[0, at.MARGIN], extent) else 0
        every = every and kind[b, at.STILL] == 1
    return every


@kernel
def keep_rest(state: Floats, kind: Ints, rest: Floats, bodies: int) -> None:
    """From now on bodies that were not still are measured from their present pose."""
    for b in range(bodies):
        if kind[b, at.STILL] == 0:
            store3(rest, b, 0, load3(state, b, at.P))
            store4(rest, b, 3, load4(state, b, at.Q))


@inlined
def needs_search(ints: Ints) -> bool:
    """Whether the pairs of the coming step are found before it, and have not been found yet."""
    return bool(ints_of(ints, at.COUNT)[0, at.BROAD] == 1 and ints_of(ints, at.TALLY)[0, at.SEARCHED] == 0)


@kernel
def keep_contacts(floats: Floats, ints: Ints) -> bool:
    """Keep the contacts of the last step for this one, where all bodies are still. Returns: whether they are."""
    bodies, count, rest = bodies_of(floats, ints), ints_of(ints, at.COUNT), floats_of(floats, ints, at.REST)
    if not mark_still(bodies, rest, floats_of(floats, ints, at.SETTING), count[0, at.BODIES]):
        return False
    start_anew(bodies.state, contacts_of(floats, ints), 0, count[0, at.MANIFOLDS])
    count[0, at.NEW] = 0
    return True


@kernel
def find_contacts(floats: Floats, ints: Ints) -> int:
    """Find and prepare the contacts of this step, and mark the bodies they touch.

    Returns: DONE, or SEARCH_PENDING, FULL or CONVEX_PENDING; then nothing has changed but the list of pairs.
    """
    if needs_search(ints):
        return SEARCH_PENDING
    bodies, shapes, rules = bodies_of(floats, ints), shapes_of(floats, ints), rules_of(floats, ints)
    pairs, new, old = pairs_of(floats, ints), contacts_of(floats, ints), old_contacts_of(floats, ints)
    state, kind, count, rest = bodies.state, bodies.kind, rules.numbers, floats_of(floats, ints, at.REST)
    mark_still(bodies, rest, rules.setting, count[0, at.BODIES])
    if count[0, at.BROAD] == 0:
        brute_force(floats, ints)
    if count[0, at.PAIRS] > pairs.pair.shape[0]:
        return FULL
    for p in range(count[0, at.PAIRS]):
        a, b = ordered(shapes.kind, pairs.pair[p, 0], pairs.pair[p, 1])
        if count[0, at.CONVEX_READY] == 0 and is_convex_pair(shapes.kind[a, at.TYPE], shapes.kind[b, at.TYPE]):
            return CONVEX_PENDING
    count[0, at.CONVEX_READY], ints_of(ints, at.TALLY)[0, at.SEARCHED] = 0, 0
    for b in range(count[0, at.BODIES] + 1):
        kind[b, at.TOUCHED] = 0
    keep_old(kind, count, new, old)
    build_manifolds(bodies, shapes, rules, pairs, new, old, points_of(floats, ints))
    keep_rest(state, kind, rest, count[0, at.BODIES])
    for m in range(count[0, at.MANIFOLDS]):
        new.order[m, 0] = m
    return DONE
