"""Gaussian elimination with partial pivoting, over what is not zero: contacts that share no body share no entries.

Source: Golub, Van Loan, Matrix Computations, section 3.4 (algorithm 3.4.1).
"""

import math

import numpy as np

from plumbline.engine.compile.jit import kernel
from plumbline.engine.maths.rows import Floats, Ints


@kernel
def find_ends(a: Floats, right: Ints, below: Ints) -> None:
    """Write behind which column each row of a (n, n) is zero, and below which row each column."""
    for i in range(len(a)):
        right[i] = 0
        for j in range(len(a)):
            if a[i, j] != 0.0:
                right[i], below[j] = j + 1, i + 1


@kernel
def exchange(a: Floats, x: Floats, right: Ints, k: int, pivot: int) -> None:
    """Exchange two rows of what is left from column k on."""
    for j in range(k, max(right[k], right[pivot])):
        a[k, j], a[pivot, j] = a[pivot, j], a[k, j]
    x[k], x[pivot], right[k], right[pivot] = x[pivot], x[k], right[pivot], right[k]


@kernel
def eliminate(a: Floats, x: Floats) -> bool:
    """Replace x (n,) by the solution of a x' = x; a (n, n) is used up. Returns: whether it is there, in numbers."""
    n = len(x)
    right, below = np.zeros(n, np.int64), np.zeros(n, np.int64)
    find_ends(a, right, below)
    for k in range(n):
        pivot = k
        for i in range(k + 1, below[k]):
            if abs(a[i, k]) > abs(a[pivot, k]):
                pivot = i
        if not abs(a[pivot, k]) > 0.0:
            return False
        widest = max(right[k], right[pivot])
        if pivot != k:
            exchange(a, x, right, k, pivot)
        for i in range(k + 1, below[k]):
            if a[i, k] != 0.0:
                share = a[i, k] / a[k, k]
                for j in range(k + 1, right[k]):
                    a[i, j] -= share * a[k, j]
                x[i] -= share * x[k]
                right[i] = max(right[i], right[k])
        for j in range(k + 1, widest):
            below[j] = max(below[j], below[k])
    for k in range(n - 1, -1, -1):
        for j in range(k + 1, right[k]):
            x[k] -= a[k, j] * x[j]
        x[k] /= a[k, k]
        if not math.isfinite(x[k]):
            return False
    return True
