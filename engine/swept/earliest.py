"""The earliest impact of a span of time, among the pairs that are too fast for contacts made ahead.

Pairs come from sort and sweep over the bounds of whole paths: for a shape that turns, of its bounding ball; else of itself.

Source: Ericson, Real-Time Collision Detection, sections 5.5.8 (interval of time) and 7.5 (sort and sweep).
"""

import math

from plumbline.engine.broad.bounds import CollisionFilter, boxes_overlap, collision_filter_of, kept_apart
from plumbline.engine.compile.jit import entry, kernel
from plumbline.engine.contact.look_ahead import look_ahead
from plumbline.engine.maths.rows import Floats, Ints, load3
from plumbline.engine.maths.vec import axpy, norm
from plumbline.engine.memory import arena as at
from plumbline.engine.memory.carve import floats_of, ints_of
from plumbline.engine.narrow.collide import ordered
from plumbline.engine.narrow.gjk import simplex_of
from plumbline.engine.narrow.support import Solids, core_radius, core_support, solids_of
from plumbline.engine.swept.begin import FAST, touch_gap
from plumbline.engine.swept.impact_time import impact_time
from plumbline.engine.swept.path import ACCELERATION, body_at, shape_at, write_path


@kernel
def bound_path(t: Solids, path: Floats, s: int, span: float, bounds: Floats) -> None:
    """Write axis-aligned bounds [m] of shape s on its whole path."""
    for k in range(3):
        bounds[s, k], bounds[s, k + 3] = math.inf, -math.inf
    if t.shape_kind[s, at.TYPE] == at.PLANE:
        for k in range(3):
            bounds[s, k], bounds[s, k + 3] = -math.inf, math.inf
        return
    b = t.shape_kind[s, at.OWNER]
    turns = load3(path, b, at.W) != (0.0, 0.0, 0.0)
    ball = norm(load3(t.shape, s, at.OFFSET)) + t.shape[s, at.BALL_RADIUS]
    bulge = 0.125 * span * span * norm(load3(path, b, ACCELERATION))
    for end in range(2):
        p, _ = body_at(path, b, end * span)
        shape_at(path, t.shape, t.shape_kind, s, end * span, t.pose)
        for k in range(3):
            if turns:
                low, high = p[k] - ball, p[k] + ball
            else:
                e = (1.0 if k == 0 else 0.0, 1.0 if k == 1 else 0.0, 1.0 if k == 2 else 0.0)
                low = t.pose[s, k] + core_support(t, s, (-e[0], -e[1], -e[2]))[k] - core_radius(t, s)
                high = t.pose[s, k] + core_support(t, s, e)[k] + core_radius(t, s)
            bounds[s, k], bounds[s, k + 3] = min(bounds[s, k], low - bulge), max(bounds[s, k + 3], high + bulge)


@kernel
def may_strike(rules: CollisionFilter, bounds: Floats, i: int, j: int) -> bool:
    """Whether shapes i and j come near each other and are not kept apart."""
    planes = rules.shape_kind[i, at.TYPE] == at.PLANE and rules.shape_kind[j, at.TYPE] == at.PLANE
    return boxes_overlap(bounds, i, j) and not planes and not kept_apart(rules, i, j)


@entry
def earliest_impact(
    floats: Floats, ints: Ints, start: Floats, span: float, path: Floats, bounds: Floats, order: Ints
) -> float:  # fmt: skip
    """The time [s] of the first impact on the way from the state `start` to the present one, `span` seconds later; inf if none.

    Args: start (bodies + 1, 13); path (bodies + 1, 16), bounds (shapes, 6), order (shapes,), a permutation: scratch, of which
    the paths are of use afterwards.
    """
    t, simplex, rules = solids_of(floats, ints), simplex_of(floats, ints), collision_filter_of(floats, ints)
    state, setting = floats_of(floats, ints, at.STATE), floats_of(floats, ints, at.SETTING)
    body, load = floats_of(floats, ints, at.BODY), floats_of(floats, ints, at.LOAD)
    kind, count = ints_of(ints, at.BODY_KIND), ints_of(ints, at.COUNT)
    shapes = count[0, at.SHAPES]
    for b in range(count[0, at.BODIES] + 1):
        pull = (0.0, 0.0, 0.0)
        if kind[b, at.MOTION] == at.DYNAMIC and kind[b, at.TOUCHED] == 0:
            pull = axpy(body[b, at.INV_MASS], load3(load, b, 0), load3(setting, 0, at.GRAVITY))
        write_path(start, state, path, b, span, pull)
    for s in range(shapes):
        bound_path(t, path, s, span, bounds)
    for rank in range(1, shapes):
        s, to = order[rank], rank
        while to > 0 and (bounds[order[to - 1], 0], order[to - 1]) > (bounds[s, 0], s):
            order[to] = order[to - 1]
            to -= 1
        order[to] = s
    fast, touch, best = FAST * setting[0, at.MARGIN], touch_gap(setting), math.inf
    for rank in range(shapes):
        for to in range(rank + 1, shapes):
            i, j = order[rank], order[to]
            if bounds[j, 0] > bounds[i, 3]:
                break
            if not may_strike(rules, bounds, i, j):
                continue
            a, b = ordered(t.shape_kind, min(i, j), max(i, j))
            if (
                look_ahead(start, t.shape, t.shape_kind, a, b, setting, at.SWEPT) > fast
                or look_ahead(path, t.shape, t.shape_kind, a, b, setting, at.SWEPT) > fast
            ):
                best = min(best, impact_time(t, path, a, b, span, min(best, span), touch, simplex))
    return best
