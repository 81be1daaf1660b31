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
from plumbline.engine.articulated.motion import change_along
from plumbline.engine.articulated.tables import Tables
from plumbline.engine.articulated.ties import factor_ties, pull_ties, pulled_beside
from plumbline.engine.compile.jit import kernel
from plumbline.engine.maths.floats import fma
from plumbline.engine.maths.rows import Floats, Mat, Sym, Vec, load3, load6, load9, store3, store6, store9
from plumbline.engine.maths.vec import add, axpy, dot, mat_vec, sym_vec, tmat_vec

STILL: Vec = (0.0, 0.0, 0.0)


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
def add3(a: Floats, i: int, c: int, v: Vec) -> None:
    """Add a vector to row i from column c on."""
    store3(a, i, c, add(load3(a, i, c), v))


@kernel
def inwards(tables: Tables, biased: bool) -> None:
    """Write the articulated inertia and force of every link, and pull, inverse and what is left of every column.

    Args: biased: whether links have a bias; it is zero otherwise.
    """
    body, column, kind = tables.body, tables.column, tables.kind
    for i in range(kind.shape[0] - 1, -1, -1):
        first, parent = kind[i, tree.FIRST], kind[i, tree.PARENT]
        rotation, translation = load6(body, i, tree.ROTATION), load6(body, i, tree.TRANSLATION)
        coupling = load9(body, i, tree.COUPLING)
        torque, force = load3(body, i, tree.FORCE), load3(body, i, tree.FORCE + 3)
        for k in range(first + kind[i, tree.COLUMNS] - 1, first - 1, -1):
            turning, sliding = load3(column, k, tree.AXIS_W), load3(column, k, tree.AXIS_W + 3)
            pull_w = add(sym_vec(rotation, turning), mat_vec(coupling, sliding))
            pull_v = add(tmat_vec(coupling, turning), sym_vec(translation, sliding))
            store3(column, k, tree.PULL, pull_w)
            store3(column, k, tree.PULL + 3, pull_v)
            left = column[k, tree.PUSH] - dot(turning, torque) - dot(sliding, force)
            if column[k, tree.ADDED] == math.inf:
                share = column[k, tree.CHANGE]
            else:
                inverse = 1.0 / (dot(turning, pull_w) + dot(sliding, pull_v) + column[k, tree.ADDED])
                rotation = sym_less(rotation, pull_w, inverse)
                translation = sym_less(translation, pull_v, inverse)
                coupling = mat_less(coupling, pull_w, pull_v, inverse)
                share = inverse * left
                column[k, tree.INVERSE], column[k, tree.LEFT] = inverse, left
            torque, force = axpy(share, pull_w, torque), axpy(share, pull_v, force)
        store6(body, i, tree.ROTATION, rotation)
        store6(body, i, tree.TRANSLATION, translation)
        store9(body, i, tree.COUPLING, coupling)
        store3(body, i, tree.FORCE, torque)
        store3(body, i, tree.FORCE + 3, force)
        if parent < 0:
            continue
        if biased:
            bias_w, bias_v = load3(tables.motion, i, tree.BIAS), load3(tables.motion, i, tree.BIAS + 3)
            torque = add(torque, add(sym_vec(rotation, bias_w), mat_vec(coupling, bias_v)))
            force = add(force, add(tmat_vec(coupling, bias_w), sym_vec(translation, bias_v)))
        add3(body, parent, tree.ROTATION, (rotation[0], rotation[1], rotation[2]))
        add3(body, parent, tree.ROTATION + 3, (rotation[3], rotation[4], rotation[5]))
        add3(body, parent, tree.TRANSLATION, (translation[0], translation[1], translation[2]))
        add3(body, parent, tree.TRANSLATION + 3, (translation[3], translation[4], translation[5]))
        add3(body, parent, tree.COUPLING, (coupling[0], coupling[1], coupling[2]))
        add3(body, parent, tree.COUPLING + 3, (coupling[3], coupling[4], coupling[5]))
        add3(body, parent, tree.COUPLING + 6, (coupling[6], coupling[7], coupling[8]))
        add3(body, parent, tree.FORCE, torque)
        add3(body, parent, tree.FORCE + 3, force)


@kernel
def before_joint(tables: Tables, i: int, biased: bool) -> tuple[Vec, Vec]:
    """The spatial acceleration of link i but for that along its own columns. Args: as `inwards`."""
    motion, parent, a_w, a_v = tables.motion, tables.kind[i, tree.PARENT], STILL, STILL
    if biased:
        a_w, a_v = load3(motion, i, tree.BIAS), load3(motion, i, tree.BIAS + 3)
    if parent >= 0:
        a_w = add(a_w, load3(motion, parent, tree.ACCELERATION))
        a_v = add(a_v, load3(motion, parent, tree.ACCELERATION + 3))
    return a_w, a_v


