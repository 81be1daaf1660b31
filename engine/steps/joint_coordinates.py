"""Steps of worlds without contact whose joints make trees, in joint coordinates, under either integrator."""

from engine.articulated.advance import is_finite_forest, write_state
from engine.articulated.bases import carry_bases, take_jumps
from engine.articulated.momenta import begin_momenta, damp_over, project_rates, resume_rates
from engine.articulated.runge_kutta import ends_with_laws, mark_stiff_columns, runge_kutta
from engine.articulated.semi_implicit_euler import semi_implicit_euler
from engine.articulated.tables import tables_of
from engine.compile.jit import entry
from engine.constrain.reactions import clear_reactions
from engine.integrate.runge_kutta import runge_kutta_free
from engine.integrate.semi_implicit_euler import drift_free
from engine.maths.vec import Floats, Ints
from engine.memory.arena import COUNT, DT, DYNAMIC, GYROSCOPIC, MOTION, SETTING, STEPS, SUBSTEPS
from engine.memory.carve import floats_of, ints_of
from engine.memory.status import DIVERGED, DONE, UNSOLVED
from engine.memory.tables import bodies_of, joints_of
from engine.steps.count_step import count_step

__all__ = ["step_joint_coordinates_euler", "step_joint_coordinates_runge_kutta"]


@entry
def step_joint_coordinates_euler(floats: Floats, ints: Ints, steps: int) -> tuple[int, int]:
    """Advance trees by semi-implicit Euler in sub-steps. Returns: steps done, and DONE, DIVERGED or UNSOLVED.

    Bodies get their poses, and joints what they carry, where it can be seen: after the last step.
    """
    bodies, joints, tables = bodies_of(floats, ints), joints_of(floats, ints), tables_of(floats, ints)
    setting, count = floats_of(floats, ints, SETTING), ints_of(ints, COUNT)
    dt, substeps, gyroscopic = setting[0, DT], count[0, SUBSTEPS], count[0, GYROSCOPIC]
    h, done, status = dt / substeps, 0, DONE
    damp_over(tables, h)
    if take_jumps(tables, bodies, joints) or count[0, STEPS] == 0:
        begin_momenta(tables, bodies, gyroscopic)
    resume_rates(tables)
    clear_reactions(joints)
    while done < steps and status == DONE:
        done += 1
        for _ in range(substeps):
            if status == DONE and not semi_implicit_euler(tables, bodies, joints, setting, h, gyroscopic, done == steps):
                status = UNSOLVED
            carry_bases(tables, bodies, h)
        for n in range(tables.other.shape[0]):
            b = tables.other[n, 0]
            if bodies.kind[b, MOTION] == DYNAMIC:
                drift_free(bodies, setting, b, dt, substeps, gyroscopic)
        finite = is_finite_forest(tables)
        if count_step(bodies.state, count) == DIVERGED or not finite:
            status = DIVERGED
    if done > 0:
        project_rates(tables, bodies, joints, gyroscopic)
        write_state(tables, bodies, joints)
    return done, status


@entry
def step_joint_coordinates_runge_kutta(floats: Floats, ints: Ints, steps: int) -> tuple[int, int]:
    """Advance trees by Runge-Kutta. Returns: as `step_joint_coordinates_euler`."""
    bodies, joints, tables = bodies_of(floats, ints), joints_of(floats, ints), tables_of(floats, ints)
    setting, count = floats_of(floats, ints, SETTING), ints_of(ints, COUNT)
    dt, gyroscopic = setting[0, DT], count[0, GYROSCOPIC]
    done, status = 0, DONE
    if count[0, STEPS] == 0 and steps > 0:
        mark_stiff_columns(tables, bodies, joints, dt)
    take_jumps(tables, bodies, joints)
    ends = ends_with_laws(tables, joints)
    while done < steps and status == DONE:
        done += 1
        clear_reactions(joints)
        if not runge_kutta(tables, bodies, joints, setting, dt, gyroscopic, ends):
            status = UNSOLVED
        for n in range(tables.other.shape[0]):
            b = tables.other[n, 0]
            if bodies.kind[b, MOTION] == DYNAMIC:
                runge_kutta_free(bodies, setting, b, dt, gyroscopic)
        finite = is_finite_forest(tables)
        if count_step(bodies.state, count) == DIVERGED or not finite:
            status = DIVERGED
    if done > 0:
        write_state(tables, bodies, joints)
    return done, status
