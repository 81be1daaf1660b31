"""What impulses on touched links do to the touched links of their tree: the blocks of G, by unit impulses through the tree.

    inwards:   u_k = S_k . f,  f <- f - U_k u_k / D_k                  from the struck link to its root
    outwards:  q'_k = (u_k - U_k . v) / D_k,  v <- v + S_k q'_k        from the root to all touched links, u_k = 0 off that way

with the articulated inertia that the last solve has left: what is implicit along a column is in D, and a column whose rate is
prescribed hands both on. Six unit impulses go together.

Source: Featherstone, Rigid Body Dynamics Algorithms, 2008, sections 7.3 and 8.5 (impulse response); Mirtich, Impulse-based
Dynamic Simulation of Rigid Body Systems, 1996, chapter 4.
"""

import math
from typing import Final

from engine.articulated.tables import ADDED, AXIS_W, COLUMNS, FIRST, INVERSE, PARENT, PLACE, PULL, ROOT, Tables
from engine.articulated.touched import BEGIN, BODY, END, FIRST_BLOCK, LINK, NOWHERE, Touched
from engine.compile.jit import kernel
from engine.maths.vec import Floats, Vec, load3, load6
from engine.memory.arena import INV_MASS
from engine.memory.tables import Bodies

__all__ = ["write_free_responses", "write_responses"]

ON_WAY: Final = 2
"""Plus a place: the mark of the links from its own to the root."""


@kernel
def take_in(tables: Tables, touched: Touched, place: int) -> None:
    """Write what unit impulses on the link of a place leave along the columns from there to the root, and mark that way."""
    column, kind, taken, force = tables.column, tables.kind, touched.taken, touched.moved
    i = touched.kind[place, LINK]
    # The row of a link holds the force on it here: six numbers, moment first, of each unit impulse together.
    r = load3(tables.motion, i, PLACE)
    for c in range(36):
        force[i, c] = 0.0
    for c in range(3):
        force[i, 6 * (3 + c) + c] = force[i, 6 * c + 3 + c] = 1.0
    force[i, 1], force[i, 2], force[i, 6] = -r[2], r[1], r[2]
    force[i, 8], force[i, 12], force[i, 13] = -r[0], -r[1], r[0]
    x = i
    while x >= 0:
        for k in range(kind[x, FIRST] + kind[x, COLUMNS] - 1, kind[x, FIRST] - 1, -1):
            for c in range(6):
                left = 0.0
                for d in range(6):
                    left += column[k, AXIS_W + d] * force[i, 6 * d + c]
                taken[k, c] = left
            if column[k, ADDED] != math.inf:
                for d in range(6):
                    share = column[k, PULL + d] * column[k, INVERSE]
                    for c in range(6):
                        force[i, 6 * d + c] -= share * taken[k, c]
        touched.mark[x] = ON_WAY + place
        x = kind[x, PARENT]


@kernel
def put_block(block: Floats, there: int, back: int, moved: Floats, x: int, r: Vec) -> None:
    """Write the motions of link x, whose centre of mass is at r, as block `there` of the struck place, and turned as `back`."""
    for c in range(6):
        w, y, z = moved[x, c], moved[x, 6 + c], moved[x, 12 + c]
        block[there, 6 * c] = moved[x, 18 + c] + y * r[2] - z * r[1]
        block[there, 6 * c + 1] = moved[x, 24 + c] + z * r[0] - w * r[2]
        block[there, 6 * c + 2] = moved[x, 30 + c] + w * r[1] - y * r[0]
        block[there, 6 * c + 3], block[there, 6 * c + 4], block[there, 6 * c + 5] = w, y, z
    if there != back:
        for c in range(6):
            for d in range(6):
                block[back, 6 * d + c] = block[there, 6 * c + d]


@kernel
def hand_out(tables: Tables, touched: Touched, place: int) -> None:
    """Write the blocks of a place, and of those behind it in its tree: what its unit impulses, taken in before, do to them."""
    column, kind, taken, moved = tables.column, tables.kind, touched.taken, touched.moved
    first, end = touched.kind[place, BEGIN], touched.kind[place, END]
    struck, last = touched.kind[place, LINK], touched.kind[end - 1, LINK]
    for x in range(kind[struck, ROOT], last + 1):
        if touched.mark[x] == 0:
            continue
        parent = kind[x, PARENT]
        for c in range(36):
            moved[x, c] = moved[parent, c] if parent >= 0 else 0.0
        on_way = touched.mark[x] == ON_WAY + place
        for k in range(kind[x, FIRST], kind[x, FIRST] + kind[x, COLUMNS]):
            if column[k, ADDED] == math.inf:
                continue
            for c in range(6):
                rate = taken[k, c] if on_way else 0.0
                for d in range(6):
                    rate -= column[k, PULL + d] * moved[x, 6 * d + c]
                rate *= column[k, INVERSE]
                for d in range(6):
                    moved[x, 6 * d + c] += column[k, AXIS_W + d] * rate
    for other in range(place, end):
        x = touched.kind[other, LINK]
        there = touched.kind[place, FIRST_BLOCK] + other - first
        back = touched.kind[other, FIRST_BLOCK] + place - first
        put_block(touched.block, there, back, moved, x, load3(tables.motion, x, PLACE))


@kernel
def write_responses(tables: Tables, touched: Touched) -> None:
    """Write the blocks of G of all links, with the articulated inertia of the last solve."""
    for k in range(touched.kind.shape[0]):
        if touched.kind[k, LINK] != NOWHERE:
            take_in(tables, touched, k)
            hand_out(tables, touched, k)


@kernel
def write_free_responses(bodies: Bodies, touched: Touched) -> None:
    """Write the blocks of G of the bodies that no tree has, as they stand."""
    kind, block = touched.kind, touched.block
    for k in range(kind.shape[0]):
        if kind[k, LINK] != NOWHERE:
            continue
        b, n = kind[k, BODY], kind[k, FIRST_BLOCK]
        inverse = load6(bodies.turned, b, 0)
        block[n, 0] = block[n, 7] = block[n, 14] = bodies.body[b, INV_MASS]
        block[n, 21], block[n, 28], block[n, 35] = inverse[0], inverse[1], inverse[2]
        block[n, 22] = block[n, 27] = inverse[3]
        block[n, 23] = block[n, 33] = inverse[4]
        block[n, 29] = block[n, 34] = inverse[5]
