"""Which normals a triangle of a mesh may answer, so that bodies slide over the seams of a flat surface.

Source: Ericson, Real-Time Collision Detection, section 5.1.5 (Voronoi regions of a triangle); Bender, Erleben, Trinkle,
Interactive Simulation of Rigid Body Dynamics in Computer Graphics, 2014, section 4 (one-sided triangles).
"""

from plumbline.engine.compile.jit import kernel
from plumbline.engine.maths.rows import Vec, load3, load9
from plumbline.engine.maths.vec import cross, dot, norm, sub, tmat_vec
from plumbline.engine.memory import arena as at
from plumbline.engine.narrow.support import Solids

ON_EDGE = 1e-6
"""Share of the triangle's size [1] within which a point lies on an edge."""
UPRIGHT = 1e-6
"""Sine between a normal and the triangle's own below which they are the same."""
BACK = 1e-3
"""Cosine between the way into a triangle and its own normal above which its back is met."""
BESIDE = 0.5
"""Cosine between the way out and a triangle's own normal below which what leans over an inner edge is left to the triangle
behind that: along the normal of one that stands so steeply, whatever reaches far under it would be deep."""


@kernel
def leans_over(t: Solids, s: int, spot: Vec, out: Vec, inner: int) -> bool:
    """Whether a direction at a point of triangle s points away through its back, or over an edge that does not stick out.

    Args: spot [m]: from the triangle's centre, along the axes of W; out: unit, in W, away from the triangle; inner: bits of
    such edges. Away from all edges only the triangle's own normal is left.
    """
    m = load9(t.pose, s, 3)
    x, u = tmat_vec(m, spot), tmat_vec(m, out)
    if u[2] < -1e-3:
        return True
    if u[0] * u[0] + u[1] * u[1] < UPRIGHT * UPRIGHT:
        return False
    near = ON_EDGE * t.shape[s, at.BALL_RADIUS]
    first, outside = t.polyhedron[s, at.FIRST_VERTEX], False
    for k in range(3):
        a, b = load3(t.vertex, first + k, 0), load3(t.vertex, first + (k + 1) % 3, 0)
        e = sub(b, a)
        beyond = cross(e, (0.0, 0.0, 1.0))
        if dot(sub(x, a), beyond) >= -near * norm(e):
            lean = dot(u, beyond) / norm(e)
            if lean > UPRIGHT and inner & (1 << k) != 0:
                return True
            outside = outside or lean > -UPRIGHT
    return not outside
