"""Rays as a caller gives them: checked, and cast on all shapes but polyhedra."""

from collections.abc import Callable
from typing import Any

import numpy as np

from plumbline.engine.describe.check import finite
from plumbline.engine.maths.arrays import norm
from plumbline.engine.maths.types import Floats, Ints
from plumbline.engine.rays.hits import Hits, room_for


def as_rays(origins: Any, directions: Any) -> tuple[Floats, Floats]:
    """Origins (r, 3) or (1, 3) and directions (r, 3) as compiled code takes them. Raises: ValueError for other shapes."""
    # Read-only arrays are another type to the compiler, which would compile everything once more for them.
    d, o = (np.require(rays, float, ("C", "W")) for rays in (directions, origins))
    o = np.atleast_2d(o)
    if d.ndim != 2 or d.shape[1] != 3 or o.shape not in (d.shape, (1, 3)):
        raise ValueError(f"rays: origins {np.shape(origins)} and directions {d.shape}, expected (r, 3) and (r, 3), or (3,)")
    return o, d


def cast_on_shapes(floats: Floats, ints: Ints, o: Floats, d: Floats, max_range: float, threads: int) -> Hits:
    """The first hits within max_range [m] of rays with origins o and directions d. Raises: ValueError naming what is wrong."""
    hits = room_for(len(d))
    if not choose_tiles(threads)(floats, ints, o, d, max_range, hits):
        check_rays(o, d)
    return hits


def check_rays(origins: Floats, directions: Floats) -> None:
    """Raises: ValueError naming what is wrong with rays."""
    finite("rays", "origins", origins, origins.shape, "m")
    finite("rays", "directions", directions, directions.shape, "1")
    length = norm(directions)
    wrong = (length < 1e-12) | (length == np.inf)
    if wrong.any():
        raise ValueError(
            f"rays: direction {int(wrong.argmax())} has length {length[wrong.argmax()]:g}, expected 1e-12 to 1e150"
        )


def choose_tiles(threads: int) -> Callable[..., bool]:
    """The compiled cast for so many threads."""
    if threads == 1:
        from plumbline.engine.rays.tiles import cast_tiles

        return cast_tiles
    import numba

    from plumbline.engine.compile.jit import most_threads
    from plumbline.engine.rays.tiles_parallel import cast_tiles_parallel

    numba.set_num_threads(min(threads, most_threads()))
    return cast_tiles_parallel
