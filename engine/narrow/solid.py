"""One shape in W, as the pairs with a closed form take it: numbers that the compiler keeps in registers."""

from typing import NamedTuple

from plumbline.engine.compile.jit import kernel
from plumbline.engine.maths.rows import Mat, Vec, load3, load9
from plumbline.engine.maths.vec import axpy
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
def face_corner(p: Vec, m: Mat, h: Vec, face: int, sign: float, corner: int) -> Vec:
    """A corner of a box: number 0 to 3, counter-clockwise about axis `face`, of its face at `sign` along that axis.

    Args: p: centre; m: axes as columns; h: half extents [m].
    """
    one, two = (face + 1) % 3, (face + 2) % 3
    x, y = (1.0 if corner == 0 or corner == 3 else -1.0), (1.0 if corner < 2 else -1.0)
    middle = axpy(sign * h[face], column(m, face), p)
    return axpy(x * h[one], column(m, one), axpy(y * h[two], column(m, two), middle))


@kernel
def moved(solid: Solid, p: Vec) -> Solid:
    """The same shape with its centre at p."""
    return Solid(p, solid.m, solid.size)
