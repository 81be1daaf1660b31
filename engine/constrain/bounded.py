"""Solve rows with bounds: a row at its bound is held there, the others are solved, until every sign is right.

All rows on the wrong side change it at once, which takes one or two rounds. Where that goes in circles, or a limit depends on
other rows, as where several joints of a loop have limits or a loop is stretched, `principal_pivoting` takes them one by one.

Source: Judice, Pires, A block principal pivoting algorithm for large-scale strictly monotone linear complementarity problems,
Computers Ops Res. 21, 1994; Cottle, Pang, Stone, The Linear Complementarity Problem, section 4.2.
"""

import math

import numpy as np

from plumbline.engine.compile.jit import inlined
from plumbline.engine.constrain.careful import careful_solve
from plumbline.engine.constrain.direct import apply_all, factor, is_careful, rate, solve
from plumbline.engine.constrain.principal_pivoting import settle_bounds
from plumbline.engine.constrain.stages import KNOWN, NEW
from plumbline.engine.maths.rows import Floats
from plumbline.engine.memory import arena as at
from plumbline.engine.memory.tables import Bodies, Rows

FAR = 1e-3
"""A limit that the velocities at hand [m/s or rad/s] stay off by more than this is held at no impulse to begin with."""

PATIENCE = 3
"""Rounds, after the best one, in which no fewer rows were on the wrong side."""

ROUND_OFF = 1e-12
"""What may be left of a row [m/s or rad/s], as a share of its largest term."""


@inlined
def unmet(change: Floats, rows: Rows, r: int, n: int, careful: bool) -> tuple[float, float]:
    """What row r still asks for, -(J v + softness * impulse + bias) after all impulses, and what of it may be round-off."""
    row, vector = rows.row, rows.vector
    left, largest = vector[at.WORK, r], abs(vector[at.WORK, r])
    if careful:
        left -= rate(change, rows, r) + row[r, at.SOFTNESS] * vector[at.IMPULSE, r]
    else:
        for s in range(n):
            term = rows.matrix[r, s] * vector[at.IMPULSE, s]
            left -= term
            largest = max(largest, abs(term))
    return left, ROUND_OFF * (1.0 + largest)


@inlined
def solve_held(bodies: Bodies, rows: Rows, equalities: int, n: int, factored: bool) -> None:
    """Solve the rows that BOUND leaves free, into IMPULSE. Args: factored: whether the factor for them is at hand."""
    vector = rows.vector
    held = vector[at.BOUND]
    for r in range(n):
        if not factored:
            vector[at.PIVOT, r] = 1.0 if held[r] != 0.0 else 0.0
        total = vector[at.WORK, r]
        for s in range(equalities, n):
            if held[s] != 0.0:
                total -= rows.matrix[r, s] * (vector[at.LOWEST, s] if held[s] < 0.0 else vector[at.HIGHEST, s])
        vector[at.RIGHT, r] = total
    if not factored:
        factor(rows, n, bodies.body)
    careful = is_careful(rows, n)
    if not careful:
        solve(rows, n, bodies, at.RIGHT, at.IMPULSE)
    for r in range(n):
        if held[r] != 0.0:
            vector[at.IMPULSE, r] = vector[at.LOWEST, r] if held[r] < 0.0 else vector[at.HIGHEST, r]
        elif careful:
            vector[at.IMPULSE, r] = 0.0
    if careful:
        careful_solve(rows, n, bodies, at.WORK, at.IMPULSE, np.zeros((bodies.body.shape[0], 6)))


@inlined
def change_sides(bodies: Bodies, rows: Rows, equalities: int, n: int) -> tuple[int, int]:
    """Hold free rows beyond a bound, and free held ones that are pressed away from theirs.

    Returns: how many there were; and how many free limits depend on other rows, which leave them violated.
    """
    row, vector = rows.row, rows.vector
    held, careful = vector[at.BOUND], is_careful(rows, n)
    change = np.zeros((bodies.body.shape[0] if careful else 0, 13))
    if careful:
        apply_all(change, rows, n, bodies, at.IMPULSE, 1.0)
    changed, stuck = 0, 0
    for r in range(equalities, n):
        impulse = vector[at.IMPULSE, r]
        if held[r] == 0.0 and (impulse < vector[at.LOWEST, r] or impulse > vector[at.HIGHEST, r]):
            held[r] = -1.0 if impulse < vector[at.LOWEST, r] else 1.0
            changed += 1
        elif held[r] != 0.0 or (vector[at.PIVOT, r] == 1.0 and row[r, at.SOFTNESS] == 0.0):
            left, least = unmet(change, rows, r, n, careful)
            if held[r] == 0.0:
                stuck += int(
                    (left > least and impulse < vector[at.HIGHEST, r]) or (left < -least and impulse > vector[at.LOWEST, r])
                )
            elif left * held[r] < -least:
                held[r] = 0.0
                changed += 1
    return changed, stuck


@inlined
def solve_bounded(bodies: Bodies, rows: Rows, equalities: int, n: int, matrix: int) -> None:
    """Change the velocities so that J v + softness * impulse + bias = 0 on free rows, each impulse between its bounds.

    The impulses go to IMPULSE; the first `equalities` of the n rows have no bounds.

    Args: matrix: NEW, or KNOWN if it is that of the last call, whose factor then serves until a row changes sides.
    """
    row, vector = rows.row, rows.vector
    for r in range(n):
        vector[at.WORK, r] = -(rate(bodies.state, rows, r) + row[r, at.BIAS])
        vector[at.LOWEST, r] = row[r, at.LOW] if r >= equalities else -math.inf
        vector[at.HIGHEST, r] = row[r, at.HIGH] if r >= equalities else math.inf
        vector[at.IMPULSE, r] = 0.0
        if matrix == NEW:
            off = r >= equalities and row[r, at.SOFTNESS] == 0.0 and row[r, at.LOW] == 0.0 and vector[at.WORK, r] < -FAR
            vector[at.BOUND, r] = -1.0 if off else 0.0
    factored, one_by_one, fewest, patience = matrix == KNOWN, False, n + 1, PATIENCE
    while True:
        solve_held(bodies, rows, equalities, n, factored=factored)
        if equalities == n or one_by_one:
            break
        changed, stuck = change_sides(bodies, rows, equalities, n)
        if changed == 0 and stuck == 0:
            break
        factored = False
        patience = PATIENCE if changed < fewest else patience - 1
        fewest = min(fewest, changed)
        one_by_one = changed == 0 or patience == 0
        if one_by_one:
            settle_bounds(bodies, rows, equalities, n)
    apply_all(bodies.state, rows, n, bodies, at.IMPULSE, 1.0)
