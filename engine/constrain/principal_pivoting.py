"""Find which rows are at their bounds one row after the other, where changing all sides at once does not come to an end.

With the equality rows solved, the rows with bounds are left with the smaller matrix S and what they ask for, c:

    low <= lambda <= high,   c - S lambda = 0 where free, <= 0 at low, >= 0 at high.

Rows come in one by one. The impulse of the newest grows until it is met or at its bound; the free ones go along so that they
stay met, and whichever meets a bound, or stops pressing on its own, changes sides on the way. A row that depends on free ones
takes the place of the first that lets go; one that no bound gives way to cannot be met and is left out.

Source: Cottle, Dantzig, Complementary pivot theory of mathematical programming, Linear Algebra Appl. 1, 1968; Baraff, Fast
contact force computation for nonpenetrating rigid bodies, SIGGRAPH 1994; Cottle, Pang, Stone, The Linear Complementarity
Problem, section 4.2.
"""

import math
from typing import NamedTuple

import numpy as np

from plumbline.engine.compile.jit import kernel
from plumbline.engine.constrain.careful import careful_solve
from plumbline.engine.constrain.dependence import SUSPECT
from plumbline.engine.constrain.direct import apply_all, factor, is_careful, rate, solve
from plumbline.engine.maths.rows import Floats
from plumbline.engine.memory import arena as at
from plumbline.engine.memory.tables import Bodies, Rows

ROUND_OFF = 1e-12
"""As in `bounded`."""

TIE = 1e-9
"""Where the times of two rows differ by less than this share, the newest one changes sides alone; and an impulse that takes
less than this share in that of the newest, each by what it does to its own row, takes none."""

EVENTS = 20
"""Changes of sides a row, on average, that one row's coming in may cause."""


class Bounded(NamedTuple):
    """Rows with bounds: S (m, m), c (m,), the bounds, what of c is round-off, and the result, -1 at low, 0 free, 1 at high."""

    matrix: Floats
    asked: Floats
    low: Floats
    high: Floats
    least: Floats
    side: Floats


@kernel
def settle_bounds(bodies: Bodies, rows: Rows, equalities: int, n: int) -> None:
    """Write BOUND, from WORK, LOWEST and HIGHEST. PIVOT, RIGHT, IMPULSE and the factor are overwritten."""
    vector, m = rows.vector, n - equalities
    bounded = Bounded(np.zeros((m, m)), np.zeros(m), np.zeros(m), np.zeros(m), np.zeros(m), np.zeros(m))
    for r in range(n):
        vector[at.PIVOT, r] = 1.0 if r >= equalities else 0.0
        vector[at.RIGHT, r] = vector[at.WORK, r]
    factor(rows, n, bodies.body)
    answer(bodies, rows, n, -1)
    for k in range(m):
        r = equalities + k
        bounded.low[k], bounded.high[k] = vector[at.LOWEST, r], vector[at.HIGHEST, r]
        bounded.asked[k] = vector[at.WORK, r] - response(bodies, rows, n, r)
        bounded.least[k] = ROUND_OFF * (1.0 + abs(vector[at.WORK, r]) + abs(bounded.asked[k]))
    for k in range(m):
        for r in range(n):
            vector[at.RIGHT, r] = -rows.matrix[r, equalities + k]
        answer(bodies, rows, n, equalities + k)
        for i in range(m):
            bounded.matrix[i, k] = response(bodies, rows, n, equalities + i)
    settle(bounded)
    for k in range(m):
        vector[at.BOUND, equalities + k] = bounded.side[k]


@kernel
def answer(bodies: Bodies, rows: Rows, n: int, unit: int) -> None:
    """Solve the equality rows for RIGHT, into IMPULSE, beside a unit impulse of one row with bounds, or none for -1."""
    vector = rows.vector
    careful = is_careful(rows, n)
    if not careful:
        solve(rows, n, bodies, at.RIGHT, at.IMPULSE)
    else:
        for r in range(n):
            vector[at.IMPULSE, r] = 0.0
            if unit >= 0:
                vector[at.RIGHT, r] = 0.0
    if unit >= 0:
        vector[at.IMPULSE, unit] = 1.0
    if careful:
        careful_solve(rows, n, bodies, at.RIGHT, at.IMPULSE, np.zeros((bodies.body.shape[0], 6)))


@kernel
def response(bodies: Bodies, rows: Rows, n: int, r: int) -> float:
    """J M^-1 J^T of row r, softness included, times all impulses."""
    row, vector = rows.row, rows.vector
    if is_careful(rows, n):
        change = np.zeros((bodies.body.shape[0], 13))
        apply_all(change, rows, n, bodies, at.IMPULSE, 1.0)
        return rate(change, rows, r) + float(row[r, at.SOFTNESS] * vector[at.IMPULSE, r])
    total = 0.0
    for s in range(n):
        total += rows.matrix[r, s] * vector[at.IMPULSE, s]
    return total


