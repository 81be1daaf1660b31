"""Contacts in two colours: those of one colour in different bands of the world move no body that another band's move.

The world is cut across its longest axis into bands at least as wide as the farthest two bodies of a pair are apart along it, so
that a contact joins a band to itself or to its neighbour. It belongs to the lower of the two. Bands 0, 2, 4, ... are one
colour, and 1, 3, 5, ... the other: the contacts of band i move bodies of the bands i and i + 1 alone. So a sweep goes through
all bands of one colour at once, on as many threads as there are, and then through those of the other; in which order the bands
of a colour come, nobody can see.

Pairs are sorted before contacts are made of them, so that the contacts of a band stand in neighbouring rows.

Source: Saad, Iterative Methods for Sparse Linear Systems, 2003, section 12.4 (multicolouring); Fratarcangeli, Tibaldo,
Pellacini, Vivace: a practical Gauss-Seidel method for stable soft body dynamics, 2016 (constraints by colours).
"""

import math

import numpy as np

from plumbline.engine.compile.jit import entry, kernel
from plumbline.engine.maths.rows import Floats, Ints, load3
from plumbline.engine.maths.vec import sub
from plumbline.engine.memory import arena as at
from plumbline.engine.memory.carve import floats_of, ints_of


@kernel
def band_of(state: Floats, kind: Ints, banding: Floats, a: int, b: int) -> int:
    """The band of a pair of bodies, those of one colour numbered after each other.

    A body that contacts do not move is where the other is.
    """
    axis = at.P + int(banding[0, at.BAND_AXIS])
    x, y = state[a if kind[a, at.MOTION] == at.DYNAMIC else b, axis], state[b if kind[b, at.MOTION] == at.DYNAMIC else a, axis]
    band = max(
        0, min(int((min(x, y) - banding[0, at.BAND_START]) / banding[0, at.BAND_WIDTH]), int(banding[0, at.BAND_COUNT]) - 1)
    )
    return int((band % at.COLOURS) * at.MOST_BANDS + band // at.COLOURS)


@kernel
def cut_world(state: Floats, kind: Ints, owner: Ints, pair: Ints, n: int, banding: Floats) -> None:
    """Choose the axis along which most bands fit, for n pairs of shapes. Args: owner: SHAPE_KIND."""
    low, high, apart = (math.inf, math.inf, math.inf), (-math.inf, -math.inf, -math.inf), (0.0, 0.0, 0.0)
    for p in range(n):
        a, b = owner[pair[p, 0], at.OWNER], owner[pair[p, 1], at.OWNER]
        one = load3(state, a if kind[a, at.MOTION] == at.DYNAMIC else b, at.P)
        two = load3(state, b if kind[b, at.MOTION] == at.DYNAMIC else a, at.P)
        low = (min(low[0], one[0], two[0]), min(low[1], one[1], two[1]), min(low[2], one[2], two[2]))
        high = (max(high[0], one[0], two[0]), max(high[1], one[1], two[1]), max(high[2], one[2], two[2]))
        way = sub(one, two)
        apart = (max(apart[0], abs(way[0])), max(apart[1], abs(way[1])), max(apart[2], abs(way[2])))
    banding[0, at.BAND_AXIS], banding[0, at.BAND_COUNT], banding[0, at.BAND_START] = 0.0, 1.0, 0.0
    banding[0, at.BAND_WIDTH] = math.inf
    for axis in range(3):
        extent = high[axis] - low[axis]
        # A little wider, so that rounding puts no two bodies of a pair two bands apart.
        fit = 1.0
        if extent > 0.0:
            fit = min(extent / (apart[axis] * (1.0 + 1e-9) + 1e-9 * extent), float(at.COLOURS * at.MOST_BANDS))
        if math.floor(fit) > banding[0, at.BAND_COUNT]:
            banding[0, at.BAND_AXIS], banding[0, at.BAND_COUNT], banding[0, at.BAND_START] = axis, math.floor(fit), low[axis]
            banding[0, at.BAND_WIDTH] = extent / math.floor(fit)


@entry
def sort_pairs(floats: Floats, ints: Ints) -> None:
    """Sort the pairs of the coming step by their bands, those of a band as they were found (counting sort)."""
    state, banding = floats_of(floats, ints, at.STATE), floats_of(floats, ints, at.BANDING)
    kind, owner, pair = ints_of(ints, at.BODY_KIND), ints_of(ints, at.SHAPE_KIND), ints_of(ints, at.PAIR)
    table, n = ints_of(ints, at.COLOURED), ints_of(ints, at.COUNT)[0, at.PAIRS]
    cut_world(state, kind, owner, pair, n, banding)
    start = np.zeros(at.COLOURS * at.MOST_BANDS + 1, np.int64)
    for p in range(n):
        band = band_of(state, kind, banding, owner[pair[p, 0], at.OWNER], owner[pair[p, 1], at.OWNER])
        table[p, at.BAND], table[p, at.UNSORTED], table[p, at.UNSORTED + 1] = band, pair[p, 0], pair[p, 1]
        start[band + 1] += 1
    for k in range(at.COLOURS * at.MOST_BANDS):
        start[k + 1] += start[k]
    for p in range(n):
        band = table[p, at.BAND]
        pair[start[band], 0], pair[start[band], 1] = table[p, at.UNSORTED], table[p, at.UNSORTED + 1]
        start[band] += 1


@kernel
def mark_bands(floats: Floats, ints: Ints, key: Ints, first: int) -> None:
    """Note where the contacts of each band begin. Args: first: the column of `key` with body A, beside that with body B.

    Contacts that are kept from an earlier step, since all bodies are still, stand as they were sorted then: where they are not
    in order now, what was noted then holds.
    """
    state, banding, kind = floats_of(floats, ints, at.STATE), floats_of(floats, ints, at.BANDING), ints_of(ints, at.BODY_KIND)
    table, bands, n, last = ints_of(ints, at.COLOURED), ints_of(ints, at.BANDS), ints_of(ints, at.COUNT)[0, at.MANIFOLDS], 0
    for m in range(n):
        table[m, at.BAND] = band_of(state, kind, banding, key[m, first], key[m, first + 1])
        if table[m, at.BAND] < last:
            return
        last = table[m, at.BAND]
    row = 0
    for k in range(bands.shape[0]):
        while row < n and table[row, at.BAND] < k:
            row += 1
        bands[k, at.FIRST_IN_BAND] = row


@kernel
def cut(bands: Ints, colour: int, lane: int, lanes: int) -> int:
    """The row where the bands of a lane begin, so that each has about as many contacts as the next."""
    low, end = colour * at.MOST_BANDS, (colour + 1) * at.MOST_BANDS
    first, last = bands[low, at.FIRST_IN_BAND], bands[end, at.FIRST_IN_BAND]
    if lane == lanes:
        return int(last)
    while low < end and (bands[low, at.FIRST_IN_BAND] - first) * lanes < lane * (last - first):
        low += 1
    return int(bands[low, at.FIRST_IN_BAND])


@kernel
def leave_as_found(floats: Floats, ints: Ints) -> None:
    """Contacts have no colours."""


@kernel
def mark_touches(floats: Floats, ints: Ints) -> None:
    """Note the bands of a world of spheres."""
    mark_bands(floats, ints, ints_of(ints, at.TOUCH_KEY), at.K_BODY_A)


@kernel
def mark_manifolds(floats: Floats, ints: Ints) -> None:
    """Note the bands of any world."""
    mark_bands(floats, ints, ints_of(ints, at.MANIFOLD_KEY), at.BODY_A)
