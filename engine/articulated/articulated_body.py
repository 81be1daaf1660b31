"""The articulated-body algorithm: accelerations of trees from their forces, at a cost in proportion to the number of links.

    inwards:   U = I S,  D = S . U + added,  u = push - S . p
               I <- I - U U^T / D,  p <- p + U u / D       column by column, the outermost first
               I_parent <- I_parent + I,  p_parent <- p_parent + p + I c
    outwards:  a <- a_parent + c
               q'' = (u - U . a) / D,  a <- a + S q''      column by column, the innermost first

A joint with several columns is a chain of joints with one each between links without mass, for which this is the same. Where
q'' is prescribed (hybrid dynamics), I stays as it is and p takes in I S q''.

Source: Featherstone, Rigid Body Dynamics Algorithms, 2008, sections 7.3 (table 7.1) and 9.2 (hybrid dynamics).
"""

import math

from plumbline.engine.articulated import tables as tree
from plumbline.engine.articulated.passes import before_joint, outwards
from plumbline.engine.articulated.spatial import Spatial, add6, add_row, axpy6, dot6, sliding, times, turning
from plumbline.engine.articulated.tables import Trees
from plumbline.engine.articulated.ties import factor_ties, pull_ties
from plumbline.engine.compile.jit import kernel
from plumbline.engine.maths.floats import fma
from plumbline.engine.maths.rows import Mat, Sym, Vec, load6, load9, store6, store9
from plumbline.engine.maths.vec import axpy, dot


@kernel
def sym_less(s: Sym, v: Vec, f: float) -> Sym:
    """S - f v v^T."""
    x, y, z = -f * v[0], -f * v[1], -f * v[2]
    return (
        fma(x, v[0], s[0]), fma(y, v[1], s[1]), fma(z, v[2], s[2]), fma(x, v[1], s[3]), fma(x, v[2], s[4]), fma(y, v[2], s[5])
    )  # fmt: skip


@kernel
def mat_less(m: Mat, v: Vec, w: Vec, f: float) -> Mat:
    """M - f v w^T."""
    return (
        *axpy(-f * v[0], w, (m[0], m[1], m[2])),
        *axpy(-f * v[1], w, (m[3], m[4], m[5])),
        *axpy(-f * v[2], w, (m[6], m[7], m[8])),
    )


@kernel
def inwards(trees: Trees, biased: bool) -> None:
    """Write the articulated inertia and force of every link, and pull, inverse and what is left of every column.

    Args: biased: whether links have a bias; it is zero otherwise.
    """
    body, column, along, kind = trees.body, trees.column, trees.along, trees.kind
    for i in range(kind.shape[0] - 1, -1, -1):
        first, parent, force = kind[i, tree.FIRST], kind[i, tree.PARENT], load6(trees.answer, i, tree.FORCE)
        rotation, translation = load6(body, i, tree.ROTATION), load6(body, i, tree.TRANSLATION)
        coupling = load9(body, i, tree.COUPLING)
        for k in range(first + kind[i, tree.COLUMNS] - 1, first - 1, -1):
            axis = load6(column, k, tree.AXIS_W)
            pull = times(rotation, coupling, translation, axis)
            store6(column, k, tree.PULL, pull)
            if column[k, tree.ADDED] == math.inf:
                share = along[k, tree.CHANGE]
            else:
                inverse = 1.0 / (dot6(axis, pull) + column[k, tree.ADDED])
                left = column[k, tree.PUSH] - dot(turning(axis), turning(force)) - dot(sliding(axis), sliding(force))
                rotation = sym_less(rotation, turning(pull), inverse)
                translation = sym_less(translation, sliding(pull), inverse)
                coupling = mat_less(coupling, turning(pull), sliding(pull), inverse)
                share = inverse * left
                column[k, tree.INVERSE], along[k, tree.LEFT] = inverse, left
            force = axpy6(share, pull, force)
        store6(body, i, tree.ROTATION, rotation)
        store6(body, i, tree.TRANSLATION, translation)
        store9(body, i, tree.COUPLING, coupling)
        store6(trees.answer, i, tree.FORCE, force)
        if parent < 0:
            continue
        if biased:
            force = add6(force, times(rotation, coupling, translation, load6(trees.motion, i, tree.BIAS)))
        for c in range(body.shape[1]):
            body[parent, c] += body[i, c]
        add_row(trees.answer, parent, tree.FORCE, force)


@kernel
def accelerations(trees: Trees, biased: bool) -> None:
    """Write the acceleration of every link and the change of every column's rate under what acts. Args: as `inwards`."""
    inwards(trees, biased)
    if trees.tie.shape[0] > 0:
        factor_ties(trees)
        pull_ties(trees, biased, True)
    outwards(trees, 0, biased, True)


@kernel
def transmitted(trees: Trees, i: int) -> Spatial:
    """Torque [N m] about the tree's origin and force [N] that link i takes from its parent, once accelerations are known.

    The links without mass between the columns hand it on as it is: so it is I a + p of the innermost, as `inwards` left them.
    """
    return needed_by(trees, i, before_joint(trees, 0, i, True))


@kernel
def needed_by(trees: Trees, i: int, a: Spatial) -> Spatial:
    """I a + p of link i: torque and force for an acceleration."""
    body = trees.body
    needed = times(load6(body, i, tree.ROTATION), load9(body, i, tree.COUPLING), load6(body, i, tree.TRANSLATION), a)
    return add6(needed, load6(trees.answer, i, tree.FORCE))
