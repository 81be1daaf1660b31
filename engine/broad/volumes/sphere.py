"""Bounding spheres: two shapes are apart if their centres are farther apart than their radii together.

Source: Ericson, Real-Time Collision Detection, section 4.3.1.
"""

from plumbline.engine.compile.jit import entry, kernel
from plumbline.engine.maths.rows import Floats, Ints, Vec, load3
from plumbline.engine.maths.vec import dot, sub
from plumbline.engine.memory import arena as at
from plumbline.engine.memory.carve import floats_of, ints_of


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


@entry
def drop_apart(floats: Floats, ints: Ints) -> None:
    """Keep the pairs of this step whose bounding spheres, widened as the bounds, overlap."""
    shape, pose = floats_of(floats, ints, at.SHAPE), floats_of(floats, ints, at.POSE)
    bounds = floats_of(floats, ints, at.BOUNDS)
    shape_kind, pair, count, kept = ints_of(ints, at.SHAPE_KIND), ints_of(ints, at.PAIR), ints_of(ints, at.COUNT), 0
    for p in range(count[0, at.PAIRS]):
        i, j = pair[p, 0], pair[p, 1]
        grow = bounds[i, 6] + bounds[j, 6]
        if shape_kind[i, at.TYPE] == at.PLANE:
            near = reaches_through(pose, i, j, shape[j, at.BALL_RADIUS] + grow)
        elif shape_kind[j, at.TYPE] == at.PLANE:
            near = reaches_through(pose, j, i, shape[i, at.BALL_RADIUS] + grow)
        else:
            reach = shape[i, at.BALL_RADIUS] + shape[j, at.BALL_RADIUS] + grow
            near = not spheres_apart(load3(pose, i, 0), load3(pose, j, 0), reach)
        if near:
            pair[kept, 0], pair[kept, 1] = i, j
            kept += 1
    count[0, at.PAIRS] = kept
