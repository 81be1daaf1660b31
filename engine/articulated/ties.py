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
from plumbline.engine.articulated.motion import change_along
from plumbline.engine.articulated.tables import Tables
from plumbline.engine.compile.jit import kernel
from plumbline.engine.maths.rows import load3, store3
from plumbline.engine.maths.vec import add, axpy, dot

DEPENDENT: Final = 1e-13
"""Pivots below this share of what a tie's two columns give way alone are round-off: the columns cannot be moved."""


@kernel
def follow_rates(tables: Tables) -> None:
    """Let the rates of columns that follow others be what their ties say, to the last bit."""
    column, kind = tables.column, tables.kind
    for t in range(tables.follower.shape[0]):
        i = tables.follower[t, 0]
        led_by = column[kind[kind[i, tree.LEADER], tree.FIRST], tree.RATE]
        column[kind[i, tree.FIRST], tree.RATE] = tables.link[i, tree.RATIO] * led_by


@kernel
def follow_coordinates(tables: Tables) -> None:
    """Let the coordinates that follow others be what their ties say."""
    link, coordinate = tables.link, tables.coordinate
    for t in range(tables.follower.shape[0]):
        i = tables.follower[t, 0]
        leader = tables.kind[i, tree.LEADER]
        moved = coordinate[leader, 0] - link[leader, tree.START_X]
        coordinate[i, 0] = link[i, tree.START_X] + link[i, tree.RATIO] * moved


@kernel
def pulled_by(tables: Tables, tie: int, k: int) -> float:
    """What a unit of a tie's force is along column k."""
    if tie >= tables.follower.shape[0]:
        return float(tables.arm[(tie - tables.follower.shape[0]) * tables.column.shape[0] + k, 0])
    follower = tables.follower[tie, 0]
    if k == tables.kind[follower, tree.FIRST]:
        return 1.0
    leader = tables.kind[follower, tree.LEADER]
    return float(-tables.link[follower, tree.RATIO]) if k == tables.kind[leader, tree.FIRST] else 0.0


@kernel
def answer_inwards(tables: Tables, tie: int) -> None:
    """Write what a unit of a tie's force leaves along every column, and what it makes every link need."""
    answer, column, kind = tables.tie_link, tables.column, tables.kind
    row, first_column = tie * kind.shape[0], tie * column.shape[0]
    for i in range(kind.shape[0]):
        for c in range(tree.TIE_FORCE, tree.TIE_FORCE + 6):
            answer[row + i, c] = 0.0
    for i in range(kind.shape[0] - 1, -1, -1):
        first, parent = kind[i, tree.FIRST], kind[i, tree.PARENT]
        torque, force = load3(answer, row + i, tree.TIE_FORCE), load3(answer, row + i, tree.TIE_FORCE + 3)
        for k in range(first + kind[i, tree.COLUMNS] - 1, first - 1, -1):
            left = pulled_by(tables, tie, k)
            left -= dot(load3(column, k, tree.AXIS_W), torque) + dot(load3(column, k, tree.AXIS_W + 3), force)
            if column[k, tree.ADDED] == math.inf:
                left = 0.0
            else:
                share = column[k, tree.INVERSE] * left
                torque = axpy(share, load3(column, k, tree.PULL), torque)
                force = axpy(share, load3(column, k, tree.PULL + 3), force)
            tables.tie_column[first_column + k, tree.TIE_LEFT] = left
        store3(answer, row + i, tree.TIE_FORCE, torque)
        store3(answer, row + i, tree.TIE_FORCE + 3, force)
        if parent >= 0:
            store3(answer, row + parent, tree.TIE_FORCE, add(load3(answer, row + parent, tree.TIE_FORCE), torque))
            store3(answer, row + parent, tree.TIE_FORCE + 3, add(load3(answer, row + parent, tree.TIE_FORCE + 3), force))


@kernel
def answer_outwards(tables: Tables, answer: int, moved: bool) -> None:
    """Write what an answer changes of every column's rate and every link's motion, from what it leaves along columns.

    Args: moved: whether columns whose change is prescribed make it, and links have a bias.
    """
    link, column, kind = tables.tie_link, tables.column, tables.kind
    row, first_column = answer * kind.shape[0], answer * column.shape[0]
    for i in range(kind.shape[0]):
        parent = kind[i, tree.PARENT]
        a_w, a_v = (0.0, 0.0, 0.0), (0.0, 0.0, 0.0)
        if moved:
            a_w, a_v = load3(tables.motion, i, tree.BIAS), load3(tables.motion, i, tree.BIAS + 3)
        if parent >= 0:
            a_w = add(a_w, load3(link, row + parent, tree.TIE_ACCELERATION))
            a_v = add(a_v, load3(link, row + parent, tree.TIE_ACCELERATION + 3))
        for k in range(kind[i, tree.FIRST], kind[i, tree.FIRST] + kind[i, tree.COLUMNS]):
            change = column[k, tree.CHANGE] if moved else 0.0
            change, a_w, a_v = change_along(column, k, tables.tie_column[first_column + k, tree.TIE_LEFT], change, a_w, a_v)
            tables.tie_column[first_column + k, tree.TIE_CHANGE] = change
        store3(link, row + i, tree.TIE_ACCELERATION, a_w)
        store3(link, row + i, tree.TIE_ACCELERATION + 3, a_v)


