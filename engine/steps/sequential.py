"""Steps of worlds with contact under sequential impulses: find contacts, kick, sweep velocities, drift, part."""

from engine.compile.jit import entry
from engine.contact.find_contacts import find_contacts, keep_contacts
from engine.integrate.all_bodies import advance_untouched, drift_touched, kick_touched
from engine.integrate.finite_state import is_finite
from engine.maths.vec import Floats, Ints
from engine.memory.arena import (
    BODIES,
    COUNT,
    DT,
    ITERATIONS,
    MANIFOLD,
    MANIFOLD_KEY,
    MANIFOLDS,
    MARGIN,
    POINT,
    REST,
    SETTING,
    START,
    STEPS,
    SUBSTEPS,
)  # fmt: skip
from engine.memory.carve import floats_of, ints_of
from engine.memory.tables import bodies_of
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
    bodies = bodies_of(floats, ints)
    state, body, turned, _, kind = bodies
    setting, pseudo = floats_of(floats, ints, SETTING), floats_of(floats, ints, START)
    manifold, point, key = floats_of(floats, ints, MANIFOLD), floats_of(floats, ints, POINT), ints_of(ints, MANIFOLD_KEY)
    count, rest = ints_of(ints, COUNT), floats_of(floats, ints, REST)
    last, substeps = count[0, BODIES], count[0, SUBSTEPS]
    h, iterations = setting[0, DT] / substeps, count[0, ITERATIONS]
    slow, slop = slow_approach(setting, h), SLOP * setting[0, MARGIN]
    for step in range(steps):
        if not keep_contacts(state, body, kind, rest, setting, count, key, point):
            status = find_contacts(floats, ints)
            if status != 0:
                return step, status
        n = count[0, MANIFOLDS]
        advance_untouched(bodies, setting, count)
        if n > 0:
            for _ in range(substeps):
                kick_touched(bodies, setting, count, h)
                approach(state, kind, setting, n, manifold, key, point, h, slow)
                share_loads(kind, last, pseudo, n, manifold, key, point)
                warm_start(state, body, turned, n, manifold, key, point)
                for k in range(iterations):
                    sweep_velocities(state, body, turned, n, manifold, key, point, h, 0, k % 2)
                drift_touched(bodies, count, h)
                refresh(state, 0, n, manifold, key, point)
                if push_apart(state, body, kind, turned, last, pseudo, n, manifold, key, point, h, iterations, slop):
                    refresh(state, 0, n, manifold, key, point)
                if bounce(n, manifold, key, point):
                    for k in range(iterations):
                        sweep_velocities(state, body, turned, n, manifold, key, point, h, 1, k % 2)
                friction_mode(state, body, n, manifold, key, point)
                end_substep(n, key, point)
            end_step(n, manifold, key, point)
        count[0, STEPS] += 1
        if not is_finite(state, last):
            return step + 1, 1
    return steps, 0
