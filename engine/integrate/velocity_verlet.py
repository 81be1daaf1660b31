"""Velocity Verlet (leapfrog) for bodies that nothing touches: half a kick, a drift, half a kick.

    v <- v + (h/2) a,  p <- p + h v,  v <- v + (h/2) a
    m <- m + (h/2) R^T tau,  (q, m) <- X(h/2) Y(h/2) Z(h) Y(h/2) X(h/2) (q, m),  m <- m + (h/2) R^T tau

X, Y, Z turn about the principal axes. Damping belongs to the kicks, which are exact. Second order, symmetric, and symplectic
where nothing is damped.

Source: Verlet, Phys. Rev. 159 (1967) 98; Dullweber, Leimkuhler, McLachlan, J. Chem. Phys. 107 (1997) 5840 (rotation).
"""

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
from plumbline.engine.integrate.principal_turns import turn_first, turn_second, turn_third
from plumbline.engine.maths.rows import Floats, Ints, load3, store3
from plumbline.engine.maths.vec import axpy
from plumbline.engine.memory import arena as at
from plumbline.engine.memory.tables import Bodies


@kernel
def velocity_verlet(bodies: Bodies, principal: Floats, setting: Floats, b: int, h: float, gyroscopic: int) -> bool:
    """Advance body b by h. Returns: True."""
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
    if gyroscopic == 1:
        q, m = turn_first(q, m, 0.5 * h * m[0] / moments[0])
        q, m = turn_second(q, m, 0.5 * h * m[1] / moments[1])
        q, m = turn_third(q, m, h * m[2] / moments[2])
        q, m = turn_second(q, m, 0.5 * h * m[1] / moments[1])
        q, m = turn_first(q, m, 0.5 * h * m[0] / moments[0])
    else:
        q = turned_by(q, velocities_of(m, moments), h)
    from_principal(state, principal, b, q, kicked_spin(q, m, tau, d, 0.5 * h))
    return True


@entry
def step_velocity_verlet(floats: Floats, ints: Ints, steps: int) -> tuple[int, int]:
    """Advance bodies that nothing touches. Returns: as `advance_free`."""
    return advance_free(floats, ints, steps, velocity_verlet)
