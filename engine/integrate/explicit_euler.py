"""Explicit Euler for bodies that nothing touches: y <- y + h f(y), with all rates taken at the start of the step.

State y = (p, v, q, m), m the angular momentum in the body's principal frame. First order; a free top gains energy.

Source: Euler, Institutionum calculi integralis I (1768), section 650; Hairer, Norsett, Wanner, Solving Ordinary Differential
Equations I, section I.7.
"""

from engine.compile.jit import entry, kernel
from engine.integrate.finite_state import is_finite
from engine.integrate.free_body import from_principal, is_pushed, spin_rates, to_principal
from engine.integrate.runge_kutta import quat_axpy
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

__all__ = ["step_explicit_euler"]


@kernel
def explicit_euler(
    state: Floats, body: Floats, principal: Floats, kind: Ints, load: Floats, setting: Floats, b: int, h: float, gyroscopic: int
) -> None:
    """Advance body b by h."""
    if not is_pushed(state, kind, b, h):
        return
    v, a = load3(state, b, V), axpy(body[b, INV_MASS], load3(load, b, 0), load3(setting, 0, GRAVITY))
    store3(state, b, P, axpy(h, v, load3(state, b, P)))
    store3(state, b, V, axpy(h, axpy(-body[b, LINEAR_DAMPING], v, a), v))
    q, m = to_principal(state, principal, b)
    q1, m1 = spin_rates(q, m, load3(principal, b, MOMENTS), load3(load, b, 3), body[b, ANGULAR_DAMPING], gyroscopic)
    from_principal(state, principal, b, quat_axpy(h, q1, q), axpy(h, m1, m))


@entry
def step_explicit_euler(floats: Floats, ints: Ints, steps: int) -> tuple[int, int]:
    """Advance bodies that nothing touches. Returns: steps done, and 0 or 1 if the state stopped being finite."""
    state, body, principal = floats_of(floats, ints, STATE), floats_of(floats, ints, BODY), floats_of(floats, ints, PRINCIPAL)
    load, setting = floats_of(floats, ints, LOAD), floats_of(floats, ints, SETTING)
    kind, count = ints_of(ints, BODY_KIND), ints_of(ints, COUNT)
    h, gyroscopic = setting[0, DT] / count[0, SUBSTEPS], count[0, GYROSCOPIC]
    for step in range(steps):
        for _ in range(count[0, SUBSTEPS]):
            for b in range(count[0, BODIES]):
                explicit_euler(state, body, principal, kind, load, setting, b, h, gyroscopic)
        count[0, STEPS] += 1
        if not is_finite(state, count[0, BODIES]):
            return step + 1, 1
    return steps, 0
