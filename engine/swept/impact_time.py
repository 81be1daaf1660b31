"""The time of impact of two shapes on their paths, turning included: conservative advancement, then Newton's method.

With the gap s, its normal n and the largest speed mu at which points of A and B can approach along n,

    mu = max n . (v_A - v_B) + |w_A x n| r_A + |w_B x n| r_B,

nothing can touch within s / mu, since the separation along n bounds the distance from below; so time advances by that until the
shapes touch, or mu <= 0 shows that they never will. The last micrometre goes by Newton's method, whose slope is the velocity of
the closest points. A pair in touch is stopped where it would sink in by a share of its thickness: contacts hold it, so that it
gets there only where they cannot, as when a rod that lies on an edge swings through it. Distances are signed, by the same GJK
and EPA as the contacts.

Source: Mirtich, Impulse-based Dynamic Simulation of Rigid Body Systems, 1996, section 2.3 (the bound); Catto, Continuous
Collision, GDC 2013 (a root of the separating function; sinking targets of touching shapes); van den Bergen, Collision
Detection in Interactive 3D Environments, 2003, sections 4.3.4 and 4.3.8 (distances).
"""

import math

from plumbline.engine.compile.jit import kernel
from plumbline.engine.contact.look_ahead import thinnest
from plumbline.engine.maths.rows import Floats, Vec, load3
from plumbline.engine.maths.vec import add, axpy, cross, dot, neg, norm, sub
from plumbline.engine.memory import arena as at
from plumbline.engine.narrow.convex import part_cores
from plumbline.engine.narrow.gjk import Simplex
from plumbline.engine.narrow.support import Solids, core_radius, core_support
from plumbline.engine.narrow.triangle import leans_over
from plumbline.engine.swept.path import body_at, shape_at, velocity_of


@kernel
def above_plane(t: Solids, plane: int, s: int) -> tuple[float, Vec, Vec]:
    """The gap [m] of shape s over a plane, the plane's normal, and the lowest point of s, in W."""
    up = (t.pose[plane, 5], t.pose[plane, 8], t.pose[plane, 11])
    lowest = axpy(-core_radius(t, s), up, add(load3(t.pose, s, 0), core_support(t, s, neg(up))))
    return dot(up, sub(lowest, load3(t.pose, plane, 0))), up, lowest


@kernel
def separation(t: Solids, a: int, b: int, simplex: Simplex) -> tuple[float, Vec, Vec, Vec]:
    """The gap [m] of shapes a and b, negative in penetration, the normal from A to B, and their closest points in W."""
    if t.shape_kind[a, at.TYPE] == at.PLANE:
        gap, up, spot = above_plane(t, a, b)
        return gap, up, axpy(-gap, up, spot), spot
    if t.shape_kind[b, at.TYPE] == at.PLANE:
        gap, up, spot = above_plane(t, b, a)
        return gap, neg(up), spot, axpy(-gap, up, spot)
    pa, ra, rb = load3(t.pose, a, 0), core_radius(t, a), core_radius(t, b)
    size = t.shape[a, at.BALL_RADIUS] + t.shape[b, at.BALL_RADIUS]
    gap, n, qa, qb = part_cores(t, a, b, sub(load3(t.pose, b, 0), pa), size, math.inf, simplex)
    return gap - ra - rb, n, add(pa, axpy(ra, n, qa)), add(pa, axpy(-rb, n, qb))


SINKS = 0.25
"""Share of half the thickness of the thinner shape [1] that a pair in touch may sink in within a step."""
LEAVES = 4.0
"""How many gaps of touch [1] a pair that flies apart has to gain before it is looked at again."""
MAX_ROUNDS = 256
NEWTON = 16
SHARP = 1e-14
"""Share of the size [1] at which a gap is rounding."""


@kernel
def reach(t: Solids, s: int) -> float:
    """The largest distance [m] of a core's points from the centre of mass of its body; the radius around it does not turn."""
    return float(norm(load3(t.shape, s, at.OFFSET)) + t.shape[s, at.BALL_RADIUS] - core_radius(t, s))


@kernel
def approach_bound(t: Solids, path: Floats, a: int, b: int, n: Vec, time: float, span: float) -> float:
    """A bound mu [m/s] of the rate at which the gap along n can shrink from `time` to the end of the span."""
    i, j = t.shape_kind[a, at.OWNER], t.shape_kind[b, at.OWNER]
    now = sub(velocity_of(path, j, time), velocity_of(path, i, time))
    last = sub(velocity_of(path, j, span), velocity_of(path, i, span))
    wa, wb = load3(path, i, at.W), load3(path, j, at.W)
    ra, rb = reach(t, a), reach(t, b)
    # A plane that turns sweeps its own normal along: at the other body, as far as that may get.
    if (t.shape_kind[a, at.TYPE] == at.PLANE and wa != (0.0, 0.0, 0.0)) or (
        t.shape_kind[b, at.TYPE] == at.PLANE and wb != (0.0, 0.0, 0.0)
    ):
        speed, apart = max(norm(now), norm(last)), norm(sub(load3(path, j, at.P), load3(path, i, at.P)))
        far = apart + span * speed + min(ra, rb)
        return speed + norm(wa) * min(ra, far) + norm(wb) * min(rb, far)
    mu = max(-dot(n, now), -dot(n, last))
    if wa != (0.0, 0.0, 0.0):
        mu += norm(cross(wa, n)) * ra
    if wb != (0.0, 0.0, 0.0):
        mu += norm(cross(wb, n)) * rb
    return float(mu)


