"""Solve the rows' impulses directly: J M^-1 J^T lambda = right-hand side, by a Cholesky factorisation with bounds.

Dependent rows, as in closed loops, are left out. Where a pivot is small but the row does not depend on others, floats do not
carry the system: it is then solved in double-double arithmetic. Bounds are met by moving rows between free and held until
every sign is right.

Source: Golub, Van Loan, Matrix Computations, section 4.2; George, Liu, Computer Solution of Large Sparse Positive Definite
Systems (1981), chapter 4 (envelope); Cottle, Pang, Stone, The Linear Complementarity Problem, section 4.2
(principal pivoting).
"""

import math

import numpy as np

from engine.compile.jit import kernel
from engine.constrain.careful import careful_apply, careful_solve
from engine.constrain.dependence import SUSPECT, lies_in_span
from engine.maths.vec import Floats, Ints, axpy, dot, load3, load6, scale, store3, sym_vec
from engine.memory.arena import (
    BIAS,
    BOUND,
    CAREFUL,
    ENVELOPE,
    HIGH,
    HIGHEST,
    IMPULSE,
    INV_MASS,
    LOW,
    LOWEST,
    PIVOT,
    RIGHT,
    SOFTNESS,
    WORK,
    V,
    W,
)  # fmt: skip

__all__ = ["apply", "apply_all", "assemble", "factor", "is_careful", "rate", "solve", "solve_bounded"]

NOISE = 1e-11
"""Pivots of soft rows below this share of their diagonal are round-off."""


@kernel
def assemble(
    row: Floats, row_body: Ints, first: int, count: int, body: Floats, turned: Floats, reach: Floats, matrix: Floats
) -> None:
    """Write M^-1 J^T into `reach` and J M^-1 J^T + diag(softness) into `matrix`, for rows from `first` on."""
    for r in range(first, count):
        for side in range(2):
            b = row_body[r, side]
            store3(reach, r, 6 * side, scale(body[b, INV_MASS], load3(row, r, 6 * side)))
            store3(reach, r, 6 * side + 3, sym_vec(load6(turned, b, 0), load3(row, r, 6 * side + 3)))
        for s in range(r + 1):
            total = 0.0
            for i in range(2):
                for k in range(2):
                    if row_body[r, i] == row_body[s, k]:
                        for c in range(6):
                            total += row[r, 6 * i + c] * reach[s, 6 * k + c]
            matrix[r, s] = total
            matrix[s, r] = total
        matrix[r, r] += row[r, SOFTNESS]


@kernel
def factor(row: Floats, row_body: Ints, body: Floats, matrix: Floats, low: Floats, n: int, vector: Floats) -> None:
    """Write the Cholesky factor of the rows that are not held (PIVOT 1) into `low`; dependent rows become held.

    Where floats do not carry the system, CAREFUL is set and the factor left unfinished.

    A row of the factor begins where that of the matrix does, so that only this envelope is visited: joints along a chain cost
    in proportion to their number.
    """
    for i in range(min(n, 1)):
        vector[CAREFUL, i] = 0.0
    for i in range(n):
        first = 0
        while first < i and matrix[i, first] == 0.0:
            first += 1
        vector[ENVELOPE, i] = first
        for j in range(first):
            low[i, j] = 0.0
        if vector[PIVOT, i] == 1.0:
            continue
        diagonal = matrix[i, i]
        for j in range(first, i):
            if vector[PIVOT, j] == 1.0:
                low[i, j] = 0.0
                continue
            total = matrix[i, j]
            for k in range(max(first, int(vector[ENVELOPE, j])), j):
                total -= low[i, k] * low[j, k]
            low[i, j] = total / low[j, j]
            diagonal -= low[i, j] * low[i, j]
        if diagonal > SUSPECT * matrix[i, i] or (row[i, SOFTNESS] > 0.0 and diagonal > NOISE * matrix[i, i]):
            low[i, i] = math.sqrt(diagonal)
        elif row[i, SOFTNESS] > 0.0 or lies_in_span(row, row_body, i, body, low, vector):
            vector[PIVOT, i] = 1.0
        else:
            vector[CAREFUL, 0] = 1.0
            return
    for i in range(n):
        if vector[PIVOT, i] == 1.0:
            for j in range(int(vector[ENVELOPE, i]), i):
                low[i, j] = 0.0


@kernel
def is_careful(n: int, vector: Floats) -> bool:
    """Whether the last factorisation found that floats do not carry these n rows."""
    return n > 0 and bool(vector[CAREFUL, 0] == 1.0)


@kernel
def solve(
    row: Floats, row_body: Ints, body: Floats, turned: Floats, low: Floats, n: int, vector: Floats, right: int, out: int
) -> None:  # fmt: skip
    """Solve with the factor: vector[out] = A^-1 vector[right], zero for held rows."""
    if is_careful(n, vector):
        for i in range(n):
            if vector[PIVOT, i] == 1.0:
                vector[out, i] = 0.0
        careful_solve(row, row_body, n, body, turned, low, vector, right, out, np.zeros((body.shape[0], 6)))
        return
    for i in range(n):
        if vector[PIVOT, i] == 1.0:
            vector[out, i] = 0.0
            continue
        total = vector[right, i]
        for k in range(int(vector[ENVELOPE, i]), i):
            total -= low[i, k] * vector[out, k]
        vector[out, i] = total / low[i, i]
    for i in range(n - 1, -1, -1):
        if vector[PIVOT, i] == 1.0:
            continue
        found = vector[out, i] / low[i, i]
        vector[out, i] = found
        for k in range(int(vector[ENVELOPE, i]), i):
            vector[out, k] -= low[i, k] * found


