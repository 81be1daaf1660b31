"""Write one contact point of a manifold."""

from engine.compile.jit import kernel
from engine.maths.vec import Floats, Ints, Vec, store3
from engine.memory.arena import FIRST_GAP, PLACE

__all__ = ["put_point"]


@kernel
def put_point(point: Floats, point_key: Ints, at: int, place: Vec, gap: float, feature: int) -> None:
    """Write a point.

    Args: place [m] in W, midway between the surfaces; gap [m], negative in penetration; feature: the same number for the same
    corners and edges in the next step.
    """
    store3(point, at, PLACE, place)
    point[at, FIRST_GAP] = gap
    point_key[at, 0] = feature
