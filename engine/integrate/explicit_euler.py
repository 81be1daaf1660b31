"""Explicit Euler for bodies that nothing touches: y <- y + h f(y), with all rates taken at the start of the step.

State y = (p, v, q, m), m the angular momentum in the body's principal frame. First order; a free top gains energy.

Source: Euler, Institutionum calculi integralis I (1768), section 650; Hairer, Norsett, Wanner, Solving Ordinary Differential
Equations I, section I.7.
"""

from plumbline.engine.compile.jit import entry, kernel
from plumbline.engine.integrate.free_body import from_principal, is_pushed, law_of, spin_rates, to_principal
from plumbline.engine.integrate.free_steps import advance_free
from plumbline.engine.integrate.runge_kutta import quat_axpy
from plumbline.engine.maths.rows import Floats, Ints, load3, store3
from plumbline.engine.maths.vec import axpy
from plumbline.engine.memory import arena as at
from plumbline.engine.memory.tables import Bodies


@kernel
def explicit_euler(bodies: Bodies, principal: Floats, setting: Floats, b: int, h: float, gyroscopic: int) -> bool:
    """Advance body b by h. Returns: True."""
    state = bodies.state
    if not is_pushed(state, bodies.kind, b, h):
        return True
    law, v = law_of(bodies, principal, setting, b, gyroscopic), load3(state, b, at.V)
    store3(state, b, at.P, axpy(h, v, load3(state, b, at.P)))
    store3(state, b, at.V, axpy(h, axpy(-law.c, v, law.a), v))
    q, m = to_principal(state, principal, b)
    q1, m1 = spin_rates(q, m, law)
    from_principal(state, principal, b, quat_axpy(h, q1, q), axpy(h, m1, m))
    return True


@entry
def step_explicit_euler(floats: Floats, ints: Ints, steps: int) -> tuple[int, int]:
    """Advance bodies that nothing touches. Returns: as `advance_free`."""
    return advance_free(floats, ints, steps, explicit_euler)
