"""What impulses on touched links and free bodies do to the others of their tree, and the sums that say so before a sweep.

What contacts touch has a place, places of one tree side by side, a free body by itself; trees that ties hold together, and what
is between them, count as one. Impulses are six numbers, force [N s] and moment [N m s] about the centre of mass, in W; they
change v_WB and w_WB.

    (v, w)_i <- (v, w)_i + G_ij (f, t)_j                               for every place i of the tree of j

G, the inverse of the operational-space inertia of all places together, is written by unit impulses through the tree:

    inwards:   u_k = S_k . f,  f <- f - U_k u_k / D_k                  from the struck link to its root
    G_ij = sum of u_k(i) u_k(j)^T / D_k                                over the columns that both i and j hang on
    G_ij <- G_ij - z_i z_j^T,   L z_i = C H^-1 J_i^T                   L L^T = C H^-1 C^T of the ties (`ties`)

with the articulated inertia that the last solve has left: what is implicit along a column is in D, and a column whose rate is
prescribed hands both on. Six unit impulses go together. The articulated-body algorithm factors the inverse of the inertia of
all columns as W^T D^-1 W with u = W f, so that nothing has to be handed outwards again.

Source: Featherstone, Rigid Body Dynamics Algorithms, 2008, sections 7.3, 8.4 (impulses) and 8.5 (inverse inertia of loops);
Wensing, Featherstone, Orin, A reduced-order recursive algorithm for the computation of the operational-space inertia matrix,
ICRA 2012; Rodriguez, Jain, Kreutz-Delgado, A spatial operator algebra for manipulator modeling and control, Int. J. Robotics
Research 10, 1991 (factors).
"""

import math
from typing import Final, NamedTuple

import numpy as np

from plumbline.engine.articulated import tables as tree
from plumbline.engine.articulated.spatial import STILL, turning, velocity_at
from plumbline.engine.articulated.tables import Trees
from plumbline.engine.compile.jit import kernel
from plumbline.engine.maths.rows import Floats, Ints, Vec, load3, load6, store3
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
def find_touched(trees: Trees) -> Touched:
    """The places of all dynamic bodies that contacts touch, links first, in their order."""
    bodies, links, n = trees.bodies, trees.kind.shape[0], 0
    place, depth = np.empty(bodies.state.shape[0], np.int64), np.empty(links, np.int64)
    for b in range(bodies.state.shape[0]):
        place[b] = NOWHERE
        if bodies.kind[b, at.TOUCHED] == 1 and bodies.kind[b, at.MOTION] == at.DYNAMIC:
            n += 1
    kind, slot, blocks, rows, begin, root = np.empty((n, 6), np.int64), 0, 0, 0, 0, NOWHERE
    for i in range(links):
        b, parent = trees.kind[i, tree.ROW], trees.kind[i, tree.PARENT]
        depth[i] = trees.kind[i, tree.COLUMNS] + (depth[parent] if parent >= 0 else 0)
        if bodies.kind[b, at.TOUCHED] == 0:
            continue
        if trees.kind[i, tree.CLUSTER] != root:
            root, begin = trees.kind[i, tree.CLUSTER], slot
        place[b] = slot
        kind[slot, BODY], kind[slot, LINK], kind[slot, BEGIN], kind[slot, FIRST_TAKEN] = b, i, begin, rows
        rows += depth[i] + trees.tie.shape[0]
        slot += 1
        for k in range(begin, slot):
            kind[k, END] = slot
    for m in range(trees.other.shape[0]):
        b = trees.other[m, 0]
        if bodies.kind[b, at.TOUCHED] == 1 and bodies.kind[b, at.MOTION] == at.DYNAMIC:
            place[b] = slot
            kind[slot, BODY], kind[slot, LINK], kind[slot, BEGIN], kind[slot, END] = b, NOWHERE, slot, slot + 1
            kind[slot, FIRST_TAKEN] = rows
            slot += 1
    for k in range(n):
        kind[k, FIRST_BLOCK] = blocks
        blocks += kind[k, END] - kind[k, BEGIN]
    return Touched(place, kind, np.zeros((blocks, 36)), np.zeros((n, 6)), depth, np.empty((rows, 6)), np.empty(36))


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
        return STILL, STILL
    n = kind[k, FIRST_BLOCK] + i - kind[k, BEGIN]
    v, w = scale(f[0], load3(block, n, 0)), scale(f[0], load3(block, n, 3))
    v, w = axpy(f[1], load3(block, n, 6), v), axpy(f[1], load3(block, n, 9), w)
    v, w = axpy(f[2], load3(block, n, 12), v), axpy(f[2], load3(block, n, 15), w)
    v, w = axpy(t[0], load3(block, n, 18), v), axpy(t[0], load3(block, n, 21), w)
    v, w = axpy(t[1], load3(block, n, 24), v), axpy(t[1], load3(block, n, 27), w)
    return axpy(t[2], load3(block, n, 30), v), axpy(t[2], load3(block, n, 33), w)