@kernel
def rate(state: Floats, row: Floats, row_body: Ints, r: int) -> float:
    """J v of row r."""
    a, b = row_body[r, 0], row_body[r, 1]
    return (
        dot(load3(row, r, 0), load3(state, a, V))
        + dot(load3(row, r, 3), load3(state, a, W))
        + dot(load3(row, r, 6), load3(state, b, V))
        + dot(load3(row, r, 9), load3(state, b, W))
    )


@kernel
def apply(state: Floats, row_body: Ints, reach: Floats, r: int, impulse: float) -> None:
    """v += M^-1 J^T impulse."""
    for side in range(2):
        b = row_body[r, side]
        store3(state, b, V, axpy(impulse, load3(reach, r, 6 * side), load3(state, b, V)))
        store3(state, b, W, axpy(impulse, load3(reach, r, 6 * side + 3), load3(state, b, W)))


@kernel
def apply_all(
    table: Floats, row: Floats, row_body: Ints, reach: Floats, n: int, body: Floats, turned: Floats, vector: Floats, which: int,
    sign: float,
) -> None:  # fmt: skip
    """Add sign M^-1 J^T vector[which] to the columns V and W of the table."""
    if is_careful(n, vector):
        force = np.zeros((body.shape[0], 6))
        careful_apply(table, row, row_body, n, body, turned, vector, which, sign, force)
        return
    for r in range(n):
        apply(table, row_body, reach, r, sign * vector[which, r])


@kernel
def solve_bounded(
    state: Floats, row: Floats, row_body: Ints, equalities: int, count: int, body: Floats, turned: Floats, reach: Floats,
    matrix: Floats, low: Floats, vector: Floats, known: int,
) -> None:  # fmt: skip
    """Give impulses so that J v + softness * impulse + bias = 0 on free rows, each between its bounds; written to IMPULSE.

    Args: known: 1 if the matrix is that of the last call, whose factor serves again where no bound held a row then.
    Raises: nothing; after 20 changes of the free set the last one stands.
    """
    for r in range(count):
        vector[WORK, r] = -(rate(state, row, row_body, r) + row[r, BIAS])
        vector[LOWEST, r] = row[r, LOW] if r >= equalities else -math.inf
        vector[HIGHEST, r] = row[r, HIGH] if r >= equalities else math.inf
        vector[IMPULSE, r] = 0.0
    held = vector[BOUND]
    factored = known == 1
    for r in range(count):
        factored = factored and held[r] == 0.0
        held[r] = 0.0
    for _ in range(20):
        for r in range(count):
            if not factored:
                vector[PIVOT, r] = 1.0 if held[r] != 0.0 else 0.0
            total = vector[WORK, r]
            for s in range(equalities, count):
                if held[s] != 0.0:
                    total -= matrix[r, s] * (vector[LOWEST, s] if held[s] < 0.0 else vector[HIGHEST, s])
            vector[RIGHT, r] = total
        if not factored:
            factor(row, row_body, body, matrix, low, count, vector)
        factored = False
        careful = is_careful(count, vector)
        if careful:
            for r in range(count):
                vector[IMPULSE, r] = 0.0
                if held[r] != 0.0:
                    vector[IMPULSE, r] = vector[LOWEST, r] if held[r] < 0.0 else vector[HIGHEST, r]
            careful_solve(row, row_body, count, body, turned, low, vector, WORK, IMPULSE, np.zeros((body.shape[0], 6)))
        else:
            solve(row, row_body, body, turned, low, count, vector, RIGHT, IMPULSE)
        changed = False
        for r in range(equalities, count):
            if held[r] == 0.0:
                if vector[IMPULSE, r] < vector[LOWEST, r]:
                    held[r] = -1.0
                    changed = True
                elif vector[IMPULSE, r] > vector[HIGHEST, r]:
                    held[r] = 1.0
                    changed = True
            else:
                vector[IMPULSE, r] = vector[LOWEST, r] if held[r] < 0.0 else vector[HIGHEST, r]
        change = state
        if careful and equalities < count:
            change = np.zeros((body.shape[0], 13))
            apply_all(change, row, row_body, reach, count, body, turned, vector, IMPULSE, 1.0)
        for r in range(equalities, count):
            if held[r] != 0.0:
                left = vector[WORK, r]
                if careful:
                    left -= rate(change, row, row_body, r) + row[r, SOFTNESS] * vector[IMPULSE, r]
                else:
                    for s in range(count):
                        left -= matrix[r, s] * vector[IMPULSE, s]
                if left * held[r] < -1e-12 * (1.0 + abs(vector[WORK, r])):
                    held[r] = 0.0
                    changed = True
        if not changed:
            break
    apply_all(state, row, row_body, reach, count, body, turned, vector, IMPULSE, 1.0)
