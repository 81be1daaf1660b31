"""What contacts move: the links and free bodies that they touch, what an impulse on one does to the others, and room for that.

Each of them has a place, those of one tree side by side, a free body by itself; trees that ties hold together, and what is
between them, count as one. Impulses are six numbers, force [N s] and
moment [N m s] about the centre of mass, in W; what they change are v_WB and w_WB.

    (v, w)_i <- (v, w)_i + G_ij (f, t)_j        for every place i of the tree of j

G is the inverse of the operational-space inertia of all places together.

Source: Featherstone, Rigid Body Dynamics Algorithms, 2008, sections 8.4 (impulses) and 8.5 (inverse inertia of loops); Wensing,
Featherstone, Orin, A reduced-order recursive algorithm for the computation of the operational-space inertia matrix, ICRA 2012.
"""

from typing import Final, NamedTuple

import numpy as np

from plumbline.engine.articulated import tables as tree
from plumbline.engine.articulated.tables import Tables
from plumbline.engine.compile.jit import kernel
from plumbline.engine.maths.rows import Floats, Ints, Vec, load3
from plumbline.engine.maths.vec import axpy, scale
from plumbline.engine.memory import arena as at
from plumbline.engine.memory.tables import Bodies

# Places.
BODY: Final = 0
LINK: Final = 1  # NOWHERE for a body of no tree
BEGIN: Final = 2  # first place of its tree
END: Final = 3  # behind its last
FIRST_BLOCK: Final = 4  # of its blocks of G, one for each place of its tree
FIRST_TAKEN: Final = 5  # of its rows of `taken`: for each column from the root on to its link, then for each tie

NOWHERE: Final = -1


class Touched(NamedTuple):
    """The places, and room to work in.

    Terms: place: of each body, NOWHERE for one that no contact moves; kind: of each place; block: G, 36 numbers for two places,
    motion by force, the six motions of a force together; given: impulse on each place since it was last set to zero; depth: of
    each link, columns from the root to it, its own with them; taken: what unit impulses on a place leave along each of these,
    over the root of the inertia along it, and to each tie; force: room for six forces on a link, moment first, those of a
    number together.
    """

    place: Ints
    kind: Ints
    block: Floats
    given: Floats
    depth: Ints
    taken: Floats
    force: Floats


@kernel
def find_touched(tables: Tables, bodies: Bodies) -> Touched:
    """The places of all dynamic bodies that contacts touch, links first, in their order."""
    links, n = tables.kind.shape[0], 0
    place, depth = np.empty(bodies.state.shape[0], np.int64), np.empty(links, np.int64)
    for b in range(bodies.state.shape[0]):
        place[b] = NOWHERE
        if bodies.kind[b, at.TOUCHED] == 1 and bodies.kind[b, at.MOTION] == at.DYNAMIC:
            n += 1
    kind, slot, blocks, rows, begin, root = np.empty((n, 6), np.int64), 0, 0, 0, 0, NOWHERE
    for i in range(links):
        b, parent = tables.kind[i, tree.ROW], tables.kind[i, tree.PARENT]
        depth[i] = tables.kind[i, tree.COLUMNS] + (depth[parent] if parent >= 0 else 0)
        if bodies.kind[b, at.TOUCHED] == 0:
            continue
        if tables.kind[i, tree.CLUSTER] != root:
            root, begin = tables.kind[i, tree.CLUSTER], slot
        place[b] = slot
        kind[slot, BODY], kind[slot, LINK], kind[slot, BEGIN], kind[slot, FIRST_TAKEN] = b, i, begin, rows
        rows += depth[i] + tables.tie.shape[0]
        slot += 1
        for k in range(begin, slot):
            kind[k, END] = slot
    for m in range(tables.other.shape[0]):
        b = tables.other[m, 0]
        if bodies.kind[b, at.TOUCHED] == 1 and bodies.kind[b, at.MOTION] == at.DYNAMIC:
            place[b] = slot
            kind[slot, BODY], kind[slot, LINK], kind[slot, BEGIN], kind[slot, END] = b, NOWHERE, slot, slot + 1
            kind[slot, FIRST_TAKEN] = rows
            slot += 1
    for k in range(n):
        kind[k, FIRST_BLOCK] = blocks
        blocks += kind[k, END] - kind[k, BEGIN]
    block, given = np.empty((blocks, 36)), np.empty((n, 6))
    clear(block)
    clear(given)
    return Touched(place, kind, block, given, depth, np.empty((rows, 6)), np.empty((1, 36))[0])


@kernel
def clear(table: Floats) -> None:
    """Let all numbers be zero."""
    for i in range(table.shape[0]):
        for j in range(table.shape[1]):
            table[i, j] = 0.0


@kernel
def give(touched: Touched, state: Floats, k: int, f: Vec, t: Vec) -> None:
    """Give place k an impulse, which all places of its tree answer."""
    kind, block, given = touched.kind, touched.block, touched.given
    for c in range(3):
        given[k, c] += f[c]
        given[k, 3 + c] += t[c]
    first = kind[k, FIRST_BLOCK]
    for i in range(kind[k, BEGIN], kind[k, END]):
        b = kind[i, BODY]
        for r in range(6):
            total = block[first, r] * f[0] + block[first, 6 + r] * f[1] + block[first, 12 + r] * f[2]
            total += block[first, 18 + r] * t[0] + block[first, 24 + r] * t[1] + block[first, 30 + r] * t[2]
            state[b, at.V + r] += total
        first += 1


@kernel
def change_of(touched: Touched, i: int, k: int, f: Vec, t: Vec) -> tuple[Vec, Vec]:
    """What an impulse on place k changes of the velocities of place i; nothing where either is NOWHERE."""
    kind, block = touched.kind, touched.block
    if i == NOWHERE or k == NOWHERE or not kind[k, BEGIN] <= i < kind[k, END]:
        return (0.0, 0.0, 0.0), (0.0, 0.0, 0.0)
    n = kind[k, FIRST_BLOCK] + i - kind[k, BEGIN]
    v, w = scale(f[0], load3(block, n, 0)), scale(f[0], load3(block, n, 3))
    v, w = axpy(f[1], load3(block, n, 6), v), axpy(f[1], load3(block, n, 9), w)
    v, w = axpy(f[2], load3(block, n, 12), v), axpy(f[2], load3(block, n, 15), w)
    v, w = axpy(t[0], load3(block, n, 18), v), axpy(t[0], load3(block, n, 21), w)
    v, w = axpy(t[1], load3(block, n, 24), v), axpy(t[1], load3(block, n, 27), w)
    return axpy(t[2], load3(block, n, 30), v), axpy(t[2], load3(block, n, 33), w)
