"""One step of the classical Runge-Kutta method of order four in joint coordinates.

    y' = (q, q')' = (q', q''(q, q')),  k_i = f(y + h sum_j a_ij k_j),  y <- y + h sum_i b_i k_i

Then rates that a limit, or a spring too stiff for stages, changes at the end.

Nothing has to be projected: the coordinates leave the bodies no way off their joints.

Source: Hairer, Norsett, Wanner, Solving Ordinary Differential Equations I, section II.1, table 1.2 (1901, Kutta).
"""

from typing import Final, NamedTuple

import numpy as np

from plumbline.engine.articulated import tables as tree
from plumbline.engine.articulated.advance import add_reactions, change_rates
from plumbline.engine.articulated.articulated_body import accelerations
from plumbline.engine.articulated.bases import carry_bases, free_columns
from plumbline.engine.articulated.bounded import solve_laws
from plumbline.engine.articulated.forces import load_links, weigh_links
from plumbline.engine.articulated.laws import STIFF_ALONE
from plumbline.engine.articulated.motion import move_links, rates_of
from plumbline.engine.articulated.tables import Tables
from plumbline.engine.compile.jit import kernel
from plumbline.engine.constrain.coordinate import explicit_force
from plumbline.engine.constrain.stiffness import DAMPED, STIFF
from plumbline.engine.integrate.runge_kutta import quat_rate
from plumbline.engine.maths.rows import Floats, load4, store4
from plumbline.engine.maths.vec import quat_unit
from plumbline.engine.memory import arena as at
from plumbline.engine.memory.tables import Bodies, Joints

POSE: Final = 7
"""Numbers of a link's pose in y."""

RK4_STAGES: Final = 4
RK4: Final = np.array(
    [[0, 0, 0, 0, 0], [1 / 2, 0, 0, 0, 1 / 2], [0, 1 / 2, 0, 0, 1 / 2], [0, 0, 1, 0, 1], [1 / 6, 1 / 3, 1 / 3, 1 / 6, 1]]
)
"""Of each stage a_ij, and where in a step it is; the weights of the end last."""


class Trial(NamedTuple):
    """What a trial step works on: y (2 rows: at its start, and where it comes to), the slopes k (STAGES rows), and what the
    bases' poses and the joints' reactions were at its start, a row each."""

    y: Floats
    k: Floats
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
def room_for_trials(tables: Tables, joints: Joints, stages: int) -> Trial:
    """Room for a step of all trees in so many stages."""
    length = POSE * tables.kind.shape[0] + tables.column.shape[0]
    base, carried = np.zeros((tables.other.shape[0], POSE)), np.zeros((joints.joint.shape[0], 6))
    return Trial(np.zeros((2, length)), np.zeros((stages, length)), base, carried)


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
def keep_beside(tables: Tables, bodies: Bodies, joints: Joints, trial: Trial) -> None:
    """Note poses of bases, and reactions, as they are."""
    for n in range(tables.other.shape[0]):
        for c in range(POSE):
            trial.base[n, c] = bodies.state[tables.other[n, 0], c]
    for j in range(trial.carried.shape[0]):
        for c in range(6):
            trial.carried[j, c] = joints.joint[j, at.REACTION + c]


@kernel
def bases_at(tables: Tables, bodies: Bodies, trial: Trial, h: float) -> None:
    """Put the bases where they are h seconds after the trial's start."""
    for n in range(tables.other.shape[0]):
        for c in range(POSE):
            bodies.state[tables.other[n, 0], c] = trial.base[n, c]
    carry_bases(tables, bodies, h)


@kernel
def find_accelerations(tables: Tables, bodies: Bodies, joints: Joints, setting: Floats, gyroscopic: int) -> None:
    """Write the accelerations at the present coordinates and rates."""
    move_links(tables, bodies.state)
    push_columns(tables, joints)
    load_links(tables, bodies, setting, gyroscopic)
    accelerations(tables, True)


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
def go_through_stages(
    tables: Tables,
    bodies: Bodies,
    joints: Joints,
    setting: Floats,
    h: float,
    gyroscopic: int,
    method: Floats,
    trial: Trial,
) -> None:
    """Go on by h from y, where accelerations are known, to its end, counting what joints carry.

    Args: method: as `RK4`. Where there are as many slopes as rows, the end has one as well.
    """
    y, k, a, last = trial.y, trial.k, method, method.shape[0] - 1
    write_slope(tables, k, 0)
    add_reactions(tables, joints, h * a[last, 0])
    for i in range(1, last + 1):
        for j in range(k.shape[1]):
            y[1, j] = y[0, j]
        for s in range(i):
            if a[i, s] != 0.0:
                for j in range(k.shape[1]):
                    y[1, j] += h * a[i, s] * k[s, j]
        scatter(tables, y, 1)
        bases_at(tables, bodies, trial, a[i, a.shape[1] - 1] * h)
        if i < k.shape[0]:
            find_accelerations(tables, bodies, joints, setting, gyroscopic)
            if i < last:
                add_reactions(tables, joints, h * a[last, i])
            write_slope(tables, k, i)


@kernel
def act_at_end(tables: Tables, bodies: Bodies, joints: Joints, setting: Floats, h: float, gyroscopic: int) -> bool:
    """Let limits, and what is too stiff for stages, change the rates after a step h. Returns: whether laws had an answer."""
    move_links(tables, bodies.state)
    if not solve_laws(tables, bodies, joints, setting, h, gyroscopic, STIFF_ALONE):
        return False
    add_reactions(tables, joints, h)
    change_rates(tables, h)
    return True


@kernel
def runge_kutta(
    tables: Tables, bodies: Bodies, joints: Joints, setting: Floats, dt: float, gyroscopic: int, ends: bool, trial: Trial
) -> bool:
    """Advance all trees and bases by dt, counting what joints carry.

    Args: ends: as `ends_with_laws`. Returns: whether the laws had an answer.
    """
    gather(tables, trial.y, 0)
    keep_beside(tables, bodies, joints, trial)
    find_accelerations(tables, bodies, joints, setting, gyroscopic)
    go_through_stages(tables, bodies, joints, setting, dt, gyroscopic, RK4, trial)
    return act_at_end(tables, bodies, joints, setting, dt, gyroscopic) if ends else True