@kernel
def velocity_at(path: Floats, b: int, time: float, x: Vec) -> Vec:
    """The velocity [m/s] of the point of body b that is at x in W."""
    p, _ = body_at(path, b, time)
    return add(velocity_of(path, b, time), cross(load3(path, b, at.W), sub(x, p)))


@kernel
def closing_speed(t: Solids, path: Floats, a: int, b: int, time: float, n: Vec, xa: Vec, xb: Vec) -> float:
    """How fast [m/s] the closest points approach, along the normal that their contact would have."""
    if t.shape_kind[b, at.TYPE] == at.TRIANGLE and leans_over(
        t, b, sub(xb, load3(t.pose, b, 0)), neg(n), t.polyhedron[b, at.INNER]
    ):
        n = (-t.pose[b, 5], -t.pose[b, 8], -t.pose[b, 11])
    va, vb = velocity_at(path, t.shape_kind[a, at.OWNER], time, xa), velocity_at(path, t.shape_kind[b, at.OWNER], time, xb)
    return dot(n, sub(va, vb))


@kernel
def sharpen(t: Solids, path: Floats, a: int, b: int, time: float, earliest: float, size: float, simplex: Simplex) -> float:
    """Newton's method for the zero of the gap near `time`, not before `earliest`."""
    last, best = math.inf, time
    for _ in range(NEWTON):
        shape_at(path, t.shape, t.shape_kind, a, time, t.pose)
        shape_at(path, t.shape, t.shape_kind, b, time, t.pose)
        gap, n, xa, xb = separation(t, a, b, simplex)
        if abs(gap) >= last:
            break
        last, best = abs(gap), time
        speed = closing_speed(t, path, a, b, time, n, xa, xb)
        if last <= SHARP * size or speed <= 0.0:
            break
        time = max(time + gap / speed, earliest)
    return best


@kernel
def impact_time(
    t: Solids, path: Floats, a: int, b: int, span: float, before: float, touch: float, simplex: Simplex
) -> float:  # fmt: skip
    """The time [s] within `before` at which shapes a and b, type of a <= type of b, strike; inf if they do not.

    Args: span [s]: how long the paths last; before [s]: later impacts are of no interest; touch [m]: gaps below are closed.
    """
    time, earlier, sinking = 0.0, 0.0, -math.inf
    thin = min(thinnest(t.shape, t.shape_kind, a), thinnest(t.shape, t.shape_kind, b))
    size = min(t.shape[a, at.BALL_RADIUS], t.shape[b, at.BALL_RADIUS])
    for k in range(MAX_ROUNDS):
        shape_at(path, t.shape, t.shape_kind, a, time, t.pose)
        shape_at(path, t.shape, t.shape_kind, b, time, t.pose)
        if k == 0 and t.shape_kind[b, at.TYPE] == at.TRIANGLE:
            out = (t.pose[b, 5], t.pose[b, 8], t.pose[b, 11])
            if dot(sub(load3(t.pose, a, 0), load3(t.pose, b, 0)), out) < 0.0:
                return math.inf
        gap, n, xa, xb = separation(t, a, b, simplex)
        if k == 0 and gap <= touch:
            # A bounce: past the moment of touch, the pair is apart like any other.
            parting = -closing_speed(t, path, a, b, time, n, xa, xb)
            if parting * span > LEAVES * touch:
                time = LEAVES * touch / parting
                continue
        if sinking == -math.inf and gap <= touch:
            # What would not sink in by more than `touch` in the time left rests, slides, or passes by.
            if k > 0 and closing_speed(t, path, a, b, time, n, xa, xb) * (span - time) > touch:
                time = sharpen(t, path, a, b, time, earlier, size, simplex)
                return time if time < before else math.inf
            sinking = min(gap, 0.0) - SINKS * thin
        left = gap if sinking == -math.inf else gap - sinking
        if left <= touch:
            return time
        mu = approach_bound(t, path, a, b, n, time, span)
        if mu <= 0.0:
            return math.inf
        earlier, time = time, time + left / mu
        if time >= before:
            return math.inf
    return time
