"""Steps of worlds without contact: free bodies, and bodies held by joints under either integrator."""

from plumbline.engine.compile.jit import entry
from plumbline.engine.constrain.jointed_runge_kutta import jointed_runge_kutta, mark_stiff, stages_of
from plumbline.engine.constrain.open_joints import open_joint
from plumbline.engine.constrain.projection import shake
from plumbline.engine.constrain.reactions import clear_reactions
from plumbline.engine.integrate.runge_kutta import runge_kutta_free
from plumbline.engine.integrate.semi_implicit_euler import drift_free
from plumbline.engine.maths.rows import Floats, Ints
from plumbline.engine.memory import arena as at
from plumbline.engine.memory.carve import floats_of, ints_of
from plumbline.engine.memory.status import DIVERGED, DONE
from plumbline.engine.memory.tables import bodies_of, joints_of, rows_of
from plumbline.engine.steps.count_step import count_step


@entry
def step_free(floats: Floats, ints: Ints, steps: int) -> tuple[int, int]:
    """Advance bodies that nothing touches. Returns: steps done, and DONE or DIVERGED."""
    bodies, setting, count = bodies_of(floats, ints), floats_of(floats, ints, at.SETTING), ints_of(ints, at.COUNT)
    last, dt, gyroscopic, substeps = count[0, at.BODIES], setting[0, at.DT], count[0, at.GYROSCOPIC], count[0, at.SUBSTEPS]
    for step in range(steps):
        if count[0, at.RUNGE_KUTTA] == 1:
            for b in range(last):
                runge_kutta_free(bodies, setting, b, dt, gyroscopic)
        else:
            for b in range(last):
                drift_free(bodies, setting, b, dt, substeps, gyroscopic)
        if count_step(bodies.state, count) == DIVERGED:
            return step + 1, DIVERGED
    return steps, DONE


@entry
def step_jointed_euler(floats: Floats, ints: Ints, steps: int) -> tuple[int, int]:
    """Advance bodies held by joints with SHAKE. Returns: as `step_free`, and `open_joint`."""
    bodies, joints, rows = bodies_of(floats, ints), joints_of(floats, ints), rows_of(floats, ints)
    setting, start, count = floats_of(floats, ints, at.SETTING), floats_of(floats, ints, at.START), ints_of(ints, at.COUNT)
    h, gyroscopic = setting[0, at.DT] / count[0, at.SUBSTEPS], count[0, at.GYROSCOPIC]
    for step in range(steps):
        clear_reactions(joints)
        for _ in range(count[0, at.SUBSTEPS]):
            shake(bodies, joints, rows, start, setting, h, gyroscopic)
        if count_step(bodies.state, count) == DIVERGED:
            return step + 1, DIVERGED
    return steps, open_joint(floats, ints, touching=False)


@entry
def step_jointed_runge_kutta(floats: Floats, ints: Ints, steps: int) -> tuple[int, int]:
    """Advance bodies held by joints with Runge-Kutta and projection. Returns: as `step_free`, and `open_joint`."""
    bodies, joints, rows = bodies_of(floats, ints), joints_of(floats, ints), rows_of(floats, ints)
    setting, stages, count = floats_of(floats, ints, at.SETTING), stages_of(floats, ints), ints_of(ints, at.COUNT)
    dt, gyroscopic = setting[0, at.DT], count[0, at.GYROSCOPIC]
    for step in range(steps):
        if count[0, at.STEPS] == 0:
            mark_stiff(bodies, joints, rows, dt)
        clear_reactions(joints)
        jointed_runge_kutta(bodies, joints, rows, stages, setting, dt, gyroscopic)
        if count_step(bodies.state, count) == DIVERGED:
            return step + 1, DIVERGED
    return steps, open_joint(floats, ints, touching=False)
