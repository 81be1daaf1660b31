"""Steps of worlds without contact: free bodies, and bodies held by joints under either integrator."""

from engine.compile.jit import entry
from engine.constrain.jointed_runge_kutta import jointed_runge_kutta
from engine.constrain.open_joints import open_joint
from engine.constrain.shake import shake
from engine.constrain.stiffness import mark_stiff
from engine.integrate.all_bodies import advance_untouched
from engine.maths.vec import Floats, Ints
from engine.memory.arena import (
    BODIES,
    BODY,
    BODY_KIND,
    COUNT,
    DT,
    FACTOR,
    GYROSCOPIC,
    JOINT,
    JOINT_KIND,
    JOINTS,
    LOAD,
    MATRIX,
    REACH,
    ROW,
    ROW_BODY,
    SETTING,
    SLOPE,
    START,
    STATE,
    STEPS,
    SUBSTEPS,
    TOTAL,
    TURNED,
    VECTOR,
)  # fmt: skip
from engine.memory.carve import floats_of, ints_of
from engine.memory.status import DIVERGED, DONE
from engine.memory.tables import bodies_of
from engine.steps.count_step import count_step

__all__ = ["step_free", "step_jointed_euler", "step_jointed_runge_kutta"]


@entry
def step_free(floats: Floats, ints: Ints, steps: int) -> tuple[int, int]:
    """Advance bodies that nothing touches. Returns: steps done, and DONE or DIVERGED."""
    bodies, setting, count = bodies_of(floats, ints), floats_of(floats, ints, SETTING), ints_of(ints, COUNT)
    for step in range(steps):
        advance_untouched(bodies, setting, count)
        if count_step(bodies.state, count) == DIVERGED:
            return step + 1, DIVERGED
    return steps, DONE


@entry
def step_jointed_euler(floats: Floats, ints: Ints, steps: int) -> tuple[int, int]:
    """Advance bodies held by joints with SHAKE. Returns: as `step_free`, and `open_joint`."""
    state, body, turned = floats_of(floats, ints, STATE), floats_of(floats, ints, BODY), floats_of(floats, ints, TURNED)
    load, setting, start = floats_of(floats, ints, LOAD), floats_of(floats, ints, SETTING), floats_of(floats, ints, START)
    joint, row, reach = floats_of(floats, ints, JOINT), floats_of(floats, ints, ROW), floats_of(floats, ints, REACH)
    matrix, low, vector = floats_of(floats, ints, MATRIX), floats_of(floats, ints, FACTOR), floats_of(floats, ints, VECTOR)
    kind, count = ints_of(ints, BODY_KIND), ints_of(ints, COUNT)
    joint_kind, row_body = ints_of(ints, JOINT_KIND), ints_of(ints, ROW_BODY)
    bodies, joints, gyroscopic = count[0, BODIES], count[0, JOINTS], count[0, GYROSCOPIC]
    h = setting[0, DT] / count[0, SUBSTEPS]
    for step in range(steps):
        for _ in range(count[0, SUBSTEPS]):
            shake(
                state, body, kind, turned, load, setting, bodies, joint, joint_kind, joints, row, row_body, reach, matrix, low,
                vector, start, h, gyroscopic,
            )  # fmt: skip
        if count_step(state, count) == DIVERGED:
            return step + 1, DIVERGED
    return steps, open_joint(floats, ints, 0)


@entry
def step_jointed_runge_kutta(floats: Floats, ints: Ints, steps: int) -> tuple[int, int]:
    """Advance bodies held by joints with Runge-Kutta and projection. Returns: as `step_free`, and `open_joint`."""
    state, body, turned = floats_of(floats, ints, STATE), floats_of(floats, ints, BODY), floats_of(floats, ints, TURNED)
    load, setting, start = floats_of(floats, ints, LOAD), floats_of(floats, ints, SETTING), floats_of(floats, ints, START)
    slope, total = floats_of(floats, ints, SLOPE), floats_of(floats, ints, TOTAL)
    joint, row, reach = floats_of(floats, ints, JOINT), floats_of(floats, ints, ROW), floats_of(floats, ints, REACH)
    matrix, low, vector = floats_of(floats, ints, MATRIX), floats_of(floats, ints, FACTOR), floats_of(floats, ints, VECTOR)
    kind, count = ints_of(ints, BODY_KIND), ints_of(ints, COUNT)
    joint_kind, row_body = ints_of(ints, JOINT_KIND), ints_of(ints, ROW_BODY)
    bodies, joints, dt, gyroscopic = count[0, BODIES], count[0, JOINTS], setting[0, DT], count[0, GYROSCOPIC]
    for step in range(steps):
        if count[0, STEPS] == 0:
            mark_stiff(state, body, turned, joint, joint_kind, joints, row, row_body, reach, matrix, low, vector, dt)
        jointed_runge_kutta(
            state, body, kind, turned, load, setting, bodies, joint, joint_kind, joints, row, row_body, reach, matrix, low,
            vector, start, slope, total, dt, gyroscopic,
        )  # fmt: skip
        if count_step(state, count) == DIVERGED:
            return step + 1, DIVERGED
    return steps, open_joint(floats, ints, 0)
