"""The tiles of rays shared among threads: each answers for itself, so that the answers are those of one thread, bit for bit."""

from numba import prange

from engine.compile.jit import parallel_entry
from engine.maths.vec import Floats, Ints
from engine.rays.tiles import cast_tile_range, layout

__all__ = ["cast_tiles_parallel"]

SHARE = 32
"""Tiles that a thread takes at once: enough to spread the cost of posing the shapes."""


@parallel_entry
def cast_tiles_parallel(
    floats: Floats, ints: Ints, origins: Floats, directions: Floats, max_range: float,
    distance: Floats, body: Ints, part: Ints, normal: Floats,
) -> bool:  # fmt: skip
    """As `cast_tiles`."""
    row, wide, tiles = layout(directions)
    bad = 0
    for share in prange((tiles + SHARE - 1) // SHARE):
        first, last = share * SHARE, min(share * SHARE + SHARE, tiles)
        done = cast_tile_range(
            floats, ints, origins, directions, row, wide, first, last, max_range, distance, body, part, normal
        )  # fmt: skip
        bad += 0 if done else 1
    return bad == 0
