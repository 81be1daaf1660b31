"""Where the narrow phase writes: the contact points of a manifold, four rows each, and the polygons they are clipped from."""

from typing import Annotated, NamedTuple

from plumbline.engine.compile.jit import kernel
from plumbline.engine.maths.rows import Floats, Ints, Vec, store3
from plumbline.engine.maths.vec import axpy
from plumbline.engine.memory import arena as at
from plumbline.engine.memory.carve import carved

CORNERS_OF_B = 1 << 24
"""Features of convex pairs from here belong to corners of B on a face of A."""


class Points(NamedTuple):
    """Tables of points and their features, and scratch for the corners of polygons and what each of them is called."""

    point: Annotated[Floats, at.POINT]
    key: Annotated[Ints, at.POINT_KEY]
    polygon: Annotated[Floats, at.CLIP]
    polygon_key: Annotated[Ints, at.CLIP_KEY]


points_of = carved(Points)


@kernel
def put_nearest(
    out: Points, row: int, centre: Vec, radius: float, n: Vec, gap: float, margin: float, feature: int = 0
) -> tuple[int, Vec]:  # fmt: skip
    """Write the one point of a ball A and what lies along n, a gap [m] off, unless it is farther off than the margin.

    Returns: the number of points, and n.
    """
    if gap > margin:
        return 0, n
    put_point(out, row, axpy(radius + 0.5 * gap, n, centre), gap, feature)
    return 1, n


@kernel
def put_point(out: Points, row: int, place: Vec, gap: float, feature: int) -> None:
    """Write a point.

    Args: place [m] in W, midway between the surfaces; gap [m], negative in penetration; feature: the same number for the same
    corners and edges in the next step.
    """
    store3(out.point, row, at.PLACE, place)
    out.point[row, at.FIRST_GAP] = gap
    out.key[row, 0] = feature
