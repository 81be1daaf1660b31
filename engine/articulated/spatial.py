"""Spatial vectors, in W about the origin of a tree: angular numbers before linear ones, and the inertias that take them.

Source: Featherstone, Rigid Body Dynamics Algorithms, 2008, sections 2.2 (vectors), 2.9 (cross products), 2.13 (inertia).
"""

from plumbline.engine.compile.jit import kernel
from plumbline.engine.maths.rows import Floats, Mat, Sym, Vec, load6, store6
from plumbline.engine.maths.vec import add, axpy, cross, dot, mat_vec, sym_vec, tmat_vec

Spatial = tuple[float, float, float, float, float, float]
STILL: Vec = (0.0, 0.0, 0.0)
NOTHING: Spatial = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0)


@kernel
def turning(a: Spatial) -> Vec:
    """The angular numbers: of a motion, its turning; of a force, its moment about the origin."""
    return a[0], a[1], a[2]


@kernel
def sliding(a: Spatial) -> Vec:
    """The linear numbers."""
    return a[3], a[4], a[5]


@kernel
def add6(a: Spatial, b: Spatial) -> Spatial:
    """a + b."""
    return a[0] + b[0], a[1] + b[1], a[2] + b[2], a[3] + b[3], a[4] + b[4], a[5] + b[5]


@kernel
def sub6(a: Spatial, b: Spatial) -> Spatial:
    """a - b."""
    return a[0] - b[0], a[1] - b[1], a[2] - b[2], a[3] - b[3], a[4] - b[4], a[5] - b[5]


@kernel
def scale6(s: float, a: Spatial) -> Spatial:
    """s a."""
    return s * a[0], s * a[1], s * a[2], s * a[3], s * a[4], s * a[5]


@kernel
def axpy6(s: float, a: Spatial, b: Spatial) -> Spatial:
    """s a + b."""
    return *axpy(s, turning(a), turning(b)), *axpy(s, sliding(a), sliding(b))


@kernel
def dot6(a: Spatial, b: Spatial) -> float:
    """a . b, of a motion and a force."""
    return dot(turning(a), turning(b)) + dot(sliding(a), sliding(b))


@kernel
def add_row(table: Floats, i: int, c: int, a: Spatial) -> None:
    """Add to row i from column c on."""
    store6(table, i, c, add6(load6(table, i, c), a))


@kernel
def across(a: Spatial, b: Spatial) -> Spatial:
    """a x b, what a motion b changes by that is carried by a."""
    return *cross(turning(a), turning(b)), *add(cross(turning(a), sliding(b)), cross(sliding(a), turning(b)))


@kernel
def velocity_at(a: Spatial, r: Vec) -> Vec:
    """The velocity of what moves by a, at r."""
    return add(sliding(a), cross(turning(a), r))


@kernel
def force_at(torque: Vec, f: Vec, r: Vec) -> Spatial:
    """Torque and force at r."""
    return *add(torque, cross(r, f)), *f


@kernel
def times(rotation: Sym, coupling: Mat, translation: Sym, a: Spatial) -> Spatial:
    """The force that an inertia, [[rotation, coupling], [coupling^T, translation]], needs for an acceleration."""
    w, v = turning(a), sliding(a)
    return *add(sym_vec(rotation, w), mat_vec(coupling, v)), *add(tmat_vec(coupling, w), sym_vec(translation, v))