@kernel
def slip(tables: Tables, tie: int, answer: int) -> float:
    """By how much the changes that an answer holds break a tie, or lengthen a tendon."""
    first_column = answer * tables.column.shape[0]
    if tie >= tables.follower.shape[0]:
        total = 0.0
        for k in range(tables.column.shape[0]):
            arm = pulled_by(tables, tie, k)
            if arm != 0.0:
                total += arm * tables.tie_column[first_column + k, tree.TIE_CHANGE]
        return float(total)
    follower = tables.follower[tie, 0]
    leader, ratio = tables.kind[follower, tree.LEADER], tables.link[follower, tree.RATIO]
    follows = tables.tie_column[first_column + tables.kind[follower, tree.FIRST], tree.TIE_CHANGE]
    return float(follows - ratio * tables.tie_column[first_column + tables.kind[leader, tree.FIRST], tree.TIE_CHANGE])


@kernel
def factor_ties(tables: Tables) -> None:
    """Write what a unit of each tie's force does, by the articulated inertia at hand, and the factor of C H^-1 C^T."""
    n, low = tables.tie.shape[0], tables.tie_factor
    for t in range(n):
        answer_inwards(tables, t)
        answer_outwards(tables, t, moved=False)
    for t in range(n):
        for s in range(t + 1):
            total = slip(tables, t, s) + (tables.tie[t, tree.SOFTNESS] if s == t else 0.0)
            whole = total
            for r in range(s):
                total -= low[n * t + r, 0] * low[n * s + r, 0]
            if s < t:
                low[n * t + s, 0] = 0.0 if tables.tie[s, tree.SLACK] == 1.0 else total / low[n * s + s, 0]
            else:
                slack = total <= DEPENDENT * whole or tables.tie[t, tree.KNOWN] == 1.0
                tables.tie[t, tree.SLACK] = 1.0 if slack else 0.0
                low[n * t + t, 0] = 1.0 if slack else math.sqrt(total)
        if tables.tie[t, tree.SLACK] == 1.0:
            for s in range(t):
                low[n * t + s, 0] = 0.0


@kernel
def probe(tables: Tables, moved: bool) -> None:
    """Write into the answer behind those of all ties what changes without them, from what the inward pass left.

    Args: moved: as of `answer_outwards`.
    """
    n = tables.tie.shape[0]
    for k in range(tables.column.shape[0]):
        tables.tie_column[n * tables.column.shape[0] + k, tree.TIE_LEFT] = tables.column[k, tree.LEFT]
    answer_outwards(tables, n, moved)


@kernel
def pull(tables: Tables, t: int, force: float) -> None:
    """Add a tie's force to what the inward pass left along columns and made links need."""
    for k in range(tables.column.shape[0]):
        if tables.column[k, tree.ADDED] != math.inf:
            tables.column[k, tree.LEFT] += force * tables.tie_column[t * tables.column.shape[0] + k, tree.TIE_LEFT]
    for i in range(tables.kind.shape[0]):
        for c in range(6):
            tables.body[i, tree.FORCE + c] += force * tables.tie_link[t * tables.kind.shape[0] + i, tree.TIE_FORCE + c]


@kernel
def pull_ties(tables: Tables, moved: bool) -> None:
    """Let the ties hold, and the tendons pull.

    Args: moved: as of `probe`; else tendons answer what changes alone.
    """
    tie, low, n, ties = tables.tie, tables.tie_factor, tables.tie.shape[0], tables.follower.shape[0]
    for t in range(ties, n):
        if moved and tie[t, tree.KNOWN] == 1.0:
            pull(tables, t, tie[t, tree.AIM])
    probe(tables, moved)
    for t in range(n):
        total = (tie[t, tree.AIM] if moved else 0.0) - slip(tables, t, n)
        for s in range(t):
            total -= low[n * t + s, 0] * tie[s, tree.PULLED]
        tie[t, tree.PULLED] = 0.0 if tie[t, tree.SLACK] == 1.0 else total / low[n * t + t, 0]
    for t in range(n - 1, -1, -1):
        total = tie[t, tree.PULLED]
        for s in range(t + 1, n):
            total -= low[n * s + t, 0] * tie[s, tree.PULLED]
        tie[t, tree.PULLED] = 0.0 if tie[t, tree.SLACK] == 1.0 else total / low[n * t + t, 0]
    for t in range(n):
        pull(tables, t, tie[t, tree.PULLED])
    for t in range(ties, n):
        if moved and tie[t, tree.KNOWN] == 1.0:
            tie[t, tree.PULLED] = tie[t, tree.AIM]
        tie[t, tree.HOLDS] = tie[t, tree.PULLED] + (0.0 if moved else tie[t, tree.HOLDS])


@kernel
def pulled_beside(tables: Tables, k: int) -> float:
    """What the tendons push along column k by the forces that were found last."""
    total = 0.0
    for t in range(tables.follower.shape[0], tables.tie.shape[0]):
        total += tables.tie[t, tree.PULLED] * pulled_by(tables, t, k)
    return float(total)
