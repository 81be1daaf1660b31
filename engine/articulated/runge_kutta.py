"""Explicit Runge-Kutta methods in joint coordinates: the classical one of order four, and Dormand and Prince's adaptive pair.

    y' = (q, q')' = (q', q''(q, q')),  k_i = f(y + h sum_j a_ij k_j),  y <- y + h sum_i b_i k_i

Nothing has to be projected: the coordinates leave the bodies no way off their joints. At the end of a step act limits, and
springs too stiff for stages. All trees of a world share a step; orientations are quaternions that are made unit ones in each
stage. The error of the pair is that of rates relative to all of them, and that of orientations and of hinges [rad]; that of a
way [m] is the integral of that of its rate. It lands on the end of a sub-step exactly.

Source: as `engine.integrate.runge_kutta`.
"""

from typing import Final, NamedTuple

import numpy as np

from plumbline.engine.articulated import tables as tree
from plumbline.engine.articulated.advance import add_reactions, carry_bases, change_rates, free_columns
from plumbline.engine.articulated.articulated_body import accelerations
from plumbline.engine.articulated.bounded import solve_laws
from plumbline.engine.articulated.forces import load_links, weigh_links
from plumbline.engine.articulated.laws import STIFF_ALONE
from plumbline.engine.articulated.motion import move_links, rates_of
from plumbline.engine.articulated.tables import Tables
from plumbline.engine.compile.jit import kernel
from plumbline.engine.constrain.coordinate import DAMPED, STIFF, explicit_force
from plumbline.engine.integrate import runge_kutta as explicit
from plumbline.engine.integrate.runge_kutta import DORMAND_PRINCE, RK4, Trial, quat_rate
from plumbline.engine.maths.rows import Floats, load4, store4
from plumbline.engine.maths.vec import quat_unit
from plumbline.engine.memory import arena as at
from plumbline.engine.memory.tables import Bodies, Joints

POSE: Final = 7
"""Numbers of a link's pose in y."""

SLOWEST = 1e-3
"""Rates [rad/s or m/s] are taken as at least this large: at a tolerance of 1e-12, what is less of their error is round-off."""


class Trees(NamedTuple):
    """The trees of a world under their loads, and what a step goes back to.

    Terms: ends: as `ends_with_laws`; base (n, 7), carried (joints, 6): the bases' poses and the joints' reactions at its start.
    """

    tables: Tables
    bodies: Bodies
    joints: Joints
    setting: Floats
    gyroscopic: int
    ends: bool
    base: Floats
    carried: Floats


@kernel
def push_columns(tables: Tables, joints: Joints) -> None:
    """Write what springs and drives push now, and rotors, for a stage."""
    kind, column = tables.kind, tables.column
    for i in range(kind.shape[0]):
        j, k = kind[i, tree.JOINT], kind[i, tree.FIRST]
        if j >= 0 and joints.kind[j, at.HAS] != 0:
            column[k, tree.ADDED] = joints.joint[j, at.ARMATURE]
            column[k, tree.PUSH] = explicit_force(joints, j, tables.coordinate[i, 0], column[k, tree.RATE])


@kernel
def ends_with_laws(tables: Tables, joints: Joints) -> bool:
    """Whether a step ends with a change of rates: there are limits, or springs or drives that are taken implicitly."""
    for i in range(tables.kind.shape[0]):
        j = tables.kind[i, tree.JOINT]
        if j >= 0 and joints.kind[j, at.HAS] & (joints.kind[j, at.IMPLICIT] | at.HAS_LIMITS) != 0:
            return True
    return False


@kernel
def mark_stiff_columns(tables: Tables, bodies: Bodies, joints: Joints, dt: float) -> None:
    """Write IMPLICIT for all joints from the present state, by the criterion of `constrain.stiffness`."""
    kind, column, joint = tables.kind, tables.column, joints.joint
    move_links(tables, bodies.state)
    for i in range(kind.shape[0]):
        j, k = kind[i, tree.JOINT], kind[i, tree.FIRST]
        if j < 0 or joints.kind[j, at.HAS] == 0:
            continue
        joints.kind[j, at.IMPLICIT] = 0
        free_columns(tables, joints)
        column[k, tree.PUSH] = 1.0
        weigh_links(tables)
        accelerations(tables, False)
        mobility = column[k, tree.CHANGE]
        for law, has in ((at.SPRING, at.HAS_SPRING), (at.DRIVE, at.HAS_DRIVE)):
            stiff = dt * dt * joint[j, law] * mobility > STIFF or dt * joint[j, law + 1] * mobility > DAMPED
            if joints.kind[j, at.HAS] & has and stiff:
                joints.kind[j, at.IMPLICIT] |= has
        column[k, tree.PUSH] = 0.0


