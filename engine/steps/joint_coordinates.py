"""Steps of worlds without contact whose joints make trees, in joint coordinates, one entry for each integrator."""

from plumbline.engine.articulated import runge_kutta as explicit
from plumbline.engine.articulated.advance import carry_bases, is_finite_forest, take_jumps, write_state
from plumbline.engine.articulated.column_momenta import begin_column_momenta, rates_of_momenta
from plumbline.engine.articulated.implicit_midpoint import implicit_midpoint as implicit_midpoint_tree
from plumbline.engine.articulated.momenta import begin_momenta, damp_over, write_kept_velocities
from plumbline.engine.articulated.semi_implicit_euler import semi_implicit_euler
from plumbline.engine.articulated.tables import tables_of
from plumbline.engine.compile.jit import entry
from plumbline.engine.constrain.reactions import clear_reactions
from plumbline.engine.integrate.implicit_midpoint import implicit_midpoint
from plumbline.engine.integrate.runge_kutta import LENGTH, RK4_STAGES, STAGES, dormand_prince, room_for_trials, runge_kutta_free
from plumbline.engine.integrate.semi_implicit_euler import drift_free
from plumbline.engine.maths.rows import Floats, Ints
from plumbline.engine.memory import arena as at
from plumbline.engine.memory.carve import floats_of, ints_of
from plumbline.engine.memory.status import DIVERGED, DONE, UNSOLVED
from plumbline.engine.memory.tables import bodies_of, joints_of


@entry
def step_joint_coordinates_euler(floats: Floats, ints: Ints, steps: int) -> tuple[int, int]:
    """Advance trees by semi-implicit Euler in sub-steps. Returns: steps done, and DONE, DIVERGED or UNSOLVED.

    A base that is told another velocity on the way needs nothing, since momenta are handed on.
    Bodies get their poses, and joints what they carry, where it can be seen: after the last step.
    """
    bodies, joints, tables = bodies_of(floats, ints), joints_of(floats, ints), tables_of(floats, ints)
    setting, count = floats_of(floats, ints, at.SETTING), ints_of(ints, at.COUNT)
    dt, substeps, gyroscopic = setting[0, at.DT], count[0, at.SUBSTEPS], count[0, at.GYROSCOPIC]
    h, done, status = dt / substeps, 0, DONE
    damp_over(tables, h)
    if count[0, at.STEPS] == 0:
        take_jumps(tables, bodies, joints)
        begin_momenta(tables, bodies, gyroscopic)
    clear_reactions(joints)
    while done < steps and status == DONE:
        done += 1
        for _ in range(substeps):
            if status == DONE and not semi_implicit_euler(tables, bodies, joints, setting, h, gyroscopic, done == steps):
                status = UNSOLVED
            carry_bases(tables, bodies, h)
        for n in range(tables.other.shape[0]):
            b = tables.other[n, 0]
            if bodies.kind[b, at.MOTION] == at.DYNAMIC:
                drift_free(bodies, setting, b, dt, substeps, gyroscopic)
        count[0, at.STEPS] += 1
        if not is_finite_forest(tables, bodies.state):
            status = DIVERGED
    if done > 0:
        write_state(tables, bodies, joints)
        write_kept_velocities(tables, bodies, gyroscopic)
    return done, status


