"""Velocity Verlet (leapfrog) for bodies that nothing touches: half a kick, a drift, half a kick.

    v <- v + (h/2) a,  p <- p + h v,  v <- v + (h/2) a
    m <- m + (h/2) R^T tau,  (q, m) <- X(h/2) Y(h/2) Z(h) Y(h/2) X(h/2) (q, m),  m <- m + (h/2) R^T tau

X, Y, Z turn about the principal axes. Damping belongs to the kicks, which are exact. Second order, symmetric, and symplectic
where nothing is damped.

Source: Verlet, Phys. Rev. 159 (1967) 98; Dullweber, Leimkuhler, McLachlan, J. Chem. Phys. 107 (1997) 5840 (rotation).
"""

from engine.compile.jit import entry, kernel
from engine.integrate.finite_state import is_finite
from engine.integrate.free_body import (
    from_principal,
    is_pushed,
    kicked_spin,
    kicked_velocity,
    to_principal,
    turned_by,
    velocities_of,
)
from engine.integrate.principal_turns import turn_first, turn_second, turn_third
from engine.maths.vec import Floats, Ints, axpy, load3, store3
from engine.memory.arena import (
    ANGULAR_DAMPING,
    BODIES,
    BODY,
    BODY_KIND,
    COUNT,
    DT,
    GRAVITY,
    GYROSCOPIC,
    INV_MASS,
    LINEAR_DAMPING,
    LOAD,
    MOMENTS,
    PRINCIPAL,
    SETTING,
    STATE,
    STEPS,
    SUBSTEPS,
    P,
    V,
)  # fmt: skip
from engine.memory.carve import floats_of, ints_of

__all__ = ["step_velocity_verlet"]


@kernel
def velocity_verlet(
    state: Floats, body: Floats, principal: Floats, kind: Ints, load: Floats, setting: Floats, b: int, h: float, gyroscopic: int
) -> None:
    """Advance body b by h."""
    if not is_pushed(state, kind, b, h):
        return
    a, c = axpy(body[b, INV_MASS], load3(load, b, 0), load3(setting, 0, GRAVITY)), body[b, LINEAR_DAMPING]
    v = kicked_velocity(load3(state, b, V), a, c, 0.5 * h)
    store3(state, b, P, axpy(h, v, load3(state, b, P)))
    store3(state, b, V, kicked_velocity(v, a, c, 0.5 * h))

    tau, d, moments = load3(load, b, 3), body[b, ANGULAR_DAMPING], load3(principal, b, MOMENTS)
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


@entry
def step_velocity_verlet(floats: Floats, ints: Ints, steps: int) -> tuple[int, int]:
    """Advance bodies that nothing touches. Returns: steps done, and 0 or 1 if the state stopped being finite."""
    state, body, principal = floats_of(floats, ints, STATE), floats_of(floats, ints, BODY), floats_of(floats, ints, PRINCIPAL)
    load, setting = floats_of(floats, ints, LOAD), floats_of(floats, ints, SETTING)
    kind, count = ints_of(ints, BODY_KIND), ints_of(ints, COUNT)
    h, gyroscopic = setting[0, DT] / count[0, SUBSTEPS], count[0, GYROSCOPIC]
    for step in range(steps):
        for _ in range(count[0, SUBSTEPS]):
            for b in range(count[0, BODIES]):
                velocity_verlet(state, body, principal, kind, load, setting, b, h, gyroscopic)
        count[0, STEPS] += 1
        if not is_finite(state, count[0, BODIES]):
            return step + 1, 1
    return steps, 0
