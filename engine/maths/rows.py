"""Rows of tables, read and written as tuples of numbers, which the compiler keeps in registers.

Terms: Vec (x, y, z); Quat (w, x, y, z), unit; Mat nine numbers by rows; Sym (xx, yy, zz, xy, xz, yz).
"""

from plumbline.engine.compile.jit import kernel
from plumbline.engine.maths.types import Floats as Floats
from plumbline.engine.maths.types import Ints as Ints

Vec = tuple[float, float, float]
Quat = tuple[float, float, float, float]
Mat = tuple[float, float, float, float, float, float, float, float, float]
Sym = tuple[float, float, float, float, float, float]


@kernel
def load3(a: Floats, i: int, c: int) -> Vec:
    """Three numbers of row i from column c."""
    return a[i, c], a[i, c + 1], a[i, c + 2]


@kernel
def load4(a: Floats, i: int, c: int) -> Quat:
    """Four numbers of row i from column c."""
    return a[i, c], a[i, c + 1], a[i, c + 2], a[i, c + 3]


@kernel
def load6(a: Floats, i: int, c: int) -> Sym:
    """Six numbers of row i from column c."""
    return a[i, c], a[i, c + 1], a[i, c + 2], a[i, c + 3], a[i, c + 4], a[i, c + 5]


@kernel
def load9(a: Floats, i: int, c: int) -> Mat:
    """Nine numbers of row i from column c."""
    return (
        a[i, c], a[i, c + 1], a[i, c + 2], a[i, c + 3], a[i, c + 4], a[i, c + 5], a[i, c + 6], a[i, c + 7], a[i, c + 8]
    )  # fmt: skip


@kernel
def store3(a: Floats, i: int, c: int, v: Vec) -> None:
    """Put a vector into row i from column c."""
    a[i, c], a[i, c + 1], a[i, c + 2] = v[0], v[1], v[2]


@kernel
def store4(a: Floats, i: int, c: int, q: Quat) -> None:
    """Put a quaternion into row i from column c."""
    a[i, c], a[i, c + 1], a[i, c + 2], a[i, c + 3] = q[0], q[1], q[2], q[3]


@kernel
def store6(a: Floats, i: int, c: int, s: Sym) -> None:
    """Put a symmetric matrix into row i from column c."""
    a[i, c], a[i, c + 1], a[i, c + 2] = s[0], s[1], s[2]
    a[i, c + 3], a[i, c + 4], a[i, c + 5] = s[3], s[4], s[5]


@kernel
def store9(a: Floats, i: int, c: int, m: Mat) -> None:
    """Put a matrix into row i from column c."""
    a[i, c], a[i, c + 1], a[i, c + 2] = m[0], m[1], m[2]
    a[i, c + 3], a[i, c + 4], a[i, c + 5] = m[3], m[4], m[5]
    a[i, c + 6], a[i, c + 7], a[i, c + 8] = m[6], m[7], m[8]
