"""Explicit Runge-Kutta methods in joint coordinates: the classical one of order four, and Dormand and Prince's adaptive pair.

    y' = (q, q')' = (q', q''(q, q')),  k_i = f(y + h sum_j a_ij k_j),  y <- y + h sum_i b_i k_i

Nothing has to be projected: the coordinates leave the bodies no way off their joints. At the end of a step act limits, and
springs too stiff for stages. All trees of a world share a step; orientations are quaternions that are made unit ones in each
stage. The error of the pair is that of rates relative to all of them, and that of orientations and of hinges [rad]; that of a
way [m] is the integral of that of its rate. It lands on the end of a sub-step exactly.

Source: as `engine.integrate.runge_kutta`.
"""

from typing import Final

from plumbline.engine.articulated import tables as tree
from plumbline.engine.articulated.advance import add_reactions, carry_bases, change_rates, free_columns
from plumbline.engine.articulated.articulated_body import accelerations
from plumbline.engine.articulated.bounded import STIFF_ALONE, solve_laws
from plumbline.engine.articulated.forces import load_links, weigh_links
from plumbline.engine.articulated.motion import move_links, rates_of
from plumbline.engine.articulated.tables import POSE, Trees
from plumbline.engine.compile.jit import kernel
from plumbline.engine.constrain.coordinate import explicit_force, too_stiff
from plumbline.engine.integrate import runge_kutta as explicit
from plumbline.engine.integrate.runge_kutta import DORMAND_PRINCE, RK4, Trial, quat_rate
from plumbline.engine.maths.rows import Floats, load4, store3, store4
from plumbline.engine.maths.vec import quat_unit
from plumbline.engine.memory import arena as at

CARRIED: Final = 6
"""Numbers of a joint in y: the impulses that it has carried. Before them stand poses of links, rates, and poses of bases."""

SLOWEST = 1e-3
"""Rates [rad/s or m/s] are taken as at least this large: at a tolerance of 1e-12, what is less of their error is round-off."""


@kernel
def push_columns(trees: Trees) -> None:
    """Write what springs and drives push now, and rotors, for a stage."""
    kind, column, joints = trees.kind, trees.column, trees.joints
    for i in range(kind.shape[0]):
        j, k = kind[i, tree.JOINT], kind[i, tree.FIRST]
        if j >= 0 and joints.kind[j, at.HAS] != 0:
            column[k, tree.ADDED] = joints.joint[j, at.ARMATURE]
            column[k, tree.PUSH] = explicit_force(joints, j, trees.coordinate[i, 0], column[k, tree.RATE])


@kernel
def ends_with_laws(trees: Trees) -> bool:
    """Whether a step ends with a change of rates: there are limits, or springs or drives that are taken implicitly."""
    for i in range(trees.kind.shape[0]):
        j, kind = trees.kind[i, tree.JOINT], trees.joints.kind
        if j >= 0 and kind[j, at.HAS] & (kind[j, at.IMPLICIT] | at.HAS_LIMITS) != 0:
            return True
    return False


@kernel
def mark_stiff_columns(trees: Trees, dt: float) -> None:
    """Write IMPLICIT for all joints from the present state, by the bounds of `constrain.coordinate`."""
    kind, column, joint, joint_kind = trees.kind, trees.column, trees.joints.joint, trees.joints.kind
    move_links(trees)
    for i in range(kind.shape[0]):
        j, k = kind[i, tree.JOINT], kind[i, tree.FIRST]
        if j < 0 or joint_kind[j, at.HAS] == 0:
            continue
        free_columns(trees)
        column[k, tree.PUSH] = 1.0
        weigh_links(trees)
        accelerations(trees, False)
        joint_kind[j, at.IMPLICIT] = joint_kind[j, at.HAS] & too_stiff(joint, j, dt, trees.along[k, tree.CHANGE])
        column[k, tree.PUSH] = 0.0


@kernel
def room_for_trials(trees: Trees, stages: int) -> Trial:
    """Room for a step of all trees in so many stages."""
    poses = POSE * (trees.kind.shape[0] + trees.other.shape[0])
    return explicit.room_for_trials(poses + trees.column.shape[0] + CARRIED * trees.joints.joint.shape[0], stages)


@kernel
def move(table: Floats, i: int, first: int, count: int, y: Floats, row: int, offset: int, back: bool) -> int:
    """Copy so many numbers of row i of a table into a row of y from `offset` on, or back from there. Returns: behind them."""
    for c in range(count):
        if back:
            table[i, first + c] = y[row, offset + c]
        else:
            y[row, offset + c] = table[i, first + c]
    return offset + count


@kernel
def move_carried(trees: Trees, y: Floats, row: int, back: bool) -> None:
    """As `move`, of what joints have carried."""
    offset = y.shape[1] - CARRIED * trees.joints.joint.shape[0]
    for j in range(trees.joints.joint.shape[0]):
        offset = move(trees.joints.joint, j, at.REACTION, CARRIED, y, row, offset, back)


