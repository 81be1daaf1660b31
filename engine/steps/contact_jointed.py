"""Steps of worlds with contact and joints: in each sub-step, contact sweeps alternate with a direct solve of all joints."""

from engine.compile.jit import entry
from engine.constrain.hold_joints import KNOWN, hold_joints, write_rows
from engine.constrain.hold_joints import NEW as NEW_MATRIX
from engine.constrain.open_joints import open_joint
from engine.contact.find_contacts import find_contacts
from engine.integrate.all_bodies import advance_untouched, drift_touched, kick_touched
from engine.integrate.finite_state import is_finite
from engine.maths.vec import Floats, Ints
from engine.memory.arena import (
    BODIES,
    CHILD,
    COUNT,
    DAMPING_RATIO,
    DT,
    HERTZ,
    ITERATIONS,
    JOINTS,
    MANIFOLD,
    MANIFOLD_KEY,
    MANIFOLDS,
    MAX_PUSH,
    NEW,
    PARENT,
    POINT,
    RELAXATIONS,
    SETTING,
    START,
    STEPS,
    SUBSTEPS,
    TOUCHED,
)  # fmt: skip
from engine.memory.carve import floats_of, ints_of
from engine.memory.tables import bodies_of, joints_of, rows_of
from engine.respond.share_loads import share_loads
from engine.respond.soft import approach, bounce, end_step, end_substep, friction_mode, refresh, sweep, warm_start
from engine.steps.contact import FRESH, slow_approach, soft_factors

__all__ = ["step_contact_jointed"]


@entry
def step_contact_jointed(floats: Floats, ints: Ints, steps: int) -> tuple[int, int]:
    """Advance bodies in contact and held by joints. Returns: as `step_contact`, and `open_joint`."""
    bodies, joints, rows = bodies_of(floats, ints), joints_of(floats, ints), rows_of(floats, ints)
    state, body, turned, _, kind = bodies
    setting, sums = floats_of(floats, ints, SETTING), floats_of(floats, ints, START)
    manifold, point, key = floats_of(floats, ints, MANIFOLD), floats_of(floats, ints, POINT), ints_of(ints, MANIFOLD_KEY)
    count = ints_of(ints, COUNT)
    last, substeps = count[0, BODIES], count[0, SUBSTEPS]
    h = setting[0, DT] / substeps
    rate, mass_scale, keep = soft_factors(setting[0, HERTZ], setting[0, DAMPING_RATIO], h)
    slow, most = slow_approach(setting, h), setting[0, MAX_PUSH]
    for step in range(steps):
        status = find_contacts(floats, ints)
        if status != 0:
            return step, status
        n = count[0, MANIFOLDS]
        for j in range(count[0, JOINTS]):
            kind[joints.kind[j, PARENT], TOUCHED] = 1
            kind[joints.kind[j, CHILD], TOUCHED] = 1
        advance_untouched(bodies, setting, count)
        for substep in range(substeps):
            kick_touched(bodies, setting, count, h)
            equalities, every = write_rows(bodies, joints, rows, h)
            strikes = approach(state, kind, setting, n, manifold, key, point, h, slow)
            patience = FRESH if strikes > 0 or (substep == 0 and count[0, NEW] > 0) else 1
            share_loads(kind, last, sums, n, manifold, key, point)
            warm_start(state, body, turned, n, manifold, key, point)
            hold_joints(bodies, rows, equalities, every, NEW_MATRIX)
            for _ in range(count[0, ITERATIONS] * patience):
                if n > 0:
                    sweep(state, body, turned, n, manifold, key, point, h, rate, mass_scale, keep, most, 1, 0)
                    hold_joints(bodies, rows, equalities, every, KNOWN)
            drift_touched(bodies, count, h)
            if n > 0:
                refresh(state, 0, n, manifold, key, point)
                share_loads(kind, last, sums, n, manifold, key, point)
                for _ in range(count[0, RELAXATIONS] * patience):
                    sweep(state, body, turned, n, manifold, key, point, h, rate, mass_scale, keep, most, 0, 0)
                    hold_joints(bodies, rows, equalities, every, KNOWN)
                if bounce(n, manifold, key, point):
                    for _ in range(FRESH * (count[0, ITERATIONS] + count[0, RELAXATIONS])):
                        sweep(state, body, turned, n, manifold, key, point, h, rate, mass_scale, keep, most, 0, 1)
                        hold_joints(bodies, rows, equalities, every, KNOWN)
                friction_mode(state, body, n, manifold, key, point)
                end_substep(n, key, point)
        end_step(n, manifold, key, point)
        count[0, STEPS] += 1
        if not is_finite(state, last):
            return step + 1, 1
    return steps, open_joint(floats, ints, touching=True)
