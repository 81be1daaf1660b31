"""Coordinates that follow others: forces along both that keep q_f = ratio q_l + offset, found through the tree.

    C q'' = 0,    C H^-1 C^T pull = -C q''_free    a row of C for each tie: 1 at the column that follows, -ratio at its leader

H^-1 C^T is what a unit of each tie's force does, by the articulated inertia at hand. With it, the forces go into what the
inward pass has left, so that the outward pass, joint forces and the forces at jumps know of them: as if the columns that
follow were not there (H of the others alone, R^T H R with q = R y). Ties between columns whose rates are prescribed are slack.

Source: Featherstone, Rigid Body Dynamics Algorithms, 2008, sections 8.5 to 8.7 (constraints by the inverse inertia); Jain,
Multibody graph transformations and analysis, part II, Nonlinear Dynamics 67, 2012 (the same, eliminated).
"""

import math
from typing import Final

from plumbline.engine.articulated import tables as tree
from plumbline.engine.articulated.passes import forces_inwards, outwards
from plumbline.engine.articulated.spatial import NOTHING, add_row, scale6
from plumbline.engine.articulated.tables import Trees
from plumbline.engine.compile.jit import kernel
from plumbline.engine.maths.rows import load6, store6

DEPENDENT: Final = 1e-13
"""Pivots below this share of what a tie's two columns give way alone are round-off: the columns cannot be moved."""


@kernel
def follow_rates(trees: Trees) -> None:
    """Let the rates of columns that follow others be what their ties say, to the last bit."""
    column, kind = trees.column, trees.kind
    for t in range(trees.follower.shape[0]):
        i = trees.follower[t, 0]
        led_by = column[kind[kind[i, tree.LEADER], tree.FIRST], tree.RATE]
        column[kind[i, tree.FIRST], tree.RATE] = trees.link[i, tree.RATIO] * led_by


@kernel
def follow_coordinates(trees: Trees) -> None:
    """Let the coordinates that follow others be what their ties say."""
    link, coordinate = trees.link, trees.coordinate
    for t in range(trees.follower.shape[0]):
        i = trees.follower[t, 0]
        leader = trees.kind[i, tree.LEADER]
        moved = coordinate[leader, 0] - link[leader, tree.START_X]
        coordinate[i, 0] = link[i, tree.START_X] + link[i, tree.RATIO] * moved


@kernel
def pulled_by(trees: Trees, tie: int, k: int) -> float:
    """What a unit of a tie's force is along column k."""
    if tie >= trees.follower.shape[0]:
        return float(trees.arm[(tie - trees.follower.shape[0]) * trees.column.shape[0] + k, 0])
    follower = trees.follower[tie, 0]
    if k == trees.kind[follower, tree.FIRST]:
        return 1.0
    leader = trees.kind[follower, tree.LEADER]
    return float(-trees.link[follower, tree.RATIO]) if k == trees.kind[leader, tree.FIRST] else 0.0


@kernel
def answer_unit(trees: Trees, tie: int) -> None:
    """Write what a unit of a tie's force does to all columns and links."""
    row, first_column = (1 + tie) * trees.kind.shape[0], (1 + tie) * trees.column.shape[0]
    for i in range(trees.kind.shape[0]):
        store6(trees.answer, row + i, tree.FORCE, NOTHING)
    for k in range(trees.column.shape[0]):
        free = trees.column[k, tree.ADDED] != math.inf
        trees.along[first_column + k, tree.LEFT] = pulled_by(trees, tie, k) if free else 0.0
    forces_inwards(trees, 1 + tie)
    outwards(trees, 1 + tie, False, False)


@kernel
def slip(trees: Trees, tie: int, answer: int) -> float:
    """By how much the changes that an answer holds break a tie, or lengthen a tendon. Args: answer: as in `passes`."""
    first_column = answer * trees.column.shape[0]
    if tie >= trees.follower.shape[0]:
        total = 0.0
        for k in range(trees.column.shape[0]):
            arm = pulled_by(trees, tie, k)
            if arm != 0.0:
                total += arm * trees.along[first_column + k, tree.CHANGE]
        return float(total)
    follower = trees.follower[tie, 0]
    leader, ratio = trees.kind[follower, tree.LEADER], trees.link[follower, tree.RATIO]
    follows = trees.along[first_column + trees.kind[follower, tree.FIRST], tree.CHANGE]
    return float(follows - ratio * trees.along[first_column + trees.kind[leader, tree.FIRST], tree.CHANGE])


