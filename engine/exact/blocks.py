"""The matrix of a contact problem, solved with a block per contact added to it.

In the frames of the contacts the added blocks are diagonal. There, their values may spread over all orders of magnitude and
cost no digits, since a Cholesky factorisation does not see the scale of rows.
"""

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import get_lapack_funcs

__all__ = ["Blocks"]

FloatArray = NDArray[np.float64]

(potrf, potrs) = get_lapack_funcs(("potrf", "potrs"), dtype=np.float64)

PROXIMAL = 1e-11
"""Added to the diagonal, in units of a contact's own inverse mass, where forces are not unique."""


class Blocks:
    """W (3k, 3k), symmetric, positive semi-definite, of order one; `factor` first, then `solve`."""

    def __init__(self, w: FloatArray) -> None:
        self.w, self.k = w, len(w) // 3
        self.diagonal = np.arange(len(w))

    def times(self, x: FloatArray) -> FloatArray:
        """W x for x (k, 3)."""
        return np.asarray((self.w @ x.ravel()).reshape(-1, 3))

    def factor(self, frame: FloatArray, values: FloatArray) -> bool:
        """Factorise W plus blocks with eigenvalues (k, 3) on frames (k, 3, 3). Returns: whether it is definite."""
        k = self.k
        self.frame, self.turned = frame, np.swapaxes(frame, 1, 2)
        half = (self.turned @ self.w.reshape(k, 3, 3 * k)).reshape(3 * k, 3 * k).T
        matrix = (self.turned @ half.reshape(k, 3, 3 * k)).reshape(3 * k, 3 * k)
        proximal = PROXIMAL
        for _ in range(6):
            tried = matrix.copy()
            tried[self.diagonal, self.diagonal] += values.ravel() + proximal
            self.lower, status = potrf(tried, lower=1, clean=0)
            if status == 0:
                return True
            proximal *= 10.0
        return False

    def solve(self, right: FloatArray) -> FloatArray:
        """The solution (k, 3) for a right side (k, 3)."""
        rhs = (self.turned @ right[:, :, None]).ravel()
        solved, _ = potrs(self.lower, rhs, lower=1)
        return np.asarray((self.frame @ solved.reshape(self.k, 3, 1))[:, :, 0])
