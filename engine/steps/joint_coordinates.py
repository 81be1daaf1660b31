"""Steps of worlds without contact whose joints make trees, in joint coordinates, one entry for each integrator."""

from plumbline.engine.articulated import runge_kutta as explicit
from plumbline.engine.articulated.advance import is_finite_forest, take_jumps, write_state
from plumbline.engine.articulated.column_momenta import begin_column_momenta, rates_of_momenta
from plumbline.engine.articulated.implicit_midpoint import implicit_midpoint as implicit_midpoint_tree
from plumbline.engine.articulated.momenta import begin_momenta, damp_over, write_kept_velocities
from plumbline.engine.articulated.semi_implicit_euler import semi_implicit_euler
from plumbline.engine.articulated.tables import trees_of
from plumbline.engine.compile.jit import entry
from plumbline.engine.constrain.reactions import clear_reactions
from plumbline.engine.integrate.implicit_midpoint import implicit_midpoint
from plumbline.engine.integrate.runge_kutta import LENGTH, RK4_STAGES, STAGES, dormand_prince, room_for_trials, runge_kutta_free
from plumbline.engine.integrate.semi_implicit_euler import drift_free
from plumbline.engine.maths.rows import Floats, Ints
from plumbline.engine.memory import arena as at
from plumbline.engine.memory.carve import floats_of, ints_of
from plumbline.engine.memory.status import DIVERGED, DONE, UNSOLVED


@entry
def step_joint_coordinates_euler(floats: Floats, ints: Ints, steps: int) -> tuple[int, int]:
    """Advance trees by semi-implicit Euler in sub-steps. Returns: steps done, and DONE, DIVERGED or UNSOLVED.

    A base that is told another velocity on the way needs nothing, since momenta are handed on.
    Bodies get their poses, and joints what they carry, where it can be seen: after the last step.
    """
    trees = trees_of(floats, ints)
    bodies, joints = trees.bodies, trees.joints
    setting, count = floats_of(floats, ints, at.SETTING), ints_of(ints, at.COUNT)
    dt, substeps, gyroscopic = setting[0, at.DT], count[0, at.SUBSTEPS], count[0, at.GYROSCOPIC]
    h, done, status = dt / substeps, 0, DONE
    damp_over(trees, h)
    if count[0, at.STEPS] == 0:
        take_jumps(trees)
        begin_momenta(trees)
    clear_reactions(joints)
    while done < steps and status == DONE:
        done += 1
        for _ in range(substeps):
            if status == DONE and not semi_implicit_euler(trees, None, h, 0, done == steps):
                status = UNSOLVED
        for n in range(trees.other.shape[0]):
            b = trees.other[n, 0]
            if bodies.kind[b, at.MOTION] == at.DYNAMIC:
                drift_free(bodies, setting, b, dt, substeps, gyroscopic)
        count[0, at.STEPS] += 1
        if not is_finite_forest(trees):
            status = DIVERGED
    if done > 0:
        write_state(trees)
        write_kept_velocities(trees)
    return done, status


@entry
def step_joint_coordinates_midpoint(floats: Floats, ints: Ints, steps: int) -> tuple[int, int]:
    """Advance trees by implicit midpoint in sub-steps. Returns: as `step_joint_coordinates_euler`."""
    trees = trees_of(floats, ints)
    bodies, joints = trees.bodies, trees.joints
    setting, count = floats_of(floats, ints, at.SETTING), ints_of(ints, at.COUNT)
    principal = floats_of(floats, ints, at.PRINCIPAL)
    substeps, gyroscopic = count[0, at.SUBSTEPS], count[0, at.GYROSCOPIC]
    h, done, status = setting[0, at.DT] / substeps, 0, DONE
    if take_jumps(trees) or count[0, at.STEPS] == 0:
        begin_column_momenta(trees)
    clear_reactions(joints)
    while done < steps and status == DONE:
        done += 1
        for _ in range(substeps):
            if status == DONE and not implicit_midpoint_tree(trees, h, done == steps):
                status = UNSOLVED
            for n in range(trees.other.shape[0]):
                b = trees.other[n, 0]
                if bodies.kind[b, at.MOTION] == at.DYNAMIC and not implicit_midpoint(
                    bodies, principal, setting, b, h, gyroscopic
                ):
                    status = UNSOLVED
        count[0, at.STEPS] += 1
        if not is_finite_forest(trees):
            status = DIVERGED
    if done > 0:
        rates_of_momenta(trees)
        write_state(trees)
    return done, status


@entry
def step_joint_coordinates_adaptive(floats: Floats, ints: Ints, steps: int) -> tuple[int, int]:
    """Advance trees by Dormand and Prince's method, sub-step by sub-step. Returns: as `step_joint_coordinates_euler`."""
    trees = trees_of(floats, ints)
    bodies, joints = trees.bodies, trees.joints
    setting, count = floats_of(floats, ints, at.SETTING), ints_of(ints, at.COUNT)
    principal = floats_of(floats, ints, at.PRINCIPAL)
    substeps, gyroscopic = count[0, at.SUBSTEPS], count[0, at.GYROSCOPIC]
    h, done, status = setting[0, at.DT] / substeps, 0, DONE
    trial, free = explicit.room_for_trials(trees, STAGES), room_for_trials(LENGTH, STAGES)
    take_jumps(trees)
    while done < steps and status == DONE:
        done += 1
        clear_reactions(joints)
        for _ in range(substeps):
            if status == DONE and not explicit.dormand_prince(h, trees, trial):
                status = UNSOLVED
            for n in range(trees.other.shape[0]):
                b = trees.other[n, 0]
                if bodies.kind[b, at.MOTION] == at.DYNAMIC and not dormand_prince(
                    bodies, principal, setting, b, h, gyroscopic, free
                ):
                    status = UNSOLVED
        count[0, at.STEPS] += 1
        if not is_finite_forest(trees):
            status = DIVERGED
    if done > 0:
        write_state(trees)
    return done, status


@entry
def step_joint_coordinates_runge_kutta(floats: Floats, ints: Ints, steps: int) -> tuple[int, int]:
    """Advance trees by Runge-Kutta. Returns: as `step_joint_coordinates_euler`."""
    trees = trees_of(floats, ints)
    bodies, joints = trees.bodies, trees.joints
    setting, count = floats_of(floats, ints, at.SETTING), ints_of(ints, at.COUNT)
    dt, gyroscopic = setting[0, at.DT], count[0, at.GYROSCOPIC]
    done, status, trial = 0, DONE, explicit.room_for_trials(trees, RK4_STAGES)
    if count[0, at.STEPS] == 0 and steps > 0:
        explicit.mark_stiff_columns(trees, dt)
    take_jumps(trees)
    while done < steps and status == DONE:
        done += 1
        clear_reactions(joints)
        if not explicit.runge_kutta(dt, trees, trial):
            status = UNSOLVED
        for n in range(trees.other.shape[0]):
            b = trees.other[n, 0]
            if bodies.kind[b, at.MOTION] == at.DYNAMIC:
                runge_kutta_free(bodies, setting, b, dt, gyroscopic)
        count[0, at.STEPS] += 1
        if not is_finite_forest(trees):
            status = DIVERGED
    if done > 0:
        write_state(trees)
    return done, status
