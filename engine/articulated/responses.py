"""What impulses on touched links do to the touched links of their tree: the blocks of G, by unit impulses through the tree.

    inwards:   u_k = S_k . f,  f <- f - U_k u_k / D_k                  from the struck link to its root
    G_ij = sum of u_k(i) u_k(j)^T / D_k                                over the columns that both i and j hang on
    G_ij <- G_ij - z_i z_j^T,   L z_i = C H^-1 J_i^T                   L L^T = C H^-1 C^T of the ties (`ties`)

with the articulated inertia that the last solve has left: what is implicit along a column is in D, and a column whose rate is
prescribed hands both on. Six unit impulses go together. The articulated-body algorithm factors the inverse of the inertia of
all columns as W^T D^-1 W with u = W f, so that nothing has to be handed outwards again.

Source: Featherstone, Rigid Body Dynamics Algorithms, 2008, sections 7.3 and 8.5 (impulse response); Rodriguez, Jain,
Kreutz-Delgado, A spatial operator algebra for manipulator modeling and control, Int. J. Robotics Research 10, 1991 (factors).
"""

import math

from plumbline.engine.articulated import tables as tree
from plumbline.engine.articulated.tables import Tables
from plumbline.engine.articulated.touched import BEGIN, BODY, END, FIRST_BLOCK, FIRST_TAKEN, LINK, NOWHERE, Touched
from plumbline.engine.compile.jit import kernel
from plumbline.engine.maths.rows import load3, load6
from plumbline.engine.maths.vec import add, cross
from plumbline.engine.memory import arena as at
from plumbline.engine.memory.tables import Bodies


@kernel
def take_in(tables: Tables, touched: Touched, place: int) -> None:
    """Write what unit impulses on the link of a place leave along the columns from there to the root."""
    column, kind, taken, force = tables.column, tables.kind, touched.taken, touched.force
    x = touched.kind[place, LINK]
    r, row = load3(tables.motion, x, tree.PLACE), touched.kind[place, FIRST_TAKEN] + touched.depth[x]
    for c in range(36):
        force[c] = 0.0
    for c in range(3):
        force[6 * (3 + c) + c] = force[6 * c + 3 + c] = 1.0
    force[1], force[2], force[6] = -r[2], r[1], r[2]
    force[8], force[12], force[13] = -r[0], -r[1], r[0]
    while x >= 0:
        for k in range(kind[x, tree.FIRST] + kind[x, tree.COLUMNS] - 1, kind[x, tree.FIRST] - 1, -1):
            row -= 1
            free = column[k, tree.ADDED] != math.inf
            share = math.sqrt(column[k, tree.INVERSE]) if free else 0.0
            for c in range(6):
                left = 0.0
                for d in range(6):
                    left += column[k, tree.AXIS_W + d] * force[6 * d + c]
                taken[row, c] = share * left
            if free:
                for d in range(6):
                    pulled = column[k, tree.PULL + d] * share
                    for c in range(6):
                        force[6 * d + c] -= pulled * taken[row, c]
        x = kind[x, tree.PARENT]


@kernel
def give_up_to_ties(tables: Tables, touched: Touched, place: int) -> None:
    """Write what unit impulses on the link of a place leave to ties: what units of these do to it, by the factor they have."""
    taken, low, n = touched.taken, tables.tie_factor, tables.tie.shape[0]
    x = touched.kind[place, LINK]
    r, row = load3(tables.motion, x, tree.PLACE), touched.kind[place, FIRST_TAKEN] + touched.depth[x]
    for t in range(n):
        answer = t * tables.kind.shape[0] + x
        w = load3(tables.tie_link, answer, tree.TIE_ACCELERATION)
        v = add(load3(tables.tie_link, answer, tree.TIE_ACCELERATION + 3), cross(w, r))
        for c in range(3):
            taken[row + t, c], taken[row + t, 3 + c] = v[c], w[c]
        for c in range(6):
            for s in range(t):
                taken[row + t, c] -= low[n * t + s, 0] * taken[row + s, c]
            taken[row + t, c] = 0.0 if tables.tie[t, tree.SLACK] == 1.0 else taken[row + t, c] / low[n * t + t, 0]


@kernel
def shared_columns(tables: Tables, touched: Touched, one: int, other: int) -> int:
    """How many columns the links of two places of a tree hang on both."""
    a, b = touched.kind[one, LINK], touched.kind[other, LINK]
    while a != b:
        # Those of unlike trees end at -1, on nothing. A link comes behind its parent.
        if a > b:
            a = tables.kind[a, tree.PARENT]
        else:
            b = tables.kind[b, tree.PARENT]
    return int(touched.depth[a]) if a >= 0 else 0


@kernel
def put_block(tables: Tables, touched: Touched, place: int, other: int) -> None:
    """Write the block of a place and another of its tree, and turned as that of the other and this."""
    kind, block, taken = touched.kind, touched.block, touched.taken
    there = kind[place, FIRST_BLOCK] + other - kind[place, BEGIN]
    back = kind[other, FIRST_BLOCK] + place - kind[place, BEGIN]
    for n in range(36):
        block[there, n] = 0.0
    for m in range(shared_columns(tables, touched, place, other)):
        struck, moved = kind[place, FIRST_TAKEN] + m, kind[other, FIRST_TAKEN] + m
        for c in range(6):
            left = taken[struck, c]
            for d in range(6):
                block[there, 6 * c + d] += left * taken[moved, d]
    for t in range(tables.tie.shape[0]):
        struck = kind[place, FIRST_TAKEN] + touched.depth[kind[place, LINK]] + t
        moved = kind[other, FIRST_TAKEN] + touched.depth[kind[other, LINK]] + t
        for c in range(6):
            for d in range(6):
                block[there, 6 * c + d] -= taken[struck, c] * taken[moved, d]
    if there != back:
        for c in range(6):
            for d in range(6):
                block[back, 6 * d + c] = block[there, 6 * c + d]


@kernel
def write_responses(tables: Tables, touched: Touched) -> None:
    """Write the blocks of G of all links, with the articulated inertia of the last solve."""
    kind = touched.kind
    for k in range(kind.shape[0]):
        if kind[k, LINK] != NOWHERE:
            take_in(tables, touched, k)
            give_up_to_ties(tables, touched, k)
    for k in range(kind.shape[0]):
        if kind[k, LINK] != NOWHERE:
            for other in range(k, kind[k, END]):
                put_block(tables, touched, k, other)


@kernel
def write_free_responses(bodies: Bodies, touched: Touched) -> None:
    """Write the blocks of G of the bodies that no tree has, as they stand."""
    kind, block = touched.kind, touched.block
    for k in range(kind.shape[0]):
        if kind[k, LINK] != NOWHERE:
            continue
        b, n = kind[k, BODY], kind[k, FIRST_BLOCK]
        inverse = load6(bodies.turned, b, 0)
        block[n, 0] = block[n, 7] = block[n, 14] = bodies.body[b, at.INV_MASS]
        block[n, 21], block[n, 28], block[n, 35] = inverse[0], inverse[1], inverse[2]
        block[n, 22] = block[n, 27] = inverse[3]
        block[n, 23] = block[n, 33] = inverse[4]
        block[n, 29] = block[n, 34] = inverse[5]
