"""Steps of worlds with contact under sequential impulses: find contacts, kick, sweep velocities, drift, part."""

from engine.compile.jit import entry
from engine.contact.find_contacts import find_contacts, keep_contacts
from engine.integrate.finite_state import is_finite
from engine.integrate.runge_kutta import runge_kutta_free
from engine.integrate.semi_implicit_euler import drift, drift_free, kick
from engine.maths.vec import Floats, Ints
from engine.memory.arena import (
    BODIES,
    BODY,
    BODY_KIND,
    COUNT,
    DT,
    GYROSCOPIC,
    ITERATIONS,
    LOAD,
    MANIFOLD,
    MANIFOLD_KEY,
    MANIFOLDS,
    MARGIN,
    POINT,
    REST,
    RUNGE_KUTTA,
    SETTING,
    START,
    STATE,
    STEPS,
    SUBSTEPS,
    TOUCHED,
    TURNED,
)  # fmt: skip
from engine.memory.carve import floats_of, ints_of
from engine.respond.sequential_impulses import push_apart, sweep_velocities
from engine.respond.share_loads import share_loads
from engine.respond.soft import approach, bounce, end_step, end_substep, friction_mode, refresh, warm_start
from engine.steps.contact import slow_approach

__all__ = ["step_sequential_impulses"]

SLOP = 0.1
"""Share of the margin [1] that bodies may overlap, so that contacts last from step to step."""


@entry
def step_sequential_impulses(floats: Floats, ints: Ints, steps: int) -> tuple[int, int]:
    """Advance bodies in contact. Returns: as `step_contact`."""
    state, body, turned = floats_of(floats, ints, STATE), floats_of(floats, ints, BODY), floats_of(floats, ints, TURNED)
    load, setting, pseudo = floats_of(floats, ints, LOAD), floats_of(floats, ints, SETTING), floats_of(floats, ints, START)
    manifold, point, key = floats_of(floats, ints, MANIFOLD), floats_of(floats, ints, POINT), ints_of(ints, MANIFOLD_KEY)
    kind, count, rest = ints_of(ints, BODY_KIND), ints_of(ints, COUNT), floats_of(floats, ints, REST)
    bodies, dt, gyroscopic, substeps = count[0, BODIES], setting[0, DT], count[0, GYROSCOPIC], count[0, SUBSTEPS]
    h, iterations = dt / substeps, count[0, ITERATIONS]
    slow, slop = slow_approach(setting, h), SLOP * setting[0, MARGIN]
    for step in range(steps):
        if not keep_contacts(state, body, kind, rest, setting, count, key, point):
            status = find_contacts(floats, ints)
            if status != 0:
                return step, status
        n = count[0, MANIFOLDS]
        for b in range(bodies):
            if kind[b, TOUCHED] == 0:
                if count[0, RUNGE_KUTTA] == 1:
                    runge_kutta_free(state, body, kind, turned, load, setting, b, dt, gyroscopic)
                else:
                    drift_free(state, body, kind, turned, load, setting, b, dt, substeps, gyroscopic)
        if n > 0:
            for _ in range(substeps):
                for b in range(bodies):
                    if kind[b, TOUCHED] == 1:
                        kick(state, body, kind, turned, load, setting, b, h)
                approach(state, kind, setting, n, manifold, key, point, h, slow)
                share_loads(kind, bodies, pseudo, n, manifold, key, point)
                warm_start(state, body, turned, n, manifold, key, point)
                for k in range(iterations):
                    sweep_velocities(state, body, turned, n, manifold, key, point, h, 0, k % 2)
                for b in range(bodies):
                    if kind[b, TOUCHED] == 1:
                        drift(state, body, kind, turned, b, h, gyroscopic)
                refresh(state, 0, n, manifold, key, point)
                if push_apart(state, body, kind, turned, bodies, pseudo, n, manifold, key, point, h, iterations, slop):
                    refresh(state, 0, n, manifold, key, point)
                if bounce(n, manifold, key, point):
                    for k in range(iterations):
                        sweep_velocities(state, body, turned, n, manifold, key, point, h, 1, k % 2)
                friction_mode(state, body, n, manifold, key, point)
                end_substep(n, key, point)
            end_step(n, manifold, key, point)
        count[0, STEPS] += 1
        if not is_finite(state, bodies):
            return step + 1, 1
    return steps, 0
