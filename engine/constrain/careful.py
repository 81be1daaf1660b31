"""Solve the rows' impulses in double-double arithmetic, where masses and inertias lie too far apart for floats.

Of a body with inertia I on a lever l, forces across and along the lever meet mobilities in the ratio m l^2 / I. From 1e16 on
the smaller one is lost in the round-off of the larger, in the matrix, in the impulses and in the sum of their effects; so all
three have twice the digits here. The states before and after are floats.

Source: as `direct`; double-double arithmetic: Dekker, Numer. Math. 18, 1971; L D L^T: Golub, Van Loan, Matrix Computations,
section 4.1.2.
"""

import math

import numpy as np

from plumbline.engine.compile.jit import kernel
from plumbline.engine.constrain.dependence import LOW_PIVOT, lies_in_span
from plumbline.engine.maths.double_double import Double, add2, div2, dot2, less2, mul2, product
from plumbline.engine.maths.rows import Floats, Sym, load3, load6, store3
from plumbline.engine.maths.vec import add
from plumbline.engine.memory import arena as at
from plumbline.engine.memory.tables import Bodies, Rows

NOISE = 1e-27
"""Pivots below this share of their diagonal are round-off even here."""


@kernel
def sym_times(m: Sym, x: Double, y: Double, z: Double) -> tuple[Double, Double, Double]:
    """m (x, y, z)."""
    return dot2((m[0], m[3], m[4]), x, y, z), dot2((m[3], m[1], m[5]), x, y, z), dot2((m[4], m[5], m[2]), x, y, z)


@kernel
def mobilities(rows: Rows, n: int, bodies: Bodies, high: Floats, rest: Floats) -> None:
    """Write M^-1 J^T, (n, 12), as high + rest."""
    for r in range(n):
        for side in range(2):
            b = rows.body[r, side]
            first = 6 * side
            for c in range(3):
                high[r, first + c], rest[r, first + c] = product(bodies.body[b, at.INV_MASS], rows.row[r, first + c])
            torque = load3(rows.row, r, first + 3)
            spin = sym_times(load6(bodies.turned, b, 0), (torque[0], 0.0), (torque[1], 0.0), (torque[2], 0.0))
            for c in range(3):
                high[r, first + 3 + c], rest[r, first + 3 + c] = spin[c]


@kernel
def coupling(rows: Rows, r: int, s: int, high: Floats, rest: Floats) -> Double:
    """The entry (r, s) of J M^-1 J^T, softness apart."""
    total = (0.0, 0.0)
    for i in range(2):
        for k in range(2):
            if rows.body[r, i] == rows.body[s, k]:
                for c in range(6):
                    factor = (rows.row[r, 6 * i + c], 0.0)
                    total = add2(total, mul2(factor, (high[s, 6 * k + c], rest[s, 6 * k + c])))
    return total


