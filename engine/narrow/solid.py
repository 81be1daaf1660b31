"""One shape in W, as the pairs with a closed form take it: numbers that the compiler keeps in registers."""

from typing import NamedTuple

from plumbline.engine.compile.jit import kernel
from plumbline.engine.maths.rows import Mat, Vec, load3, load9
from plumbline.engine.memory import arena as at
from plumbline.engine.memory.tables import Shapes


class Solid(NamedTuple):
    """One shape.

    Terms: p [m]: its centre in W, of a plane any point of it; m: rotation matrix, its own axes as columns; size [m]: radius |
    half extents or semi-axes | radius, half length.
    """

    p: Vec
    m: Mat
    size: Vec


@kernel
def solid_of(shapes: Shapes, s: int) -> Solid:
    """Shape s, where it is now."""
    return Solid(load3(shapes.pose, s, 0), load9(shapes.pose, s, 3), load3(shapes.shape, s, at.SIZE))


@kernel
def axis_of(solid: Solid) -> Vec:
    """The third axis of a shape in W: of a capsule and a cylinder their own, of a plane the normal."""
    return solid.m[2], solid.m[5], solid.m[8]


@kernel
def column(m: Mat, k: int) -> Vec:
    """Column k of a matrix: axis k of the frame, in W."""
    return m[k], m[3 + k], m[6 + k]


@kernel
def largest(v: Vec) -> int:
    """Which component of a vector has the largest magnitude, the first of equal ones."""
    first = 1 if abs(v[1]) > abs(v[0]) else 0
    return 2 if abs(v[2]) > abs(v[first]) else first


@kernel
def moved(solid: Solid, p: Vec) -> Solid:
    """The same shape with its centre at p."""
    return Solid(p, solid.m, solid.size)
