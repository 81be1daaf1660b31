"""Implicit midpoint on the rotation group for bodies that nothing touches; it keeps the energy and momentum of a free top.

    solve x = m + (h/2) x x (x / I) for the momentum x at the middle,  m <- 2 x - m,  q <- q cay(h x / I)

The first conserves every quadratic invariant, so the energy and |L|; the Cayley map makes R m constant in the world. Loads and
damping are half kicks before and after, so that the whole is symmetric and of second order.

Source: Austin, Krishnaprasad, Wang, J. Comput. Phys. 107 (1993) 105; Lewis, Simo, J. Nonlinear Sci. 4 (1994) 253.
"""

import math

from plumbline.engine.compile.jit import entry, kernel
from plumbline.engine.integrate.free_body import (
    from_principal,
    is_pushed,
    kicked_spin,
    kicked_velocity,
    to_principal,
    turned_by,
    velocities_of,
)
from plumbline.engine.integrate.free_steps import advance_free
from plumbline.engine.maths.rows import Floats, Ints, Vec, load3, store3
from plumbline.engine.maths.vec import axpy, cross, dot, norm, quat_mul, scale, sub
from plumbline.engine.memory import arena as at
from plumbline.engine.memory.tables import Bodies

MOST_ITERATIONS = 50
"""Newton's method needs three or four where h w is small; where it needs more than this the step is far too long."""


@kernel
def middle_momentum(m: Vec, moments: Vec, h: float) -> tuple[Vec, bool]:
    """The solution x of x = m + (h/2) x x (x / I) by Newton's method, and whether it was found to round-off."""
    e1 = 0.5 * h * (1.0 / moments[2] - 1.0 / moments[1])
    e2 = 0.5 * h * (1.0 / moments[0] - 1.0 / moments[2])
    e3 = 0.5 * h * (1.0 / moments[1] - 1.0 / moments[0])
    x = m
    small = 1e-15 * norm(m)
    for _ in range(MOST_ITERATIONS):
        miss = (
            x[0] - m[0] - e1 * x[1] * x[2], x[1] - m[1] - e2 * x[2] * x[0], x[2] - m[2] - e3 * x[0] * x[1],
        )  # fmt: skip
        # Columns of the Jacobian; the correction follows by Cramer's rule.
        a, b, c = (1.0, -e2 * x[2], -e3 * x[1]), (-e1 * x[2], 1.0, -e3 * x[0]), (-e1 * x[1], -e2 * x[0], 1.0)
        bc = cross(b, c)
        over = 1.0 / dot(a, bc)
        change = (over * dot(miss, bc), over * dot(a, cross(miss, c)), over * dot(a, cross(b, miss)))
        x = sub(x, change)
        if norm(change) <= small:
            return x, True
    return x, False


@kernel
def implicit_midpoint(bodies: Bodies, principal: Floats, setting: Floats, b: int, h: float, gyroscopic: int) -> bool:
    """Advance body b by h. Returns: whether the equation of the step was solved."""
    state, body, load = bodies.state, bodies.body, bodies.load
    if not is_pushed(state, bodies.kind, b, h):
        return True
    a, c = axpy(body[b, at.INV_MASS], load3(load, b, 0), load3(setting, 0, at.GRAVITY)), body[b, at.LINEAR_DAMPING]
    v = kicked_velocity(load3(state, b, at.V), a, c, 0.5 * h)
    store3(state, b, at.P, axpy(h, v, load3(state, b, at.P)))
    store3(state, b, at.V, kicked_velocity(v, a, c, 0.5 * h))

    tau, d, moments = load3(load, b, 3), body[b, at.ANGULAR_DAMPING], load3(principal, b, at.MOMENTS)
    q, m = to_principal(state, principal, b)
    m = kicked_spin(q, m, tau, d, 0.5 * h)
    solved = True
    if gyroscopic == 1:
        x, solved = middle_momentum(m, moments, h)
        half = scale(0.5 * h, velocities_of(x, moments))
        s = 1.0 / math.sqrt(1.0 + dot(half, half))
        q = quat_mul(q, (s, s * half[0], s * half[1], s * half[2]))
        m = axpy(2.0, x, scale(-1.0, m))
    else:
        q = turned_by(q, velocities_of(m, moments), h)
    from_principal(state, principal, b, q, kicked_spin(q, m, tau, d, 0.5 * h))
    return solved


@entry
def step_implicit_midpoint(floats: Floats, ints: Ints, steps: int) -> tuple[int, int]:
    """Advance bodies that nothing touches. Returns: as `advance_free`."""
    return advance_free(floats, ints, steps, implicit_midpoint)
