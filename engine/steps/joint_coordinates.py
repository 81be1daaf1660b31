"""Steps of worlds without contact whose joints make trees, in joint coordinates, one entry for each integrator.

Bodies get their poses, and joints what they carry, where it can be seen: after the last step.
Each returns: steps done, and DONE, DIVERGED or UNSOLVED.
"""

from collections.abc import Callable
from typing import Any

from plumbline.engine.articulated import runge_kutta as explicit
from plumbline.engine.articulated.advance import is_finite_forest, take_jumps, write_state
from plumbline.engine.articulated.column_momenta import begin_column_momenta, rates_of_momenta
from plumbline.engine.articulated.implicit_midpoint import implicit_midpoint as implicit_midpoint_trees
from plumbline.engine.articulated.momenta import begin_momenta, damp_over, write_kept_velocities
from plumbline.engine.articulated.semi_implicit_euler import semi_implicit_euler
from plumbline.engine.articulated.tables import Trees, trees_of
from plumbline.engine.compile.jit import entry, kernel, template
from plumbline.engine.constrain.reactions import clear_reactions
from plumbline.engine.integrate.implicit_midpoint import implicit_midpoint
from plumbline.engine.integrate.runge_kutta import LENGTH, RK4_STAGES, STAGES, dormand_prince, room_for_trials, runge_kutta_free
from plumbline.engine.integrate.semi_implicit_euler import drift_free
from plumbline.engine.maths.rows import Floats, Ints
from plumbline.engine.memory import arena as at
from plumbline.engine.memory.carve import floats_of, ints_of
from plumbline.engine.memory.status import DIVERGED, DONE, UNSOLVED
from plumbline.engine.memory.tables import Bodies


@kernel
def euler_free(bodies: Bodies, _principal: Floats, setting: Floats, b: int, h: float, gyroscopic: int) -> bool:
    """`drift_free` as `advance` asks for it."""
    drift_free(bodies, setting, b, h, 1, gyroscopic)
    return True


@kernel
def rk4_free(bodies: Bodies, _principal: Floats, setting: Floats, b: int, h: float, gyroscopic: int) -> bool:
    """`runge_kutta_free` as `advance` asks for it."""
    runge_kutta_free(bodies, setting, b, h, gyroscopic)
    return True


@template
def advance(
    floats: Floats,
    ints: Ints,
    steps: int,
    trees: Trees,
    summed: bool,
    move_trees: Callable[..., bool],
    move_free: Callable[..., bool],
    rooms: tuple[Any, Any],
) -> tuple[int, int]:
    """The loop of all these steps.

    Args: summed: whether what joints carry is counted in every step, not the last alone; move_trees: (trees, h [s], whether
        to count it, *room) -> whether they were advanced by h; move_free: as in `advance_free`, of a body in no tree; rooms:
        of both.
    """
    principal, count, (room, free_room) = floats_of(floats, ints, at.PRINCIPAL), ints_of(ints, at.COUNT), rooms
    substeps = 1 if count[0, at.RUNGE_KUTTA] == 1 else count[0, at.SUBSTEPS]
    bodies, setting, h, done, status = trees.bodies, trees.setting, trees.setting[0, at.DT] / substeps, 0, DONE
    while done < steps and status == DONE:
        done += 1
        if summed:
            clear_reactions(trees.joints)
        for _ in range(substeps):
            if status == DONE and not move_trees(trees, h, done == steps, *room):
                status = UNSOLVED
            for n in range(trees.other.shape[0]):
                b = trees.other[n, 0]
                if bodies.kind[b, at.MOTION] == at.DYNAMIC and not move_free(
                    bodies, principal, setting, b, h, trees.gyroscopic, *free_room
                ):
                    status = UNSOLVED
        count[0, at.STEPS] += 1
        if not is_finite_forest(trees):
            status = DIVERGED
    return done, status


@entry
def step_joint_coordinates_euler(floats: Floats, ints: Ints, steps: int) -> tuple[int, int]:
    """By semi-implicit Euler. A base that is told another velocity on the way needs nothing: momenta are handed on."""
    trees, count = trees_of(floats, ints), ints_of(ints, at.COUNT)
    damp_over(trees, trees.setting[0, at.DT] / count[0, at.SUBSTEPS])
    if count[0, at.STEPS] == 0:
        take_jumps(trees)
        begin_momenta(trees)
    clear_reactions(trees.joints)
    ended = advance(floats, ints, steps, trees, False, semi_implicit_euler, euler_free, ((None, 0), ()))
    write_state(trees)
    write_kept_velocities(trees)
    return ended


@entry
def step_joint_coordinates_midpoint(floats: Floats, ints: Ints, steps: int) -> tuple[int, int]:
    """By implicit midpoint."""
    trees, count = trees_of(floats, ints), ints_of(ints, at.COUNT)
    if take_jumps(trees) or count[0, at.STEPS] == 0:
        begin_column_momenta(trees)
    clear_reactions(trees.joints)
    ended = advance(floats, ints, steps, trees, False, implicit_midpoint_trees, implicit_midpoint, ((), ()))
    rates_of_momenta(trees)
    write_state(trees)
    return ended


@entry
def step_joint_coordinates_adaptive(floats: Floats, ints: Ints, steps: int) -> tuple[int, int]:
    """By Dormand and Prince's method, sub-step by sub-step."""
    trees = trees_of(floats, ints)
    rooms = (explicit.room_for_trials(trees, STAGES),), (room_for_trials(LENGTH, STAGES),)
    take_jumps(trees)
    ended = advance(floats, ints, steps, trees, True, explicit.dormand_prince, dormand_prince, rooms)
    write_state(trees)
    return ended


@entry
def step_joint_coordinates_runge_kutta(floats: Floats, ints: Ints, steps: int) -> tuple[int, int]:
    """By Runge-Kutta, without sub-steps."""
    trees = trees_of(floats, ints)
    if ints_of(ints, at.COUNT)[0, at.STEPS] == 0:
        explicit.mark_stiff_columns(trees, trees.setting[0, at.DT])
    take_jumps(trees)
    rooms = (explicit.room_for_trials(trees, RK4_STAGES),), ()
    ended = advance(floats, ints, steps, trees, True, explicit.runge_kutta, rk4_free, rooms)
    write_state(trees)
    return ended