@kernel
def outwards(tables: Tables, biased: bool) -> None:
    """Write the acceleration of every link and the change of every column's rate. Args: as `inwards`."""
    column, kind = tables.column, tables.kind
    for i in range(kind.shape[0]):
        first = kind[i, tree.FIRST]
        a_w, a_v = before_joint(tables, i, biased)
        for k in range(first, first + kind[i, tree.COLUMNS]):
            change, a_w, a_v = change_along(column, k, column[k, tree.LEFT], column[k, tree.CHANGE], a_w, a_v)
            column[k, tree.CHANGE] = change
        store3(tables.motion, i, tree.ACCELERATION, a_w)
        store3(tables.motion, i, tree.ACCELERATION + 3, a_v)


@kernel
def accelerations(tables: Tables, biased: bool) -> None:
    """Write the change of every column's rate, from inertia and force of every link, which are used up. Args: as `inwards`."""
    inwards(tables, biased)
    if tables.tie.shape[0] > 0:
        factor_ties(tables)
        pull_ties(tables, True)
    outwards(tables, biased)


@kernel
def forces_inwards(tables: Tables) -> None:
    """Write what forces of links alone leave along every column, with pull and inverse as `inwards` left them."""
    body, column, kind = tables.body, tables.column, tables.kind
    for i in range(kind.shape[0] - 1, -1, -1):
        first, parent = kind[i, tree.FIRST], kind[i, tree.PARENT]
        torque, force = load3(body, i, tree.FORCE), load3(body, i, tree.FORCE + 3)
        for k in range(first + kind[i, tree.COLUMNS] - 1, first - 1, -1):
            if column[k, tree.ADDED] == math.inf:
                continue
            left = -dot(load3(column, k, tree.AXIS_W), torque) - dot(load3(column, k, tree.AXIS_W + 3), force)
            column[k, tree.LEFT] = left
            share = column[k, tree.INVERSE] * left
            torque = axpy(share, load3(column, k, tree.PULL), torque)
            force = axpy(share, load3(column, k, tree.PULL + 3), force)
        store3(body, i, tree.FORCE, torque)
        store3(body, i, tree.FORCE + 3, force)
        if parent >= 0:
            add3(body, parent, tree.FORCE, torque)
            add3(body, parent, tree.FORCE + 3, force)


@kernel
def answer_forces(tables: Tables, h: float) -> tuple[float, float]:
    """Change rates, and velocities of links, by what forces of links do over h; nothing pushes along columns, and links have no
    bias.

    Rates that are prescribed stay, and the force that keeps them is counted. Returns: the largest change, and the largest rate.
    """
    forces_inwards(tables)
    if tables.tie.shape[0] > 0:
        pull_ties(tables, False)
    motion, column, kind = tables.motion, tables.column, tables.kind
    largest, fastest = 0.0, 0.0
    for i in range(kind.shape[0]):
        a_w, a_v = before_joint(tables, i, False)
        for k in range(kind[i, tree.FIRST], kind[i, tree.FIRST] + kind[i, tree.COLUMNS]):
            if column[k, tree.ADDED] != math.inf:
                change, a_w, a_v = change_along(column, k, column[k, tree.LEFT], 0.0, a_w, a_v)
                column[k, tree.RATE] += h * change
                largest = max(largest, abs(h * change))
            else:
                column[k, tree.LEFT] += dot(load3(column, k, tree.PULL), a_w) + dot(load3(column, k, tree.PULL + 3), a_v)
                column[k, tree.LEFT] += dot(load3(column, k, tree.AXIS_W), load3(tables.body, i, tree.FORCE))
                column[k, tree.LEFT] += dot(load3(column, k, tree.AXIS_W + 3), load3(tables.body, i, tree.FORCE + 3))
                column[k, tree.LEFT] -= pulled_beside(tables, k)
            fastest = max(fastest, abs(column[k, tree.RATE]))
        store3(motion, i, tree.ACCELERATION, a_w)
        store3(motion, i, tree.ACCELERATION + 3, a_v)
        store3(motion, i, tree.VELOCITY, axpy(h, a_w, load3(motion, i, tree.VELOCITY)))
        store3(motion, i, tree.VELOCITY + 3, axpy(h, a_v, load3(motion, i, tree.VELOCITY + 3)))
    return largest, fastest


@kernel
def transmitted(tables: Tables, i: int) -> tuple[Vec, Vec]:
    """Torque [N m] about the tree's origin and force [N] that link i takes from its parent, once accelerations are known.

    The links without mass between the columns hand it on as it is: so it is I a + p of the innermost, as `inwards` left them.
    """
    a_w, a_v = before_joint(tables, i, True)
    return needed_by(tables.body, i, a_w, a_v)


@kernel
def needed_by(body: Floats, i: int, a_w: Vec, a_v: Vec) -> tuple[Vec, Vec]:
    """I a + p of link i: torque and force for an acceleration."""
    rotation, coupling = load6(body, i, tree.ROTATION), load9(body, i, tree.COUPLING)
    torque = add(sym_vec(rotation, a_w), mat_vec(coupling, a_v))
    force = add(tmat_vec(coupling, a_w), sym_vec(load6(body, i, tree.TRANSLATION), a_v))
    return add(torque, load3(body, i, tree.FORCE)), add(force, load3(body, i, tree.FORCE + 3))
