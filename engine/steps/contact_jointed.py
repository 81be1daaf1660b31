"""Steps of worlds with contact and joints: in each sub-step, contact sweeps alternate with a direct solve of all joints."""

from engine.compile.jit import entry, kernel
from engine.constrain.coordinate import bounded_rows
from engine.constrain.direct import assemble, solve_bounded
from engine.constrain.joint_rows import equality_rows
from engine.constrain.open_joints import open_joint
from engine.contact.find_contacts import find_contacts
from engine.integrate.finite_state import is_finite
from engine.integrate.runge_kutta import runge_kutta_free
from engine.integrate.semi_implicit_euler import drift, drift_free, kick
from engine.maths.vec import Floats, Ints
from engine.memory.arena import (
    BIAS,
    BODIES,
    BODY,
    BODY_KIND,
    CHILD,
    COUNT,
    DAMPING_RATIO,
    DT,
    FACTOR,
    GAP,
    GYROSCOPIC,
    HERTZ,
    HIGH,
    IMPULSE,
    ITERATIONS,
    JOINT,
    JOINT_KIND,
    JOINTS,
    LOAD,
    LOW,
    MANIFOLD,
    MANIFOLD_KEY,
    MANIFOLDS,
    MATRIX,
    MAX_PUSH,
    NEW,
    PARENT,
    POINT,
    REACH,
    RELAXATIONS,
    ROW,
    ROW_BODY,
    RUNGE_KUTTA,
    SETTING,
    SOFTNESS,
    START,
    STATE,
    STEPS,
    SUBSTEPS,
    TOUCHED,
    TURNED,
    VECTOR,
)  # fmt: skip
from engine.memory.carve import floats_of, ints_of
from engine.respond.share_loads import share_loads
from engine.respond.soft import approach, bounce, end_step, end_substep, friction_mode, refresh, sweep, warm_start
from engine.steps.contact import FRESH, slow_approach, soft_factors

__all__ = ["step_contact_jointed"]


@kernel
def hold_joints(
    state: Floats, row: Floats, row_body: Ints, equalities: int, rows: int, body: Floats, turned: Floats, reach: Floats,
    matrix: Floats, low: Floats, vector: Floats, known: int
) -> None:  # fmt: skip
    """Solve all rows for the present velocities, and count what soft and bounded rows have given against their law.

    Args: known: 1 from the second time on since the matrix was assembled.
    """
    solve_bounded(state, row, row_body, equalities, rows, body, turned, reach, matrix, low, vector, known)
    for r in range(equalities, rows):
        impulse = vector[IMPULSE, r]
        row[r, BIAS] += row[r, SOFTNESS] * impulse
        row[r, LOW] -= impulse
        row[r, HIGH] -= impulse


@entry
def step_contact_jointed(floats: Floats, ints: Ints, steps: int) -> tuple[int, int]:
    """Advance bodies in contact and held by joints. Returns: as `step_contact`, and `open_joint`."""
    state, body, turned = floats_of(floats, ints, STATE), floats_of(floats, ints, BODY), floats_of(floats, ints, TURNED)
    load, setting, sums = floats_of(floats, ints, LOAD), floats_of(floats, ints, SETTING), floats_of(floats, ints, START)
    manifold, point, key = floats_of(floats, ints, MANIFOLD), floats_of(floats, ints, POINT), ints_of(ints, MANIFOLD_KEY)
    joint, row, reach = floats_of(floats, ints, JOINT), floats_of(floats, ints, ROW), floats_of(floats, ints, REACH)
    matrix, low, vector = floats_of(floats, ints, MATRIX), floats_of(floats, ints, FACTOR), floats_of(floats, ints, VECTOR)
    kind, count = ints_of(ints, BODY_KIND), ints_of(ints, COUNT)
    joint_kind, row_body = ints_of(ints, JOINT_KIND), ints_of(ints, ROW_BODY)
    bodies, dt, gyroscopic, substeps = count[0, BODIES], setting[0, DT], count[0, GYROSCOPIC], count[0, SUBSTEPS]
    joints = count[0, JOINTS]
    h = dt / substeps
    rate, mass_scale, keep = soft_factors(setting[0, HERTZ], setting[0, DAMPING_RATIO], h)
    slow, most = slow_approach(setting, h), setting[0, MAX_PUSH]
    for step in range(steps):
        status = find_contacts(floats, ints)
        if status != 0:
            return step, status
        n = count[0, MANIFOLDS]
        for j in range(joints):
            kind[joint_kind[j, PARENT], TOUCHED] = 1
            kind[joint_kind[j, CHILD], TOUCHED] = 1
        for b in range(bodies):
            if kind[b, TOUCHED] == 0:
                if count[0, RUNGE_KUTTA] == 1:
                    runge_kutta_free(state, body, kind, turned, load, setting, b, dt, gyroscopic)
                else:
                    drift_free(state, body, kind, turned, load, setting, b, dt, substeps, gyroscopic)
        for substep in range(substeps):
            for b in range(bodies):
                if kind[b, TOUCHED] == 1:
                    kick(state, body, kind, turned, load, setting, b, h)
            equalities = equality_rows(state, joint, joint_kind, joints, row, row_body)
            for r in range(equalities):
                row[r, BIAS] = row[r, GAP] / h
            rows = bounded_rows(state, joint, joint_kind, joints, row, row_body, equalities, h, 0)
            assemble(row, row_body, 0, rows, body, turned, reach, matrix)
            strikes = approach(state, kind, setting, n, manifold, key, point, h, slow)
            patience = FRESH if strikes > 0 or (substep == 0 and count[0, NEW] > 0) else 1
            share_loads(kind, bodies, sums, n, manifold, key, point)
            warm_start(state, body, turned, n, manifold, key, point)
            hold_joints(state, row, row_body, equalities, rows, body, turned, reach, matrix, low, vector, 0)
            for _ in range(count[0, ITERATIONS] * patience):
                if n > 0:
                    sweep(state, body, turned, n, manifold, key, point, h, rate, mass_scale, keep, most, 1, 0)
                    hold_joints(state, row, row_body, equalities, rows, body, turned, reach, matrix, low, vector, 1)
            for b in range(bodies):
                if kind[b, TOUCHED] == 1:
                    drift(state, body, kind, turned, b, h, gyroscopic)
            if n > 0:
                refresh(state, 0, n, manifold, key, point)
                share_loads(kind, bodies, sums, n, manifold, key, point)
                for _ in range(count[0, RELAXATIONS] * patience):
                    sweep(state, body, turned, n, manifold, key, point, h, rate, mass_scale, keep, most, 0, 0)
                    hold_joints(state, row, row_body, equalities, rows, body, turned, reach, matrix, low, vector, 1)
                if bounce(n, manifold, key, point):
                    for _ in range(FRESH * (count[0, ITERATIONS] + count[0, RELAXATIONS])):
                        sweep(state, body, turned, n, manifold, key, point, h, rate, mass_scale, keep, most, 0, 1)
                        hold_joints(state, row, row_body, equalities, rows, body, turned, reach, matrix, low, vector, 1)
                friction_mode(state, body, n, manifold, key, point)
                end_substep(n, key, point)
        end_step(n, manifold, key, point)
        count[0, STEPS] += 1
        if not is_finite(state, bodies):
            return step + 1, 1
    return steps, open_joint(floats, ints, 1)
