"""The tiles of rays shared among threads: each answers for itself, so that the answers are those of one thread, bit for bit."""

from numba import prange

from plumbline.engine.compile.jit import parallel_entry
from plumbline.engine.maths.rows import Floats, Ints
from plumbline.engine.rays.hits import Hits
from plumbline.engine.rays.tiles import cast_tile_range
from plumbline.engine.rays.tiling import Bundle, Tiling, tiling_of

SHARE = 32
"""Tiles that a thread takes at once: enough to spread the cost of posing the shapes."""


@parallel_entry
def cast_tiles_parallel(floats: Floats, ints: Ints, origins: Floats, directions: Floats, max_range: float, hits: Hits) -> bool:
    """As `cast_tiles`."""
    row, wide, tiles = tiling_of(directions)
    bad = 0
    for share in prange((tiles + SHARE - 1) // SHARE):
        first, last = share * SHARE, min(share * SHARE + SHARE, tiles)
        bundle, tiling = Bundle(origins, directions, max_range), Tiling(row, wide, tiles)
        done = cast_tile_range(floats, ints, bundle, tiling, first, last, hits)
        bad += 0 if done else 1
    return bad == 0
