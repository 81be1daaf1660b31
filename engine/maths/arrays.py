"""Vectors and matrices as NumPy arrays, where worlds are built: each sum in the order in which it stands here.

NumPy hands products of matrices, lengths and eigenvalues to libraries that add in an order of the processor's; what it does
number by number is rounded alike everywhere. A few numbers are added as Python's own, which is quicker.
"""

import math
from collections.abc import Sequence

import numpy as np

from plumbline.engine.maths.types import Floats

SWEEPS = 30
"""At most: five did for each of 20 000 random matrices whose moments lay up to 1e16 apart."""
LOST = 1e-17
"""Of the geometric mean of two moments: what stands beside them in a float is ten times as much."""
PAIRS = ((0, 1), (0, 2), (1, 2))


def dot(a: Floats, b: Floats) -> Floats:
    """The sum of a b over the last axis."""
    if a.ndim == b.ndim == 1:
        return np.asarray(_dot(a.tolist(), b.tolist()))
    products = a * b
    total: Floats = products[..., 0]
    for k in range(1, products.shape[-1]):
        total = total + products[..., k]
    return total


def _dot(a: Sequence[float], b: Sequence[float]) -> float:
    total = a[0] * b[0]
    for k in range(1, len(a)):
        total += a[k] * b[k]
    return total


def norm(a: Floats) -> Floats:
    """The lengths of vectors along the last axis."""
    return np.asarray(np.sqrt(dot(a, a)))


def unit(a: Floats) -> Floats:
    """Vectors along the last axis at length 1."""
    return np.asarray(a / norm(a)[..., np.newaxis])


def cross(a: Floats, b: Floats) -> Floats:
    """a x b of two vectors (3,), as `np.cross` rounds it, in less than a tenth of its time."""
    (x, y, z), (u, v, w) = a.tolist(), b.tolist()
    return np.array([y * w - z * v, z * u - x * w, x * v - y * u])


def mat_vec(m: Floats, v: Floats) -> Floats:
    """m v of a matrix (k, n), or of one for each vector, and vectors along the last axis (..., n)."""
    if m.ndim == 2 and v.ndim == 1:
        numbers = v.tolist()
        return np.array([_dot(row, numbers) for row in m.tolist()])
    return dot(m, v[..., np.newaxis, :])


def mat_mat(a: Floats, b: Floats) -> Floats:
    """a b of two matrices."""
    columns = b.T.tolist()
    return np.array([[_dot(row, column) for column in columns] for row in a.tolist()])


def det(m: Floats) -> float:
    """The determinant of a matrix (3, 3)."""
    return float(dot(m[0], cross(m[1], m[2])))


def inverse(m: Floats) -> Floats:
    """The inverse of a symmetric matrix (3, 3), symmetric, by cofactors."""
    (a, d, e), (_, b, f), (_, _, c) = m.tolist()
    if d == e == f == 0.0:
        return np.diag([1.0 / a, 1.0 / b, 1.0 / c])
    xx, xy, xz = b * c - f * f, e * f - d * c, d * f - e * b
    yy, yz, zz = a * c - e * e, d * e - a * f, a * b - d * d
    whole = a * xx + d * xy + e * xz
    return np.asarray(np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]) / whole)


def eigenvalues(m: Floats) -> Floats:
    """The eigenvalues (3,) of a symmetric matrix (3, 3), in ascending order."""
    return eigen(m)[0]


def eigen(m: Floats) -> tuple[Floats, Floats]:
    """The eigenvalues (3,) of a symmetric matrix (3, 3) in ascending order, and its eigenvectors as columns (3, 3).

    Of a vector the largest component is positive, the first of those that are as large. A diagonal matrix is not rounded.

    Source: Golub, Van Loan, Matrix Computations, 4th ed., section 8.5 (Jacobi's method, by rows).
    """
    a = m.tolist()
    v = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]
    for _ in range(SWEEPS):
        if a[0][1] == a[0][2] == a[1][2] == 0.0:
            break
        for p, q in PAIRS:
            _rotate(a, v, p, q)
    found = sorted(range(3), key=lambda k: a[k][k])
    axes = np.array([_signed(v[k]) for k in found]).T
    return np.array([a[k][k] for k in found]), axes


def _rotate(a: list[list[float]], v: list[list[float]], p: int, q: int) -> None:
    """One of Jacobi's rotations, which makes a[p][q] zero, with the rows of v turned alike."""
    off = a[p][q]
    if abs(off) <= LOST * math.sqrt(abs(a[p][p])) * math.sqrt(abs(a[q][q])):
        a[p][q] = a[q][p] = 0.0
        return
    ratio = 0.5 * (a[q][q] - a[p][p]) / off
    t = 1.0 / (abs(ratio) + math.sqrt(1.0 + ratio * ratio)) if abs(ratio) < 1e150 else 0.5 / abs(ratio)
    t = t if ratio >= 0.0 else -t
    c = 1.0 / math.sqrt(1.0 + t * t)
    s = t * c
    r = 3 - p - q
    a[p][p], a[q][q] = a[p][p] - t * off, a[q][q] + t * off
    a[p][q] = a[q][p] = 0.0
    a[p][r], a[q][r] = c * a[p][r] - s * a[q][r], s * a[p][r] + c * a[q][r]
    a[r][p], a[r][q] = a[p][r], a[q][r]
    v[p], v[q] = (
        [c * x - s * y for x, y in zip(v[p], v[q], strict=True)],
        [s * x + c * y for x, y in zip(v[p], v[q], strict=True)],
    )


def _signed(vector: list[float]) -> list[float]:
    """The vector with its largest component positive."""
    return vector if max(vector, key=abs) > 0.0 else [-x for x in vector]
