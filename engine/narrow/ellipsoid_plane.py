"""Contact of an ellipsoid with a plane: its lowest point, in closed form.

Source: Ericson, Real-Time Collision Detection, section 3.8 (support mappings); Rockafellar, Convex Analysis, 1970, section 13
(the support function |D n| of an ellipsoid).
"""

from plumbline.engine.compile.jit import kernel
from plumbline.engine.maths.rows import Vec
from plumbline.engine.maths.vec import add, axpy, dot, mat_vec, neg, sub, tmat_vec
from plumbline.engine.narrow.point import Points, put_point
from plumbline.engine.narrow.solid import Solid, axis_of
from plumbline.engine.narrow.support import ellipsoid_support


@kernel
def ellipsoid_plane(a: Solid, b: Solid, margin: float, out: Points, row: int) -> tuple[int, Vec]:
    """Ellipsoid A against plane B; the normal from A to B is the plane's reversed."""
    up = axis_of(b)
    n = neg(up)
    lowest = add(a.p, mat_vec(a.m, ellipsoid_support(a.size, tmat_vec(a.m, n))))
    gap = dot(sub(lowest, b.p), up)
    if gap > margin:
        return 0, n
    put_point(out, row, axpy(0.5 * gap, n, lowest), gap, 0)
    return 1, n
