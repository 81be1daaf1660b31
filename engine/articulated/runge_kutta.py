"""One step of the classical Runge-Kutta method of order four in joint coordinates.

    (q, q')' = (q', q''(q, q')), in four stages; then rates that a limit, or a spring too stiff for stages, changes at the end

Nothing has to be projected: the coordinates leave the bodies no way off their joints.

Source: Hairer, Norsett, Wanner, Solving Ordinary Differential Equations I, section II.1, table 1.2 (1901, Kutta).
"""

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

SUM = 7
"""The column of a link's stages from which the weighted sum of slopes stands, behind the coordinates at the start."""


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
def write_slopes(tables: Tables, weight: float, ahead: float, last: bool) -> None:
    """Add the slopes to their weighted sum, and go on from the start by them for `ahead` seconds, or by the sum at the last."""
    stage, coordinate, kind, column = tables.stage, tables.coordinate, tables.kind, tables.column
    for i in range(kind.shape[0]):
        k, slope = kind[i, tree.FIRST], (0.0, 0.0, 0.0, 0.0)
        if kind[i, tree.TYPE] == at.REVOLUTE or kind[i, tree.TYPE] == at.PRISMATIC:
            slope = (column[k, tree.RATE], 0.0, 0.0, 0.0)
        elif kind[i, tree.TYPE] == at.BALL or kind[i, tree.TYPE] == tree.FREE:
            slope = quat_rate(load4(coordinate, i, 0), rates_of(tables, k))
        for c in range(4):
            stage[i, SUM + c] += weight * slope[c]
            coordinate[i, c] = stage[i, c] + (ahead / 6.0 * stage[i, SUM + c] if last else ahead * slope[c])
        if kind[i, tree.TYPE] == at.BALL or kind[i, tree.TYPE] == tree.FREE:
            store4(coordinate, i, 0, quat_unit(load4(coordinate, i, 0)))
        if kind[i, tree.TYPE] == tree.FREE:
            for c in range(3):
                rate = column[k + 3 + c, tree.RATE]
                stage[i, SUM + tree.POSITION + c] += weight * rate
                way = ahead / 6.0 * stage[i, SUM + tree.POSITION + c] if last else ahead * rate
                coordinate[i, tree.POSITION + c] = stage[i, tree.POSITION + c] + way
    for k in range(column.shape[0]):
        tables.stage_rate[k, 1] += weight * column[k, tree.CHANGE]
        change = ahead / 6.0 * tables.stage_rate[k, 1] if last else ahead * column[k, tree.CHANGE]
        column[k, tree.RATE] = tables.stage_rate[k, 0] + change


@kernel
def runge_kutta(
    tables: Tables, bodies: Bodies, joints: Joints, setting: Floats, dt: float, gyroscopic: int, ends: bool
) -> bool:
    """Advance all trees and bases by dt, counting what joints carry.

    Args: ends: as `ends_with_laws`. Returns: whether the laws had an answer.
    """
    stage, stage_rate = tables.stage, tables.stage_rate
    for i in range(stage.shape[0]):
        for c in range(7):
            stage[i, c], stage[i, SUM + c] = tables.coordinate[i, c], 0.0
    for k in range(stage_rate.shape[0]):
        stage_rate[k, 0], stage_rate[k, 1] = tables.column[k, tree.RATE], 0.0
    for n in range(4):
        weight = 1.0 if n == 0 or n == 3 else 2.0
        if n == 1 or n == 3:
            carry_bases(tables, bodies, 0.5 * dt)
        move_links(tables, bodies.state)
        push_columns(tables, joints)
        load_links(tables, bodies, setting, gyroscopic)
        accelerations(tables, True)
        add_reactions(tables, joints, weight * dt / 6.0)
        write_slopes(tables, weight, 0.5 * dt if n < 2 else dt, n == 3)
    if ends:
        move_links(tables, bodies.state)
        if not solve_laws(tables, bodies, joints, setting, dt, gyroscopic, STIFF_ALONE):
            return False
        add_reactions(tables, joints, dt)
        change_rates(tables, dt)
    return True