@kernel
def gather(tables: Tables, y: Floats, row: int) -> None:
    """Write the present coordinates and rates into a row of y."""
    n = tables.kind.shape[0]
    for i in range(n):
        for c in range(POSE):
            y[row, POSE * i + c] = tables.coordinate[i, c]
    for k in range(tables.column.shape[0]):
        y[row, POSE * n + k] = tables.column[k, tree.RATE]


@kernel
def scatter(tables: Tables, y: Floats, row: int) -> None:
    """Take coordinates and rates from a row of y, orientations as unit ones."""
    n = tables.kind.shape[0]
    for i in range(n):
        for c in range(POSE):
            tables.coordinate[i, c] = y[row, POSE * i + c]
        if tables.kind[i, tree.TYPE] == at.BALL or tables.kind[i, tree.TYPE] == tree.FREE:
            store4(tables.coordinate, i, 0, quat_unit(load4(tables.coordinate, i, 0)))
    for k in range(tables.column.shape[0]):
        tables.column[k, tree.RATE] = y[row, POSE * n + k]


@kernel
def trees_of(tables: Tables, bodies: Bodies, joints: Joints, setting: Floats, gyroscopic: int) -> Trees:
    """The trees of a world."""
    base, carried = np.zeros((tables.other.shape[0], POSE)), np.zeros((joints.joint.shape[0], 6))
    return Trees(tables, bodies, joints, setting, gyroscopic, ends_with_laws(tables, joints), base, carried)


@kernel
def room_for_trials(tables: Tables, stages: int) -> Trial:
    """Room for a step of all trees in so many stages."""
    return explicit.room_for_trials(POSE * tables.kind.shape[0] + tables.column.shape[0], stages)


@kernel
def begin(trees: Trees, trial: Trial) -> None:
    """Note coordinates, rates, poses of bases and reactions as they are."""
    tables, bodies, joints = trees.tables, trees.bodies, trees.joints
    gather(tables, trial.y, 0)
    for n in range(tables.other.shape[0]):
        for c in range(POSE):
            trees.base[n, c] = bodies.state[tables.other[n, 0], c]
    for j in range(trees.carried.shape[0]):
        for c in range(6):
            trees.carried[j, c] = joints.joint[j, at.REACTION + c]


@kernel
def bases_at(trees: Trees, h: float) -> None:
    """Put the bases where they are h seconds after the step's start."""
    tables, bodies = trees.tables, trees.bodies
    for n in range(tables.other.shape[0]):
        for c in range(POSE):
            bodies.state[tables.other[n, 0], c] = trees.base[n, c]
    carry_bases(tables, bodies, h)


@kernel
def find_accelerations(trees: Trees) -> None:
    """Write the accelerations at the present coordinates and rates."""
    move_links(trees.tables, trees.bodies.state)
    push_columns(trees.tables, trees.joints)
    load_links(trees.tables, trees.bodies, trees.setting, trees.gyroscopic)
    accelerations(trees.tables, True)


@kernel
def write_slope(tables: Tables, k: Floats, stage: int) -> None:
    """Write the rates of coordinates and rates into row `stage` of k."""
    coordinate, column, kind = tables.coordinate, tables.column, tables.kind
    n = kind.shape[0]
    for i in range(n):
        first, offset = kind[i, tree.FIRST], POSE * i
        if kind[i, tree.TYPE] == at.REVOLUTE or kind[i, tree.TYPE] == at.PRISMATIC:
            k[stage, offset] = column[first, tree.RATE]
        elif kind[i, tree.TYPE] == at.BALL or kind[i, tree.TYPE] == tree.FREE:
            store4(k, stage, offset, quat_rate(load4(coordinate, i, 0), rates_of(tables, first)))
        if kind[i, tree.TYPE] == tree.FREE:
            for c in range(3):
                k[stage, offset + tree.POSITION + c] = column[first + 3 + c, tree.RATE]
    for c in range(column.shape[0]):
        k[stage, POSE * n + c] = column[c, tree.CHANGE]