@kernel
def careful_solve(rows: Rows, n: int, bodies: Bodies, right: int, out: int, force: Floats) -> None:
    """Impulses so that J M^-1 (force + J^T impulse) + softness impulse = vector[right] on rows that are not held (PIVOT 1).

    Held rows keep the impulse that vector[out] gives; rows that depend on others become held, with none. The impulses are
    vector[out] + vector[LOW_PART]. The factor becomes that of `direct`.

    Args: n: how many rows; right, out: rows of `vector`; force (bodies, 6): N and N m on each body.
    """
    row, low, vector = rows.row, rows.factor, rows.vector
    high, rest = np.empty((n, 12)), np.empty((n, 12))
    mobilities(rows, n, bodies, high, rest)
    unit_high, unit_rest = np.zeros((n, n)), np.zeros((n, n))
    spread_high, spread_rest = np.empty(n), np.empty(n)
    pivot_high, pivot_rest = np.zeros(n), np.zeros(n)
    for i in range(n):
        vector[at.LOW_PART, i] = 0.0
        first = 0
        while first < i and coupling(rows, i, first, high, rest)[0] == 0.0:
            first += 1
        vector[at.ENVELOPE, i] = first
        for j in range(i):
            low[i, j] = 0.0
        if vector[at.PIVOT, i] == 1.0:
            continue
        whole = add2(coupling(rows, i, i, high, rest), (row[i, at.SOFTNESS], 0.0))
        pivot = whole
        for j in range(first, i):
            if vector[at.PIVOT, j] == 1.0:
                continue
            total = coupling(rows, i, j, high, rest)
            for k in range(max(first, int(vector[at.ENVELOPE, j])), j):
                if vector[at.PIVOT, k] == 0.0:
                    total = less2(total, mul2((spread_high[k], spread_rest[k]), (unit_high[j, k], unit_rest[j, k])))
            spread_high[j], spread_rest[j] = total
            share = div2(total, (pivot_high[j], pivot_rest[j]))
            unit_high[i, j], unit_rest[i, j] = share
            pivot = less2(pivot, mul2(total, share))
            low[i, j] = total[0] / math.sqrt(pivot_high[j])
        lost = pivot[0] <= NOISE * whole[0]
        if not lost and pivot[0] <= LOW_PIVOT * whole[0] and row[i, at.SOFTNESS] == 0.0:
            lost = lies_in_span(rows, i, bodies.body, pivot[0] / whole[0])
        if lost:
            vector[at.PIVOT, i] = 1.0
            vector[out, i] = 0.0
            for j in range(first, i):
                low[i, j] = 0.0
        else:
            pivot_high[i], pivot_rest[i] = pivot
            low[i, i] = math.sqrt(pivot[0])
    for i in range(n):
        if vector[at.PIVOT, i] == 1.0:
            continue
        total = (vector[right, i], 0.0)
        for side in range(2):
            b = rows.body[i, side]
            for c in range(6):
                if force[b, c] != 0.0:
                    total = less2(total, mul2((force[b, c], 0.0), (high[i, 6 * side + c], rest[i, 6 * side + c])))
        for s in range(n):
            if vector[at.PIVOT, s] == 1.0 and vector[out, s] != 0.0:
                total = less2(total, mul2(coupling(rows, i, s, high, rest), (vector[out, s], 0.0)))
        for k in range(int(vector[at.ENVELOPE, i]), i):
            if vector[at.PIVOT, k] == 0.0:
                total = less2(total, mul2((unit_high[i, k], unit_rest[i, k]), (spread_high[k], spread_rest[k])))
        spread_high[i], spread_rest[i] = total
    for i in range(n):
        if vector[at.PIVOT, i] == 0.0:
            vector[out, i], vector[at.LOW_PART, i] = div2((spread_high[i], spread_rest[i]), (pivot_high[i], pivot_rest[i]))
    for i in range(n - 1, -1, -1):
        if vector[at.PIVOT, i] == 1.0:
            continue
        found = (vector[out, i], vector[at.LOW_PART, i])
        for k in range(int(vector[at.ENVELOPE, i]), i):
            if vector[at.PIVOT, k] == 0.0:
                before = (vector[out, k], vector[at.LOW_PART, k])
                vector[out, k], vector[at.LOW_PART, k] = less2(before, mul2((unit_high[i, k], unit_rest[i, k]), found))


@kernel
def careful_apply(table: Floats, rows: Rows, n: int, bodies: Bodies, which: int, sign: float, force: Floats) -> None:
    """Add sign M^-1 (force + J^T impulse) to the columns V and W of the table: forces are summed before inertia divides.

    Args: n: how many rows; which: the row of `vector` with their impulses; force (bodies, 6): N and N m on each body.
    """
    row, vector = rows.row, rows.vector
    high, rest = force.copy(), np.zeros(force.shape)
    for r in range(n):
        impulse = (vector[which, r], vector[at.LOW_PART, r])
        for side in range(2):
            b = rows.body[r, side]
            for c in range(6):
                if row[r, 6 * side + c] != 0.0:
                    part = mul2((row[r, 6 * side + c], 0.0), impulse)
                    high[b, c], rest[b, c] = add2((high[b, c], rest[b, c]), part)
    for b in range(bodies.body.shape[0]):
        m = bodies.body[b, at.INV_MASS]
        if m == 0.0:
            continue
        m = sign * m
        store3(table, b, at.V, add((m * high[b, 0], m * high[b, 1], m * high[b, 2]), load3(table, b, at.V)))
        x, y, z = sym_times(
            load6(bodies.turned, b, 0), (high[b, 3], rest[b, 3]), (high[b, 4], rest[b, 4]), (high[b, 5], rest[b, 5])
        )  # fmt: skip
        store3(table, b, at.W, add((sign * x[0], sign * y[0], sign * z[0]), load3(table, b, at.W)))
