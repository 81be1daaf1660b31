"""Solve the rows' impulses directly: J M^-1 J^T lambda = right-hand side, by a Cholesky factorisation.

Dependent rows, as in closed loops, are left out. Where a pivot is small but the row does not depend on others, floats do not
carry the system: it is then solved in double-double arithmetic.

Source: Golub, Van Loan, Matrix Computations, section 4.2; George, Liu, Computer Solution of Large Sparse Positive Definite
Systems (1981), chapter 4 (envelope).
"""

import math
from typing import Final

import numpy as np

from plumbline.engine.compile.jit import kernel
from plumbline.engine.constrain.careful import careful_apply, careful_solve
from plumbline.engine.constrain.dependence import LOW_PIVOT, SUSPECT, lies_in_span
from plumbline.engine.maths.rows import Floats, load3, load6, store3
from plumbline.engine.maths.vec import axpy, dot, scale, sym_vec
from plumbline.engine.memory import arena as at
from plumbline.engine.memory.tables import Bodies, Rows

NOISE = 1e-11
"""Pivots of soft rows below this share of their diagonal are round-off."""

NOBODY: Final = -1
"""In place of a body that does not move."""


@kernel
def mover(rows: Rows, r: int, side: int, body: Floats) -> int:
    """The body on a side of row r, or NOBODY: what does not move couples no rows."""
    b = int(rows.body[r, side])
    return b if body[b, at.INV_MASS] > 0.0 else NOBODY


@kernel
def assemble(rows: Rows, n: int, bodies: Bodies) -> None:
    """Write M^-1 J^T into `reach` and J M^-1 J^T + diag(softness) into `matrix`, for the first n rows."""
    row, reach, matrix = rows.row, rows.reach, rows.matrix
    for r in range(n):
        for side in range(2):
            b = rows.body[r, side]
            store3(reach, r, 6 * side, scale(bodies.body[b, at.INV_MASS], load3(row, r, 6 * side)))
            store3(reach, r, 6 * side + 3, sym_vec(load6(bodies.turned, b, 0), load3(row, r, 6 * side + 3)))
        movers = mover(rows, r, 0, bodies.body), mover(rows, r, 1, bodies.body)
        for s in range(r + 1):
            total = 0.0
            for i in range(2):
                for k in range(2):
                    if movers[i] == rows.body[s, k]:
                        for c in range(6):
                            total += row[r, 6 * i + c] * reach[s, 6 * k + c]
            matrix[r, s] = total
            matrix[s, r] = total
        matrix[r, r] += row[r, at.SOFTNESS]


@kernel
def factor(rows: Rows, n: int, body: Floats) -> None:
    """Write the Cholesky factor of the first n rows into `factor`, but for those held (PIVOT 1); dependent rows become held.

    Where floats do not carry the system, CAREFUL is set and the factor left unfinished.

    A row of the factor begins where that of the matrix does, so that only this envelope is visited: joints along a chain cost
    in proportion to their number.
    """
    row, matrix, low, vector = rows.row, rows.matrix, rows.factor, rows.vector
    for i in range(min(n, 1)):
        vector[at.CAREFUL, i] = 0.0
    for i in range(n):
        first = 0
        while first < i and matrix[i, first] == 0.0:
            first += 1
        vector[at.ENVELOPE, i] = first
        for j in range(first):
            low[i, j] = 0.0
        if vector[at.PIVOT, i] == 1.0:
            continue
        diagonal = matrix[i, i]
        for j in range(first, i):
            if vector[at.PIVOT, j] == 1.0:
                low[i, j] = 0.0
                continue
            total = matrix[i, j]
            for k in range(max(first, int(vector[at.ENVELOPE, j])), j):
                total -= low[i, k] * low[j, k]
            low[i, j] = total / low[j, j]
            diagonal -= low[i, j] * low[i, j]
        if diagonal > LOW_PIVOT * matrix[i, i] or (row[i, at.SOFTNESS] > 0.0 and diagonal > NOISE * matrix[i, i]):
            low[i, i] = math.sqrt(diagonal)
        elif row[i, at.SOFTNESS] > 0.0 or lies_in_span(rows, i, body, diagonal / matrix[i, i]):
            vector[at.PIVOT, i] = 1.0
        elif diagonal > SUSPECT * matrix[i, i]:
            low[i, i] = math.sqrt(diagonal)
        else:
            vector[at.CAREFUL, 0] = 1.0
            return
    for i in range(n):
        if vector[at.PIVOT, i] == 1.0:
            for j in range(int(vector[at.ENVELOPE, i]), i):
                low[i, j] = 0.0


@kernel
def is_careful(rows: Rows, n: int) -> bool:
    """Whether the last factorisation found that floats do not carry these n rows."""
    return n > 0 and bool(rows.vector[at.CAREFUL, 0] == 1.0)


@kernel
def solve(rows: Rows, n: int, bodies: Bodies, right: int, out: int) -> None:
    """Solve with the factor: vector[out] = A^-1 vector[right], zero for held rows."""
    low, vector = rows.factor, rows.vector
    if is_careful(rows, n):
        for i in range(n):
            if vector[at.PIVOT, i] == 1.0:
                vector[out, i] = 0.0
        careful_solve(rows, n, bodies, right, out, np.zeros((bodies.body.shape[0], 6)))
        return
    for i in range(n):
        if vector[at.PIVOT, i] == 1.0:
            vector[out, i] = 0.0
            continue
        total = vector[right, i]
        for k in range(int(vector[at.ENVELOPE, i]), i):
            total -= low[i, k] * vector[out, k]
        vector[out, i] = total / low[i, i]
    for i in range(n - 1, -1, -1):
        if vector[at.PIVOT, i] == 1.0:
            continue
        impulse = vector[out, i] / low[i, i]
        vector[out, i] = impulse
        for k in range(int(vector[at.ENVELOPE, i]), i):
            vector[out, k] -= low[i, k] * impulse


@kernel
def rate(state: Floats, rows: Rows, r: int) -> float:
    """J v of row r."""
    row, a, b = rows.row, rows.body[r, 0], rows.body[r, 1]
    of_a = dot(load3(row, r, 0), load3(state, a, at.V)) + dot(load3(row, r, 3), load3(state, a, at.W))
    return of_a + dot(load3(row, r, 6), load3(state, b, at.V)) + dot(load3(row, r, 9), load3(state, b, at.W))


@kernel
def apply(table: Floats, rows: Rows, r: int, impulse: float) -> None:
    """v += M^-1 J^T impulse in the columns V and W of the table."""
    for side in range(2):
        b = rows.body[r, side]
        store3(table, b, at.V, axpy(impulse, load3(rows.reach, r, 6 * side), load3(table, b, at.V)))
        store3(table, b, at.W, axpy(impulse, load3(rows.reach, r, 6 * side + 3), load3(table, b, at.W)))


@kernel
def apply_all(table: Floats, rows: Rows, n: int, bodies: Bodies, which: int, sign: float) -> None:
    """Add sign M^-1 J^T vector[which] to the columns V and W of the table."""
    if is_careful(rows, n):
        careful_apply(table, rows, n, bodies, which, sign, np.zeros((bodies.body.shape[0], 6)))
        return
    for r in range(n):
        apply(table, rows, r, sign * rows.vector[which, r])