@kernel
def settle(bounded: Bounded) -> None:
    """Write the sides; rows that cannot be met are held where their impulse is 0, else free."""
    m = bounded.asked.shape[0]
    out = np.zeros(m)
    for _ in range(m + 1):
        vain = admit_all(bounded, out)
        if vain < 0:
            break
        out[vain] = 1.0
    for k in range(m):
        if out[k] == 1.0:
            bounded.side[k] = -1.0 if bounded.low[k] == 0.0 else 1.0 if bounded.high[k] == 0.0 else 0.0


@kernel
def admit_all(bounded: Bounded, out: Floats) -> int:
    """Take in one row after the other, but for those that are out. Returns: a row that cannot be met, or -1."""
    m = bounded.asked.shape[0]
    impulse, left, known = np.zeros(m), bounded.asked.copy(), np.zeros(m)
    for k in range(m):
        bounded.side[k] = 0.0
    for r in range(m):
        if out[r] == 1.0:
            continue
        for _ in range(EVENTS * (m + 1)):
            met = abs(left[r]) <= bounded.least[r]
            if met and bounded.low[r] < impulse[r] < bounded.high[r]:
                break
            if left[r] <= bounded.least[r] and impulse[r] <= bounded.low[r]:
                bounded.side[r] = -1.0
                break
            if left[r] >= -bounded.least[r] and impulse[r] >= bounded.high[r]:
                bounded.side[r] = 1.0
                break
            event = advance(bounded, impulse, left, known, r)
            if event < 0:
                return r
            if event == r:
                break
        known[r] = 1.0
    return -1


@kernel
def advance(bounded: Bounded, impulse: Floats, left: Floats, known: Floats, r: int) -> int:
    """Let the impulse of row r grow, or shrink, as it asks, up to the first change of sides, and make that.

    Returns: the row that changed, r where it is met or at its bound; -1 where nothing ever changes.
    """
    S, side, m = bounded.matrix, bounded.side, left.shape[0]
    sign = 1.0 if left[r] > 0.0 else -1.0
    way = shares(bounded, known, r)
    for k in range(m):
        way[k] *= sign
    first, event, next_side = math.inf, -1, 0.0
    for k in range(m):
        slope = 0.0
        for s in range(m):
            slope -= S[k, s] * way[s]
        if k == r:
            bound = bounded.high[r] if sign > 0.0 else bounded.low[r]
            time, to = (bound - impulse[r]) * sign, sign
            if -slope * sign > SUSPECT * S[r, r] and left[r] / -slope < time:
                time, to = left[r] / -slope, 0.0
        elif known[k] == 0.0:
            continue
        elif side[k] == 0.0:
            if abs(way[k]) * math.sqrt(S[k, k]) <= TIE * math.sqrt(S[r, r]):
                continue
            bound = bounded.high[k] if way[k] > 0.0 else bounded.low[k]
            time, to = (bound - impulse[k]) / way[k], 1.0 if way[k] > 0.0 else -1.0
        else:
            if slope * side[k] >= -SUSPECT * math.sqrt(S[k, k] * S[r, r]):
                continue
            time, to = left[k] / -slope, 0.0
        if time < math.inf and (time < first * (1.0 - TIE) or (k == r and time * (1.0 - TIE) <= first)):
            first, event, next_side = max(time, 0.0), k, to
    if event < 0:
        return -1
    for k in range(m):
        impulse[k] += first * way[k]
    side[event] = next_side
    if next_side != 0.0:
        impulse[event] = bounded.high[event] if next_side > 0.0 else bounded.low[event]
    for k in range(m):
        total = bounded.asked[k]
        for s in range(m):
            total -= S[k, s] * impulse[s]
        left[k] = total
    return event


@kernel
def shares(bounded: Bounded, known: Floats, r: int) -> Floats:
    """How all impulses change as that of row r grows by 1 and the free ones keep what they ask for, by Cholesky."""
    S, m = bounded.matrix, known.shape[0]
    way, free, low = np.zeros(m), np.zeros(m, np.int64), np.zeros((m, m))
    n = 0
    for k in range(m):
        if known[k] == 1.0 and bounded.side[k] == 0.0 and k != r:
            free[n] = k
            n += 1
    for i in range(n):
        for j in range(i + 1):
            total = S[free[i], free[j]]
            for k in range(j):
                total -= low[i, k] * low[j, k]
            if i == j:
                low[i, i] = math.sqrt(max(total, SUSPECT * S[free[i], free[i]]))
            else:
                low[i, j] = total / low[j, j]
        total = -S[free[i], r]
        for k in range(i):
            total -= low[i, k] * way[free[k]]
        way[free[i]] = total / low[i, i]
    for i in range(n - 1, -1, -1):
        total = way[free[i]]
        for k in range(i + 1, n):
            total -= low[k, i] * way[free[k]]
        way[free[i]] = total / low[i, i]
    way[r] = 1.0
    return way
