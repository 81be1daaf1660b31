"""Ellipsoids that roll on: their touching point is the farthest along the normal, however the body has turned since."""

from plumbline.engine.compile.jit import kernel
from plumbline.engine.maths.rows import Floats, Ints, Mat, Vec, load3, load4
from plumbline.engine.maths.vec import add, mat_vec, quat_mat, tmat_vec
from plumbline.engine.memory import arena as at
from plumbline.engine.narrow.support import ellipsoid_support

ON_ELLIPSOID = 2.0
"""In the column of rims: at least one of the two shapes is an ellipsoid, and the manifold a single point."""


@kernel
def is_ellipsoid(shape_kind: Ints, a: int, b: int) -> bool:
    """Whether one of two shapes is an ellipsoid."""
    return bool(shape_kind[a, at.TYPE] == at.ELLIPSOID or shape_kind[b, at.TYPE] == at.ELLIPSOID)


@kernel
def farthest(shape: Floats, s: int, r_WB: Mat, n: Vec) -> Vec:
    """The point of ellipsoid s farthest along n, from its body's centre of mass, in W [m]."""
    m = quat_mat(load4(shape, s, at.TURN))
    spot = mat_vec(m, ellipsoid_support(load3(shape, s, at.SIZE), tmat_vec(m, tmat_vec(r_WB, n))))
    return mat_vec(r_WB, add(load3(shape, s, at.OFFSET), spot))
