"""The matrix of a contact problem in extended precision, solved with a block per contact added to it.

A body held from two sides slips or lifts by 1e-8 m/s where gaps are not closed by the same motion, and who does is decided by
impulses along directions in which W vanishes. W from the engine is positive semi-definite up to round-off only; there its
negative part, 1e-16, would decide. W = G G^T from its positive eigenvalues alone, multiplied out with more digits, has no such
part: round-off is below a change of W in its last digits, which no answer can feel.

In the frames of the contacts the added blocks are diagonal. There, their values may spread over all orders of magnitude and
cost no digits, since a Cholesky factorisation does not see the scale of rows.

Source: Higham, Accuracy and Stability of Numerical Algorithms, SIAM 2002, chapter 10.
"""

import numpy as np
from numpy.typing import NDArray

from plumbline.engine.maths.types import Floats

FineArray = NDArray[np.longdouble]

FINE = np.longdouble
"""The widest numbers of the machine: 64 binary digits on x86, 113 or 53 elsewhere, where less is gained."""
VANISHING = 1e-13
"""Eigenvalues below this share of the largest are round-off of W."""
PROXIMAL = 100.0 * float(np.finfo(FINE).eps)
"""Added to the diagonal, in units of a contact's own inverse mass, where forces are not unique."""


def positive_part(w: Floats) -> FineArray:
    """W (n, n) from its positive eigenvalues alone, with more digits."""
    value, vector = np.linalg.eigh(w)
    real = value > VANISHING * value[-1]
    half = vector[:, real].astype(FINE) * np.sqrt(value[real].astype(FINE))
    return np.asarray(half @ half.T, FINE)


class Blocks:
    """W (3k, 3k), symmetric, positive semi-definite, of order one; `factor` first, then `solve`."""

    def __init__(self, w: FineArray) -> None:
        self.w, self.k = w, len(w) // 3
        self.diagonal = np.arange(len(w))

    def times(self, x: FineArray) -> FineArray:
        """W x for x (k, 3)."""
        return np.asarray((self.w @ x.ravel()).reshape(-1, 3))

    def factor(self, frame: FineArray, values: FineArray) -> bool:
        """Factorise W plus blocks with eigenvalues (k, 3) on frames (k, 3, 3). Returns: whether it is definite."""
        k = self.k
        self.frame, self.turned = frame, np.swapaxes(frame, 1, 2)
        half = (self.turned @ self.w.reshape(k, 3, 3 * k)).reshape(3 * k, 3 * k).T
        matrix = (self.turned @ half.reshape(k, 3, 3 * k)).reshape(3 * k, 3 * k)
        proximal = PROXIMAL
        for _ in range(8):
            tried = matrix.copy()
            tried[self.diagonal, self.diagonal] += values.ravel() + proximal
            if cholesky(tried):
                self.lower = tried
                return True
            proximal *= 10.0
        return False

    def solve(self, right: FineArray) -> FineArray:
        """The solution (k, 3) for a right side (k, 3)."""
        x, lower = (self.turned @ right[:, :, None]).ravel(), self.lower
        for j in range(len(x)):
            x[j] = (x[j] - lower[j, :j] @ x[:j]) / lower[j, j]
        upper = lower.T
        for j in range(len(x) - 1, -1, -1):
            x[j] = (x[j] - upper[j, j + 1 :] @ x[j + 1 :]) / lower[j, j]
        return np.asarray((self.frame @ x.reshape(self.k, 3, 1))[:, :, 0])


def cholesky(a: FineArray) -> bool:
    """Overwrite the lower triangle of a (n, n) by its factor. Returns: whether a is positive definite."""
    for j in range(len(a)):
        a[j:, j] -= a[j:, :j] @ a[j, :j]
        if not a[j, j] > 0.0:
            return False
        a[j:, j] /= np.sqrt(a[j, j])
    return True