@kernel
def go_through_stages(h: float, method: Floats, trees: Trees, trial: Trial) -> None:
    """Go on by h from y, where accelerations are known, to its end, counting what joints carry.

    Args: method: as `RK4`. Where there are as many slopes as rows, the end has one as well.
    """
    tables, k, a, last = trees.tables, trial.k, method, method.shape[0] - 1
    write_slope(tables, k, 0)
    add_reactions(tables, trees.joints, h * a[last, 0])
    for i in range(1, last + 1):
        explicit.go_to_stage(trial, method, i, h)
        scatter(tables, trial.y, 1)
        bases_at(trees, a[i, a.shape[1] - 1] * h)
        if i < k.shape[0]:
            find_accelerations(trees)
            if i < last:
                add_reactions(tables, trees.joints, h * a[last, i])
            write_slope(tables, k, i)


@kernel
def act_at_end(h: float, trees: Trees) -> bool:
    """Let limits, and what is too stiff for stages, change the rates after a step h. Returns: whether laws had an answer."""
    tables, bodies, joints = trees.tables, trees.bodies, trees.joints
    if not trees.ends:
        return True
    move_links(tables, bodies.state)
    if not solve_laws(tables, bodies, joints, trees.setting, h, trees.gyroscopic, STIFF_ALONE):
        return False
    add_reactions(tables, joints, h)
    change_rates(tables, h)
    return True


@kernel
def runge_kutta(h: float, trees: Trees, trial: Trial) -> bool:
    """Advance all trees and bases by h, counting what joints carry. Returns: whether the laws had an answer."""
    begin(trees, trial)
    find_accelerations(trees)
    go_through_stages(h, RK4, trees, trial)
    return act_at_end(h, trees)


@kernel
def attempt(h: float, trees: Trees, trial: Trial) -> float:
    """A trial step. Returns: the larger error of rates, relative to all of them, and of any orientation or hinge [rad]."""
    kind, k, n = trees.tables.kind, trial.k, trees.tables.kind.shape[0]
    go_through_stages(h, DORMAND_PRINCE, trees, trial)
    error, fastest = explicit.error_of(trial, h, POSE * n, k.shape[1])
    largest = error / max(fastest, SLOWEST)
    for i in range(n):
        if kind[i, tree.TYPE] != at.PRISMATIC:
            turn, _ = explicit.error_of(trial, h, POSE * i, POSE * i + 4)
            # A sum is not finite if any part is not, while a maximum may pass it over.
            largest = turn if not turn <= largest else largest
    return largest


@kernel
def finish(h: float, taken: bool, trees: Trees, trial: Trial) -> bool:
    """End a step that is taken, or go back to its start. Returns: whether the laws had an answer."""
    if taken:
        if not act_at_end(h, trees):
            return False
        if trees.ends:
            find_accelerations(trees)
        begin(trees, trial)
        return True
    scatter(trees.tables, trial.y, 0)
    bases_at(trees, 0.0)
    for j in range(trees.carried.shape[0]):
        for c in range(6):
            trees.joints.joint[j, at.REACTION + c] = trees.carried[j, c]
    find_accelerations(trees)
    return True


@kernel
def dormand_prince(end: float, trees: Trees, trial: Trial) -> bool:
    """Advance all trees and bases by `end` seconds in as many steps as the tolerance asks for, counting what joints carry.

    Returns: whether they sufficed, and the laws had an answer.
    """
    passage, tolerance = trees.tables.passage, trees.setting[0, at.STEP_TOLERANCE]
    find_accelerations(trees)
    begin(trees, trial)
    stride = explicit.adapt(passage[0, tree.KEPT_STRIDE], end, tolerance, attempt, finish, trees, trial)
    if stride < 0.0:
        return False
    passage[0, tree.KEPT_STRIDE] = stride
    return True
