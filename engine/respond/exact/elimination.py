"""Gaussian elimination with partial pivoting, over what is not zero: contacts that share no body share no entries.

Source: Golub, Van Loan, Matrix Computations, section 3.4 (algorithm 3.4.1).
"""

import math

from engine.compile.jit import kernel
from engine.maths.vec import Floats

__all__ = ["eliminate"]


@kernel
def eliminate(a: Floats, x: Floats) -> bool:
    """Replace x (n,) by the solution of a x' = x; a (n, n) is used up. Returns: whether it is there, in numbers."""
    n = len(x)
    for k in range(n):
        pivot = k
        for i in range(k + 1, n):
            if abs(a[i, k]) > abs(a[pivot, k]):
                pivot = i
        if not abs(a[pivot, k]) > 0.0:
            return False
        if pivot != k:
            for j in range(k, n):
                a[k, j], a[pivot, j] = a[pivot, j], a[k, j]
            x[k], x[pivot] = x[pivot], x[k]
        end = n
        while a[k, end - 1] == 0.0:
            end -= 1
        for i in range(k + 1, n):
            if a[i, k] != 0.0:
                share = a[i, k] / a[k, k]
                for j in range(k + 1, end):
                    a[i, j] -= share * a[k, j]
                x[i] -= share * x[k]
    for k in range(n - 1, -1, -1):
        for j in range(k + 1, n):
            x[k] -= a[k, j] * x[j]
        x[k] /= a[k, k]
        if not math.isfinite(x[k]):
            return False
    return True
