"""How far apart two shapes may be and still be given a contact for the coming step."""

import math

from plumbline.engine.compile.jit import kernel
from plumbline.engine.maths.rows import Floats, Ints, load3
from plumbline.engine.maths.vec import norm, sub
from plumbline.engine.memory import arena as at


@kernel
def thinnest(shape: Floats, shape_kind: Ints, s: int) -> float:
    """Half the smallest width of a shape [m]; inf for planes and triangles, which bound a solid."""
    if shape_kind[s, at.TYPE] == at.CYLINDER:
        return float(min(shape[s, at.SIZE], shape[s, at.SIZE + 1]))
    if shape_kind[s, at.TYPE] in (at.BOX, at.ELLIPSOID, at.HULL):
        return float(min(min(shape[s, at.SIZE], shape[s, at.SIZE + 1]), shape[s, at.SIZE + 2]))
    if shape_kind[s, at.TYPE] == at.TRIANGLE:
        return math.inf
    return float(shape[s, at.SIZE]) if shape[s, at.BALL_RADIUS] < math.inf else math.inf


@kernel
def look_ahead(state: Floats, shape: Floats, shape_kind: Ints, a: int, b: int, setting: Floats, continuous: int) -> float:
    """How far apart [m] two shapes may be and still be given a contact for this step: the way they may go towards each other.

    Without continuous collision it ends at half the thickness of the thinner shape, so that a fast body passes a thin wall. A
    swept step that goes on in parts looks as far ahead as the whole of it, so that a pair stays fast or slow.
    """
    i, j = shape_kind[a, at.OWNER], shape_kind[b, at.OWNER]
    dt = setting[0, at.WHOLE_STEP]
    speed = norm(sub(load3(state, j, at.V), load3(state, i, at.V)))
    for s, owner in ((a, i), (b, j)):
        if shape[s, at.BALL_RADIUS] < math.inf:
            # Turning does not move the surface of a ball, but for its centre.
            swing = norm(load3(shape, s, at.OFFSET)) + (
                shape[s, at.BALL_RADIUS] if shape_kind[s, at.TYPE] != at.SPHERE else 0.0
            )
            speed += norm(load3(state, owner, at.W)) * swing
    way = setting[0, at.MARGIN] + dt * (speed + dt * norm(load3(setting, 0, 1)))
    if continuous == at.OFF:
        way = min(way, max(setting[0, at.MARGIN], min(thinnest(shape, shape_kind, a), thinnest(shape, shape_kind, b))))
    return float(way)