@kernel
def take_in(trees: Trees, touched: Touched, place: int) -> None:
    """Write what unit impulses on the link of a place leave along the columns from there to the root."""
    column, kind, taken, force = trees.column, trees.kind, touched.taken, touched.force
    x = touched.kind[place, LINK]
    r, row = load3(trees.motion, x, tree.PLACE), touched.kind[place, FIRST_TAKEN] + touched.depth[x]
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
def give_up_to_ties(trees: Trees, touched: Touched, struck: int) -> None:
    """Write what unit impulses on the link of a place leave to ties: what units of these do to it, by the factor they have."""
    taken, low, n = touched.taken, trees.tie_factor, trees.tie.shape[0]
    x = touched.kind[struck, LINK]
    r, row = load3(trees.motion, x, tree.PLACE), touched.kind[struck, FIRST_TAKEN] + touched.depth[x]
    for t in range(n):
        answer = (1 + t) * trees.kind.shape[0] + x
        moved = load6(trees.answer, answer, tree.ACCELERATION)
        store3(taken, row + t, 0, velocity_at(moved, r))
        store3(taken, row + t, 3, turning(moved))
        for c in range(6):
            for s in range(t):
                taken[row + t, c] -= low[n * t + s, 0] * taken[row + s, c]
            taken[row + t, c] = 0.0 if trees.tie[t, tree.SLACK] == 1.0 else taken[row + t, c] / low[n * t + t, 0]


@kernel
def shared_columns(trees: Trees, touched: Touched, one: int, other: int) -> int:
    """How many columns the links of two places of a tree hang on both."""
    a, b = touched.kind[one, LINK], touched.kind[other, LINK]
    while a != b:
        # Those of unlike trees end at -1, on nothing. A link comes behind its parent.
        if a > b:
            a = trees.kind[a, tree.PARENT]
        else:
            b = trees.kind[b, tree.PARENT]
    return int(touched.depth[a]) if a >= 0 else 0


@kernel
def put_block(trees: Trees, touched: Touched, place: int, other: int) -> None:
    """Write the block of a place and another of its tree, and turned as that of the other and this."""
    kind, block, taken = touched.kind, touched.block, touched.taken
    there = kind[place, FIRST_BLOCK] + other - kind[place, BEGIN]
    back = kind[other, FIRST_BLOCK] + place - kind[place, BEGIN]
    for n in range(36):
        block[there, n] = 0.0
    for m in range(shared_columns(trees, touched, place, other)):
        struck, moved = kind[place, FIRST_TAKEN] + m, kind[other, FIRST_TAKEN] + m
        for c in range(6):
            left = taken[struck, c]
            for d in range(6):
                block[there, 6 * c + d] += left * taken[moved, d]
    for t in range(trees.tie.shape[0]):
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
def write_responses(trees: Trees, touched: Touched) -> None:
    """Write the blocks of G of all links, with the articulated inertia of the last solve."""
    kind = touched.kind
    for k in range(kind.shape[0]):
        if kind[k, LINK] != NOWHERE:
            take_in(trees, touched, k)
            give_up_to_ties(trees, touched, k)
    for k in range(kind.shape[0]):
        if kind[k, LINK] != NOWHERE:
            for other in range(k, kind[k, END]):
                put_block(trees, touched, k, other)


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