@kernel
def factor_ties(trees: Trees) -> None:
    """Write what a unit of each tie's force does, by the articulated inertia at hand, and the factor of C H^-1 C^T."""
    n, low = trees.tie.shape[0], trees.tie_factor
    for t in range(n):
        answer_unit(trees, t)
    for t in range(n):
        for s in range(t + 1):
            total = slip(trees, t, 1 + s) + (trees.tie[t, tree.SOFTNESS] if s == t else 0.0)
            whole = total
            for r in range(s):
                total -= low[n * t + r, 0] * low[n * s + r, 0]
            if s < t:
                low[n * t + s, 0] = 0.0 if trees.tie[s, tree.SLACK] == 1.0 else total / low[n * s + s, 0]
            else:
                slack = total <= DEPENDENT * whole or trees.tie[t, tree.KNOWN] == 1.0
                trees.tie[t, tree.SLACK] = 1.0 if slack else 0.0
                low[n * t + t, 0] = 1.0 if slack else math.sqrt(total)
        if trees.tie[t, tree.SLACK] == 1.0:
            for s in range(t):
                low[n * t + s, 0] = 0.0


@kernel
def pull(trees: Trees, t: int, force: float) -> None:
    """Add a tie's force to what the inward pass left along columns and made links need."""
    n, m = trees.kind.shape[0], trees.column.shape[0]
    for k in range(m):
        trees.along[k, tree.LEFT] += force * trees.along[(1 + t) * m + k, tree.LEFT]
    for i in range(n):
        add_row(trees.answer, i, tree.FORCE, scale6(force, load6(trees.answer, (1 + t) * n + i, tree.FORCE)))


@kernel
def pull_ties(trees: Trees, biased: bool, moved: bool) -> None:
    """Let the ties hold, and the tendons pull.

    Args: biased, moved: as of `passes.outwards`; tendons answer what changes alone where nothing is moved.
    """
    tie, low, n, ties = trees.tie, trees.tie_factor, trees.tie.shape[0], trees.follower.shape[0]
    for t in range(ties, n):
        if moved and tie[t, tree.KNOWN] == 1.0:
            pull(trees, t, tie[t, tree.AIM])
    outwards(trees, 0, biased, moved)
    for t in range(n):
        total = (tie[t, tree.AIM] if moved else 0.0) - slip(trees, t, 0)
        for s in range(t):
            total -= low[n * t + s, 0] * tie[s, tree.PULLED]
        tie[t, tree.PULLED] = 0.0 if tie[t, tree.SLACK] == 1.0 else total / low[n * t + t, 0]
    for t in range(n - 1, -1, -1):
        total = tie[t, tree.PULLED]
        for s in range(t + 1, n):
            total -= low[n * s + t, 0] * tie[s, tree.PULLED]
        tie[t, tree.PULLED] = 0.0 if tie[t, tree.SLACK] == 1.0 else total / low[n * t + t, 0]
    for t in range(n):
        pull(trees, t, tie[t, tree.PULLED])
    for t in range(ties, n):
        if moved and tie[t, tree.KNOWN] == 1.0:
            tie[t, tree.PULLED] = tie[t, tree.AIM]
        tie[t, tree.HOLDS] = tie[t, tree.PULLED] + (0.0 if moved else tie[t, tree.HOLDS])


@kernel
def pulled_beside(trees: Trees, k: int) -> float:
    """What the tendons push along column k by the forces that were found last."""
    total = 0.0
    for t in range(trees.follower.shape[0], trees.tie.shape[0]):
        total += trees.tie[t, tree.PULLED] * pulled_by(trees, t, k)
    return float(total)
