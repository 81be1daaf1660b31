"""Joints that close loops: rows J v + gap / h = 0 on the links that they hold together, all solved at once.

    J G J^T lambda = -(J v + gap / h)       G as in `responses`: what the trees leave of the links' mobility

The trees hold most of what these rows ask for themselves, in a plane mechanism all that leads out of the plane; rows that no
motion of the trees can change, or that follow from others, are left out of the factor. The gap is that of the sub-step's start,
which the positions at its end close to the order of a turn squared; the relaxing sweeps take it out of the velocities.

Source: Featherstone, Rigid Body Dynamics Algorithms, 2008, sections 8.2 (loop constraints) and 8.5 to 8.7 (solution by the
inverse inertia of the loops).
"""

import math
from typing import Final

from plumbline.engine.articulated.responses import NOWHERE, Touched, change_of, give
from plumbline.engine.articulated.tables import Trees
from plumbline.engine.compile.jit import kernel
from plumbline.engine.constrain.joint_rows import equality_rows
from plumbline.engine.constrain.reactions import add_reaction
from plumbline.engine.maths.rows import Floats, Vec, load3
from plumbline.engine.maths.vec import dot, scale
from plumbline.engine.memory import arena as at
from plumbline.engine.memory.tables import Joints, Rows

DEPENDENT: Final = 1e-10
"""Pivots below this share of what the two bodies alone would give way: the row follows from the tree's joints or other rows."""


@kernel
def count_loop_rows(trees: Trees) -> int:
    """How many rows the joints have that close loops."""
    n = 0
    for c in range(trees.closing.shape[0]):
        kind = trees.joints.kind[trees.closing[c, 0], at.JOINT_TYPE]
        n += 6 if kind == at.FIXED else 3 if kind == at.BALL else 1 if kind == at.DISTANCE else 5
    return n


@kernel
def touch_loops(trees: Trees) -> None:
    """Mark the dynamic bodies that loops close at as touched."""
    for c in range(trees.closing.shape[0]):
        for side in range(1, 3):
            b = trees.joints.kind[trees.closing[c, 0], side]
            if trees.bodies.kind[b, at.MOTION] == at.DYNAMIC:
                trees.bodies.kind[b, at.TOUCHED] = 1


@kernel
def write_loops(trees: Trees, rows: Rows | None, h: float) -> None:
    """Write the rows of all loops at the poses of their bodies, for a sub-step of h [s] that closes their gaps.

    Args: rows: None, here and below, where no joint closes a loop; then nothing of this is compiled.
    """
    if rows is None:
        return
    r, joints = 0, trees.joints
    for c in range(trees.closing.shape[0]):
        rest = Rows(rows.row[r:], rows.body[r:], rows.reach, rows.matrix, rows.factor, rows.vector)
        n = equality_rows(trees.bodies.state, Joints(joints.joint, joints.kind, trees.closing[c : c + 1]), rest)
        for k in range(r, r + n):
            rows.row[k, at.BIAS] = rows.row[k, at.GAP] / h
        r += n


@kernel
def row_change(touched: Touched, rows: Rows, r: int, i: int, s: int) -> tuple[Vec, Vec]:
    """What a unit impulse of row s changes of the velocities of side i of row r."""
    place = touched.place[rows.body[r, i]]
    a, b = touched.place[rows.body[s, 0]], touched.place[rows.body[s, 1]]
    v, w = change_of(touched, place, a, load3(rows.row, s, 0), load3(rows.row, s, 3))
    x, y = change_of(touched, place, b, load3(rows.row, s, 6), load3(rows.row, s, 9))
    return (v[0] + x[0], v[1] + x[1], v[2] + x[2]), (w[0] + y[0], w[1] + y[1], w[2] + y[2])


@kernel
def own_mobility(rows: Rows, r: int, body: Floats) -> float:
    """What the two bodies of row r alone would give way to its impulse, of inertias that are the mean about all axes."""
    total = 0.0
    for side in range(2):
        b, f, t = rows.body[r, side], load3(rows.row, r, 6 * side), load3(rows.row, r, 6 * side + 3)
        turning = (body[b, at.INV_INERTIA] + body[b, at.INV_INERTIA + 1] + body[b, at.INV_INERTIA + 2]) / 3.0
        total += body[b, at.INV_MASS] * dot(f, f) + turning * dot(t, t)
    return total


@kernel
def write_loop_matrix(trees: Trees, touched: Touched, rows: Rows | None, n: int) -> None:
    """Write J G J^T of the first n rows and its factor, by Cholesky; rows that depend on others are held (PIVOT 1)."""
    if rows is None:
        return
    row, matrix, low, pivot = rows.row, rows.matrix, rows.factor, rows.vector[at.PIVOT]
    for r in range(n):
        for s in range(r + 1):
            total = 0.0
            for i in range(2):
                v, w = row_change(touched, rows, r, i, s)
                total += dot(load3(row, r, 6 * i), v) + dot(load3(row, r, 6 * i + 3), w)
            matrix[r, s] = total
    for i in range(n):
        for j in range(i):
            total = matrix[i, j]
            for k in range(j):
                total -= low[i, k] * low[j, k]
            low[i, j] = 0.0 if pivot[j] == 1.0 else total / low[j, j]
        left = matrix[i, i]
        for k in range(i):
            left -= low[i, k] * low[i, k]
        pivot[i] = 1.0 if left <= DEPENDENT * own_mobility(rows, i, trees.bodies.body) else 0.0
        low[i, i] = 1.0 if pivot[i] == 1.0 else math.sqrt(left)
        if pivot[i] == 1.0:
            for k in range(i):
                low[i, k] = 0.0


@kernel
def hold_loops(trees: Trees, touched: Touched, rows: Rows | None, n: int, share: float, reactions: bool) -> None:
    """Give the impulses that all rows ask for at the present velocities. Args: share: of the gap to be closed, 0 or 1."""
    if rows is None:
        return
    state, row, low, vector = trees.bodies.state, rows.row, rows.factor, rows.vector
    for r in range(n):
        total = -share * row[r, at.BIAS]
        for side in range(2):
            b = rows.body[r, side]
            total -= dot(load3(row, r, 6 * side), load3(state, b, at.V)) + dot(
                load3(row, r, 6 * side + 3), load3(state, b, at.W)
            )
        for k in range(r):
            total -= low[r, k] * vector[at.IMPULSE, k]
        vector[at.IMPULSE, r] = 0.0 if vector[at.PIVOT, r] == 1.0 else total / low[r, r]
    for r in range(n - 1, -1, -1):
        total = vector[at.IMPULSE, r]
        for k in range(r + 1, n):
            total -= low[k, r] * vector[at.IMPULSE, k]
        vector[at.IMPULSE, r] = 0.0 if vector[at.PIVOT, r] == 1.0 else total / low[r, r]
    for r in range(n):
        impulse = vector[at.IMPULSE, r]
        if impulse == 0.0:
            continue
        for side in range(2):
            place = touched.place[rows.body[r, side]]
            if place != NOWHERE:
                f, t = load3(row, r, 6 * side), load3(row, r, 6 * side + 3)
                give(touched, state, place, scale(impulse, f), scale(impulse, t))
        if reactions:
            add_reaction(trees.joints, rows, r, impulse)
