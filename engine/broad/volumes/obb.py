"""Oriented bounding boxes: two are disjoint if and only if a face normal of one, or a cross product of an edge of each, parts
their projections: fifteen axes.

Source: Gottschalk, Lin, Manocha, OBBTree: A Hierarchical Structure for Rapid Interference Detection, SIGGRAPH 1996, section 5;
Ericson, Real-Time Collision Detection, section 4.4.1.
"""

from plumbline.engine.broad.volumes.sphere import keep_near
from plumbline.engine.compile.jit import entry, kernel
from plumbline.engine.maths.rows import Floats, Ints, Mat, Vec, load3, load9
from plumbline.engine.maths.vec import cross, dot, norm, sub
from plumbline.engine.memory import arena as at
from plumbline.engine.memory.tables import Shapes
from plumbline.engine.narrow.solid import column

PARALLEL = 1e-6
"""Length of the cross product of two edges [1] below which it is left out: the face normals stand for parallel edges."""


@kernel
def half_extents(shape: Floats, shape_kind: Ints, s: int) -> Vec:
    """Half extents [m] of the box about a bounded shape along the shape's own axes."""
    h, kind = load3(shape, s, at.SIZE), shape_kind[s, at.TYPE]
    if kind == at.SPHERE:
        return h[0], h[0], h[0]
    if kind == at.CAPSULE:
        return h[0], h[0], h[0] + h[1]
    if kind == at.CYLINDER:
        return h[0], h[0], h[1]
    return h


@kernel
def reach_along(m: Mat, h: Vec, n: Vec) -> float:
    """Half the width [m] of a box along n, times the length of n."""
    return h[0] * abs(dot(column(m, 0), n)) + h[1] * abs(dot(column(m, 1), n)) + h[2] * abs(dot(column(m, 2), n))


@kernel
def boxes_apart(d: Vec, ma: Mat, ha: Vec, mb: Mat, hb: Vec, grow: float) -> bool:
    """Whether two boxes are farther apart than `grow` [m] along one of the fifteen axes.

    Args: d: from the centre of A to that of B [m]; ma, mb: axes as columns; ha, hb: half extents [m].
    """
    for k in range(3):
        n = column(ma, k)
        if abs(dot(d, n)) > reach_along(ma, ha, n) + reach_along(mb, hb, n) + grow:
            return True
        n = column(mb, k)
        if abs(dot(d, n)) > reach_along(ma, ha, n) + reach_along(mb, hb, n) + grow:
            return True
    for i in range(3):
        for j in range(3):
            n = cross(column(ma, i), column(mb, j))
            length = norm(n)
            if length > PARALLEL and abs(dot(d, n)) > reach_along(ma, ha, n) + reach_along(mb, hb, n) + grow * length:
                return True
    return False


@kernel
def width_along(shapes: Shapes, plane: int, other: int) -> float:
    """How far [m] the box about a shape reaches against a plane's normal."""
    normal = column(load9(shapes.pose, plane, 3), 2)
    return reach_along(load9(shapes.pose, other, 3), half_extents(shapes.shape, shapes.kind, other), normal)


@kernel
def shapes_apart(shapes: Shapes, i: int, j: int, grow: float) -> bool:
    """Whether the boxes about two shapes are farther apart than `grow` [m]."""
    hi, hj = half_extents(shapes.shape, shapes.kind, i), half_extents(shapes.shape, shapes.kind, j)
    d = sub(load3(shapes.pose, j, 0), load3(shapes.pose, i, 0))
    return boxes_apart(d, load9(shapes.pose, i, 3), hi, load9(shapes.pose, j, 3), hj, grow)


@entry
def drop_apart(floats: Floats, ints: Ints) -> None:
    """Keep the pairs of this step whose oriented boxes, widened as the bounds, overlap."""
    keep_near(floats, ints, width_along, shapes_apart)