@kernel
def move_all(trees: Trees, y: Floats, row: int, back: bool) -> None:
    """As `move`, of all that is in y; orientations come back as unit ones."""
    offset = 0
    for i in range(trees.kind.shape[0]):
        offset = move(trees.coordinate, i, 0, POSE, y, row, offset, back)
        if back and trees.kind[i, tree.COLUMNS] > 1:
            store4(trees.coordinate, i, 0, quat_unit(load4(trees.coordinate, i, 0)))
    for k in range(trees.column.shape[0]):
        offset = move(trees.column, k, tree.RATE, 1, y, row, offset, back)
    for n in range(trees.other.shape[0]):
        offset = move(trees.bodies.state, trees.other[n, 0], 0, POSE, y, row, offset, back)
    move_carried(trees, y, row, back)


@kernel
def find_accelerations(trees: Trees) -> None:
    """Write the accelerations at the present coordinates and rates."""
    move_links(trees)
    push_columns(trees)
    load_links(trees)
    accelerations(trees, True)


@kernel
def write_slope(trees: Trees, k: Floats, stage: int) -> None:
    """Write the slopes of coordinates, rates and what joints carry into row `stage` of k; bases go their own way."""
    column, kind = trees.column, trees.kind
    n = kind.shape[0]
    for i in range(n):
        first, offset = kind[i, tree.FIRST], POSE * i
        if kind[i, tree.COLUMNS] == 1:
            k[stage, offset] = column[first, tree.RATE]
        elif kind[i, tree.COLUMNS] > 1:
            store4(k, stage, offset, quat_rate(load4(trees.coordinate, i, 0), rates_of(trees, first)))
            if kind[i, tree.TYPE] == tree.FREE:
                store3(k, stage, offset + tree.POSITION, rates_of(trees, first + 3))
    for c in range(column.shape[0]):
        k[stage, POSE * n + c] = trees.along[c, tree.CHANGE]
    for j in range(trees.joints.joint.shape[0]):
        for c in range(CARRIED):
            trees.joints.joint[j, at.REACTION + c] = 0.0
    add_reactions(trees, 1.0)
    move_carried(trees, k, stage, False)


@kernel
def go_through_stages(h: float, method: Floats, trees: Trees, trial: Trial) -> None:
    """Go on by h from y, where accelerations are known, to its end.

    Args: method: as `RK4`. Where there are as many slopes as rows, the end has one as well.
    """
    write_slope(trees, trial.k, 0)
    for i in range(1, method.shape[0]):
        explicit.go_to_stage(trial, method, i, h)
        move_all(trees, trial.y, 1, True)
        carry_bases(trees, method[i, method.shape[1] - 1] * h)
        if i < trial.k.shape[0]:
            find_accelerations(trees)
            write_slope(trees, trial.k, i)
    move_carried(trees, trial.y, 1, True)


@kernel
def act_at_end(h: float, trees: Trees) -> bool:
    """Let limits, and what is too stiff for stages, change the rates after a step h. Returns: whether laws had an answer."""
    move_links(trees)
    if not solve_laws(trees, h, STIFF_ALONE):
        return False
    add_reactions(trees, h)
    change_rates(trees, h)
    return True


@kernel
def runge_kutta(trees: Trees, h: float, _reactions: bool, trial: Trial) -> bool:
    """Advance all trees and bases by h, always counting what joints carry. Returns: whether the laws had an answer."""
    move_all(trees, trial.y, 0, False)
    find_accelerations(trees)
    go_through_stages(h, RK4, trees, trial)
    return not ends_with_laws(trees) or act_at_end(h, trees)


@kernel
def attempt(h: float, trees: Trees, trial: Trial) -> float:
    """A trial step. Returns: the larger error of rates, relative to all of them, and of any orientation or hinge [rad]."""
    n = trees.kind.shape[0]
    go_through_stages(h, DORMAND_PRINCE, trees, trial)
    error, fastest = explicit.error_of(trial, h, POSE * n, POSE * n + trees.column.shape[0])
    largest = error / max(fastest, SLOWEST)
    for i in range(n):
        if trees.kind[i, tree.TYPE] != at.PRISMATIC:
            turn, _ = explicit.error_of(trial, h, POSE * i, POSE * i + 4)
            # A sum is not finite if any part is not, while a maximum may pass it over.
            largest = turn if not turn <= largest else largest
    return largest


@kernel
def finish(h: float, taken: bool, trees: Trees, trial: Trial) -> bool:
    """End a step that is taken, or go back to its start. Returns: whether the laws had an answer."""
    ends = ends_with_laws(trees)
    if taken and ends and not act_at_end(h, trees):
        return False
    move_all(trees, trial.y, 0, not taken)
    if ends or not taken:
        find_accelerations(trees)
    return True


@kernel
def dormand_prince(trees: Trees, end: float, _reactions: bool, trial: Trial) -> bool:
    """Advance all trees and bases by `end` [s] in as many steps as the tolerance asks for, always counting what joints carry.

    Returns: whether they sufficed, and the laws had an answer.
    """
    passage, tolerance = trees.passage, trees.setting[0, at.STEP_TOLERANCE]
    find_accelerations(trees)
    move_all(trees, trial.y, 0, False)
    stride = explicit.adapt(passage[0, tree.KEPT_STRIDE], end, tolerance, attempt, finish, trees, trial)
    if stride < 0.0:
        return False
    passage[0, tree.KEPT_STRIDE] = stride
    return True
