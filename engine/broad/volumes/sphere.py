"""Bounding spheres: two shapes are apart if their centres are farther apart than their radii together.

Source: Ericson, Real-Time Collision Detection, section 4.3.1.
"""

from collections.abc import Callable

from plumbline.engine.compile.jit import entry, kernel
from plumbline.engine.maths.rows import Floats, Ints, Vec, load3
from plumbline.engine.maths.vec import dot, sub
from plumbline.engine.memory import arena as at
from plumbline.engine.memory.carve import floats_of, ints_of
from plumbline.engine.memory.tables import Shapes, shapes_of


@kernel
def spheres_apart(p: Vec, q: Vec, reach: float) -> bool:
    """Whether two centres [m] are farther apart than the radii together."""
    d = sub(q, p)
    return bool(dot(d, d) > reach * reach)


@kernel
def reaches_through(pose: Floats, plane: int, other: int, reach: float) -> bool:
    """Whether a shape that reaches so far [m] from its centre against a plane's normal lies partly below the plane."""
    n = (pose[plane, 5], pose[plane, 8], pose[plane, 11])
    return bool(dot(n, sub(load3(pose, other, 0), load3(pose, plane, 0))) <= reach)


@kernel
def keep_near(
    floats: Floats, ints: Ints, reach: Callable[[Shapes, int, int], float], apart: Callable[[Shapes, int, int, float], bool]
) -> None:
    """Keep the pairs of this step whose volumes, widened as the bounds, overlap.

    Args: reach: (shapes, plane, other) -> how far [m] the other reaches from its centre against the plane's normal; apart:
        (shapes, i, j, by how much both are widened [m]) -> whether two bounded shapes are apart.
    """
    shapes, bounds = shapes_of(floats, ints), floats_of(floats, ints, at.BOUNDS)
    pair, count, kept = ints_of(ints, at.PAIR), ints_of(ints, at.COUNT), 0
    for p in range(count[0, at.PAIRS]):
        i, j = pair[p, 0], pair[p, 1]
        grow = bounds[i, 6] + bounds[j, 6]
        if shapes.kind[i, at.TYPE] == at.PLANE:
            near = reaches_through(shapes.pose, i, j, reach(shapes, i, j) + grow)
        elif shapes.kind[j, at.TYPE] == at.PLANE:
            near = reaches_through(shapes.pose, j, i, reach(shapes, j, i) + grow)
        else:
            near = not apart(shapes, i, j, grow)
        if near:
            pair[kept, 0], pair[kept, 1] = i, j
            kept += 1
    count[0, at.PAIRS] = kept


@kernel
def radius(shapes: Shapes, _plane: int, other: int) -> float:
    """How far a ball reaches."""
    return float(shapes.shape[other, at.BALL_RADIUS])


@kernel
def balls_apart(shapes: Shapes, i: int, j: int, grow: float) -> bool:
    """Whether the bounding spheres of two shapes are farther apart than `grow` [m]."""
    reach = shapes.shape[i, at.BALL_RADIUS] + shapes.shape[j, at.BALL_RADIUS] + grow
    return bool(spheres_apart(load3(shapes.pose, i, 0), load3(shapes.pose, j, 0), reach))


@entry
def drop_apart(floats: Floats, ints: Ints) -> None:
    """Keep the pairs of this step whose bounding spheres, widened as the bounds, overlap."""
    keep_near(floats, ints, radius, balls_apart)
