"""Which bodies have hardly moved since their contacts were made, so that these can be kept.

The points of a contact go with their bodies from sub-step to sub-step anyway, so that a kept contact has its gap at the present
poses; only which points there are, and the normal, are those of a pose that differs by less than the tolerance.

Source: Catto, Iterative Dynamics with Temporal Coherence, GDC 2005.
"""

import math

from plumbline.engine.compile.jit import kernel
from plumbline.engine.maths.rows import Floats, Ints, load3, load4, store3, store4
from plumbline.engine.maths.vec import norm, sub
from plumbline.engine.memory import arena as at
from plumbline.engine.memory.tables import Bodies

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