@entry
def step_joint_coordinates_midpoint(floats: Floats, ints: Ints, steps: int) -> tuple[int, int]:
    """Advance trees by implicit midpoint in sub-steps. Returns: as `step_joint_coordinates_euler`."""
    bodies, joints, tables = bodies_of(floats, ints), joints_of(floats, ints), tables_of(floats, ints)
    setting, count = floats_of(floats, ints, at.SETTING), ints_of(ints, at.COUNT)
    principal = floats_of(floats, ints, at.PRINCIPAL)
    substeps, gyroscopic = count[0, at.SUBSTEPS], count[0, at.GYROSCOPIC]
    h, done, status = setting[0, at.DT] / substeps, 0, DONE
    if take_jumps(tables, bodies, joints) or count[0, at.STEPS] == 0:
        begin_column_momenta(tables, bodies, joints, setting, gyroscopic)
    ends = explicit.ends_with_laws(tables, joints)
    clear_reactions(joints)
    while done < steps and status == DONE:
        done += 1
        for _ in range(substeps):
            if status == DONE and not implicit_midpoint_tree(
                tables, bodies, joints, setting, h, gyroscopic, ends, done == steps
            ):
                status = UNSOLVED
            for n in range(tables.other.shape[0]):
                b = tables.other[n, 0]
                if bodies.kind[b, at.MOTION] == at.DYNAMIC and not implicit_midpoint(
                    bodies, principal, setting, b, h, gyroscopic
                ):
                    status = UNSOLVED
        count[0, at.STEPS] += 1
        if not is_finite_forest(tables, bodies.state):
            status = DIVERGED
    if done > 0:
        rates_of_momenta(tables, bodies, joints, setting, gyroscopic)
        write_state(tables, bodies, joints)
    return done, status


@entry
def step_joint_coordinates_adaptive(floats: Floats, ints: Ints, steps: int) -> tuple[int, int]:
    """Advance trees by Dormand and Prince's method, sub-step by sub-step. Returns: as `step_joint_coordinates_euler`."""
    bodies, joints, tables = bodies_of(floats, ints), joints_of(floats, ints), tables_of(floats, ints)
    setting, count = floats_of(floats, ints, at.SETTING), ints_of(ints, at.COUNT)
    principal = floats_of(floats, ints, at.PRINCIPAL)
    substeps, gyroscopic = count[0, at.SUBSTEPS], count[0, at.GYROSCOPIC]
    h, done, status = setting[0, at.DT] / substeps, 0, DONE
    trial, free = explicit.room_for_trials(tables, STAGES), room_for_trials(LENGTH, STAGES)
    take_jumps(tables, bodies, joints)
    trees = explicit.trees_of(tables, bodies, joints, setting, gyroscopic)
    while done < steps and status == DONE:
        done += 1
        clear_reactions(joints)
        for _ in range(substeps):
            if status == DONE and not explicit.dormand_prince(h, trees, trial):
                status = UNSOLVED
            for n in range(tables.other.shape[0]):
                b = tables.other[n, 0]
                if bodies.kind[b, at.MOTION] == at.DYNAMIC and not dormand_prince(
                    bodies, principal, setting, b, h, gyroscopic, free
                ):
                    status = UNSOLVED
        count[0, at.STEPS] += 1
        if not is_finite_forest(tables, bodies.state):
            status = DIVERGED
    if done > 0:
        write_state(tables, bodies, joints)
    return done, status


@entry
def step_joint_coordinates_runge_kutta(floats: Floats, ints: Ints, steps: int) -> tuple[int, int]:
    """Advance trees by Runge-Kutta. Returns: as `step_joint_coordinates_euler`."""
    bodies, joints, tables = bodies_of(floats, ints), joints_of(floats, ints), tables_of(floats, ints)
    setting, count = floats_of(floats, ints, at.SETTING), ints_of(ints, at.COUNT)
    dt, gyroscopic = setting[0, at.DT], count[0, at.GYROSCOPIC]
    done, status, trial = 0, DONE, explicit.room_for_trials(tables, RK4_STAGES)
    if count[0, at.STEPS] == 0 and steps > 0:
        explicit.mark_stiff_columns(tables, bodies, joints, dt)
    take_jumps(tables, bodies, joints)
    trees = explicit.trees_of(tables, bodies, joints, setting, gyroscopic)
    while done < steps and status == DONE:
        done += 1
        clear_reactions(joints)
        if not explicit.runge_kutta(dt, trees, trial):
            status = UNSOLVED
        for n in range(tables.other.shape[0]):
            b = tables.other[n, 0]
            if bodies.kind[b, at.MOTION] == at.DYNAMIC:
                runge_kutta_free(bodies, setting, b, dt, gyroscopic)
        count[0, at.STEPS] += 1
        if not is_finite_forest(tables, bodies.state):
            status = DIVERGED
    if done > 0:
        write_state(tables, bodies, joints)
    return done, status
