"""What rays meet first."""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from plumbline.engine.maths.types import Floats, Ints


class Hits(NamedTuple):
    """First hits of rays: distance (r,) m, inf for a miss; body and shape (r,), -1 for a miss; normal (r, 3) in W, outward."""

    distance: Floats
    body: Ints
    shape: Ints
    normal: Floats


Cast = Callable[[Floats, Floats], Hits]
"""World.cast of origins and directions."""


def room_for(count: int) -> Hits:
    """Hits to be written, in one piece of memory: asked for in several, it would come back from the system anew each time."""
    whole = np.empty(6 * count)
    numbers = whole.view(np.int64)
    normal = whole[3 * count :].reshape(count, 3)
    return Hits(whole[:count], numbers[count : 2 * count], numbers[2 * count : 3 * count], normal)
