"""From links to roots and back: what forces leave along columns, and how links and columns answer, by the inertia at hand.

    inwards:   u = push - S . p,  p <- p + U u / D,  p_parent <- p_parent + p        column by column, the outermost first
    outwards:  a <- a_parent + c,  q'' = (u - U . a) / D,  a <- a + S q''            column by column, the innermost first

There is an answer to what acts now, the first, and one to a unit force of each tie.

Source: as `engine.articulated.articulated_body`, whose inward pass has written U and D.
"""

import math

from plumbline.engine.articulated import tables as tree
from plumbline.engine.articulated.spatial import NOTHING, Spatial, add6, add_row, axpy6, dot6
from plumbline.engine.articulated.tables import Trees
from plumbline.engine.compile.jit import kernel
from plumbline.engine.maths.rows import load6, store6


@kernel
def forces_inwards(trees: Trees, answer: int) -> None:
    """Write what the forces of links leave along every column beside what pushes there, which LEFT holds; without a bias."""
    column, along, kind = trees.column, trees.along, trees.kind
    row, first_column = answer * kind.shape[0], answer * column.shape[0]
    for i in range(kind.shape[0] - 1, -1, -1):
        first, force = kind[i, tree.FIRST], load6(trees.answer, row + i, tree.FORCE)
        for k in range(first + kind[i, tree.COLUMNS] - 1, first - 1, -1):
            if column[k, tree.ADDED] != math.inf:
                left = along[first_column + k, tree.LEFT] - dot6(load6(column, k, tree.AXIS_W), force)
                along[first_column + k, tree.LEFT] = left
                force = axpy6(column[k, tree.INVERSE] * left, load6(column, k, tree.PULL), force)
        store6(trees.answer, row + i, tree.FORCE, force)
        if kind[i, tree.PARENT] >= 0:
            add_row(trees.answer, row + kind[i, tree.PARENT], tree.FORCE, force)


@kernel
def before_joint(trees: Trees, answer: int, i: int, biased: bool) -> Spatial:
    """The acceleration of link i but for that along its own columns. Args: biased: whether links have a bias."""
    a, parent = NOTHING, trees.kind[i, tree.PARENT]
    if biased:
        a = load6(trees.motion, i, tree.BIAS)
    if parent >= 0:
        a = add6(a, load6(trees.answer, answer * trees.kind.shape[0] + parent, tree.ACCELERATION))
    return a


@kernel
def outwards(trees: Trees, answer: int, biased: bool, moved: bool) -> None:
    """Write the acceleration of every link and the change of every column's rate, from what is left along columns.

    Args: biased: as of `before_joint`; moved: whether columns whose change is prescribed make it.
    """
    column, along, kind = trees.column, trees.along, trees.kind
    row, first_column = answer * kind.shape[0], answer * column.shape[0]
    for i in range(kind.shape[0]):
        a = before_joint(trees, answer, i, biased)
        for k in range(kind[i, tree.FIRST], kind[i, tree.FIRST] + kind[i, tree.COLUMNS]):
            change = along[first_column + k, tree.CHANGE] if moved else 0.0
            if column[k, tree.ADDED] != math.inf:
                change = column[k, tree.INVERSE] * (along[first_column + k, tree.LEFT] - dot6(load6(column, k, tree.PULL), a))
            a = axpy6(change, load6(column, k, tree.AXIS_W), a)
            along[first_column + k, tree.CHANGE] = change
        store6(trees.answer, row + i, tree.ACCELERATION, a)
