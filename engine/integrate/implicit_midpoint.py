"""Implicit midpoint on the rotation group for bodies that nothing touches; it keeps the energy and momentum of a free top.

    solve x = m + (h/2) x x (x / I) for the momentum x at the middle,  m <- 2 x - m,  q <- q cay(h x / I)

The first conserves every quadratic invariant, so the energy and |L|; the Cayley map makes R m constant in the world. Loads and
damping are half kicks before and after (`composition`), so that the whole is symmetric and of second order.

Source: Austin, Krishnaprasad, Wang, J. Comput. Phys. 107 (1993) 105; Lewis, Simo, J. Nonlinear Sci. 4 (1994) 253.
"""

import math

from plumbline.engine.compile.jit import entry, kernel
from plumbline.engine.integrate.composition import ONE_STEP, compose
from plumbline.engine.integrate.free_body import advance_free, velocities_of
from plumbline.engine.maths.rows import Floats, Ints, Quat, Vec
from plumbline.engine.maths.vec import axpy, cross, dot, norm, quat_mul, scale, sub
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
def midpoint_rotor(q: Quat, m: Vec, moments: Vec, weights: Floats, h: float) -> tuple[Quat, Vec, bool]:
    """Steps without load. Args, Returns: as of `composition.Rotor`."""
    every = True
    for k in range(len(weights)):
        x, solved = middle_momentum(m, moments, weights[k] * h)
        half = scale(0.5 * weights[k] * h, velocities_of(x, moments))
        s = 1.0 / math.sqrt(1.0 + dot(half, half))
        q, m = quat_mul(q, (s, s * half[0], s * half[1], s * half[2])), axpy(2.0, x, scale(-1.0, m))
        every = every and solved
    return q, m, every


@kernel
def implicit_midpoint(bodies: Bodies, principal: Floats, setting: Floats, b: int, h: float, gyroscopic: int) -> bool:
    """Advance body b by h. Returns: whether the equation of the step was solved."""
    return compose(bodies, principal, setting, b, h, gyroscopic, ONE_STEP, midpoint_rotor)


@entry
def step_implicit_midpoint(floats: Floats, ints: Ints, steps: int) -> tuple[int, int]:
    """Advance bodies that nothing touches. Returns: as `advance_free`."""
    return advance_free(floats, ints, steps, implicit_midpoint)
