"""Tell a row that follows from the rows before it from one that only bears on little mass or inertia.

A small pivot of J M^-1 J^T says that some combination of rows, J_i - sum mu_k J_k, meets next to no mobility. Either the
combination itself vanishes: the row is redundant, as in closed loops. Or the mobilities of the bodies lie far apart, as of a
heavy point on a light arm: then the combination is a row in its own right. The masses cannot tell, the Jacobian can.

In space, redundant rows follow from the others in a closed loop alone: where it is open by a share g of its levers, as in the
stages of a step, each row is off by g, and of the combination is left up to g sum |mu_k|. Near a singular pose the mu_k grow,
and this is as much as singles out a row in its own right elsewhere; so it is told by this bound and not by its size.

Source: Golub, Van Loan, Matrix Computations, sections 2.6.1 (scaling), 2.6.2 (perturbation) and 5.5 (rank).
"""

import math

import numpy as np

from plumbline.engine.compile.jit import kernel
from plumbline.engine.maths.rows import Floats, load3
from plumbline.engine.maths.vec import dot
from plumbline.engine.memory import arena as at
from plumbline.engine.memory.tables import Rows

LOW_PIVOT = 1e-6
"""Pivots below this share of their diagonal are looked into: gaps of 1e-5 leave 1e-10, and more near a singular pose."""

SUSPECT = 1e-11
"""Below this share, floats do not carry the solution; above it they do to five digits, which the projections that follow make
good."""

VANISHED = 3e-2
"""A combination below this share of its row is none. Masses alone make pivots small where the combination is as large as the
row; in loops round-off leaves 1e-16 of it, and near a singular pose the gaps within a step, divided by the distance from it."""

OPENED = 4.0
"""Times the bound on what gaps leave of a combination: a gap is that of an anchor, of which a pose may be off by more."""

NEAREST = 1e-9
"""Levers below this share of the longest one are round-off of an anchor in the centre of mass."""


@kernel
def lies_in_span(rows: Rows, i: int, body: Floats, pivot: float) -> bool:
    """Whether row i is a combination of the rows before it that are not held, whose `factor` is at hand, with its own.

    Lengths are made dimensionless by the levers of the joints on each body.

    Args: pivot: its share of the diagonal.
    """
    row, low, vector = rows.row, rows.factor, rows.vector
    mu = np.zeros(i + 1)
    first = int(vector[at.ENVELOPE, i])
    for j in range(first, i):
        mu[j] = low[i, j]
    for j in range(i - 1, -1, -1):
        if j < first:
            break
        if vector[at.PIVOT, j] == 1.0 or mu[j] == 0.0:
            mu[j] = 0.0
            continue
        mu[j] /= low[j, j]
        begin = int(vector[at.ENVELOPE, j])
        first = min(first, begin)
        for k in range(begin, j):
            mu[k] -= low[j, k] * mu[j]
    mu[i] = -1.0
    lowest, highest = body.shape[0], -1
    for r in range(first, i + 1):
        for side in range(2):
            b = rows.body[r, side]
            if mu[r] != 0.0 and body[b, at.INV_MASS] > 0.0:
                lowest, highest = min(lowest, b), max(highest, b)
    rest = np.zeros((max(highest - lowest + 1, 0), 7))
    longest = 0.0
    for r in range(first, i + 1):
        for side in range(2):
            b = rows.body[r, side] - lowest
            if mu[r] == 0.0 or body[rows.body[r, side], at.INV_MASS] == 0.0:
                continue
            for c in range(6):
                rest[b, c] += mu[r] * row[r, 6 * side + c]
            straight = dot(load3(row, r, 6 * side), load3(row, r, 6 * side))
            if straight > 0.0:
                turning = dot(load3(row, r, 6 * side + 3), load3(row, r, 6 * side + 3))
                rest[b, 6] = max(rest[b, 6], math.sqrt(turning / straight))
                longest = max(longest, rest[b, 6])
    own, left = 0.0, 0.0
    for b in range(rest.shape[0]):
        rest[b, 6] = max(rest[b, 6], NEAREST * longest) if longest > 0.0 else 1.0
        left += dot(load3(rest, b, 0), load3(rest, b, 0)) + dot(load3(rest, b, 3), load3(rest, b, 3)) / (
            rest[b, 6] * rest[b, 6]
        )
        for side in range(2):
            if rows.body[i, side] == b + lowest:
                along, about = load3(row, i, 6 * side), load3(row, i, 6 * side + 3)
                own += dot(along, along) + dot(about, about) / (rest[b, 6] * rest[b, 6])
    if pivot <= SUSPECT and left <= VANISHED * VANISHED * own:
        return True
    spread, opened = 0.0, 0.0
    for r in range(first, i + 1):
        size, lever = 0.0, 1.0
        for side in range(2):
            b = rows.body[r, side]
            if mu[r] != 0.0 and body[b, at.INV_MASS] > 0.0:
                along, about = load3(row, r, 6 * side), load3(row, r, 6 * side + 3)
                size += dot(along, along) + dot(about, about) / (rest[b - lowest, 6] * rest[b - lowest, 6])
                lever = longest if dot(along, along) > 0.0 else lever
        spread += abs(mu[r]) * math.sqrt(size)
        opened = max(opened, abs(row[r, at.GAP]) / lever if size > 0.0 else 0.0)
    reach = OPENED * opened * spread
    return left <= reach * reach
