"""Newton on Coulomb's law itself, without convexity: the last steps from near a solution, compiled.

With mu = 1 in scaled variables and tau = x - (W x + q), the law of Alart and Curnier reads

    x_N = max(tau_N, 0),  x_T = the point of the disc of radius max(tau_N, 0) nearest to tau_T,

piecewise smooth. From far away these steps fail; near by, with the right set of open, sticking and slipping contacts, they
converge quadratically. Each is solved over what is not zero: contacts that share no body share no entries.

Source: Alart, Curnier, Comput. Methods Appl. Mech. Eng. 92, 1991; Golub, Van Loan, Matrix Computations, section 3.4 (algorithm
3.4.1: elimination with partial pivoting).
"""

import math

import numpy as np

from plumbline.engine.compile.jit import entry, kernel
from plumbline.engine.maths.elementary import hypot
from plumbline.engine.maths.rows import Floats, Ints, load3
from plumbline.engine.maths.vec import axpy
from plumbline.engine.respond.exact.law import after, breach, write_scale


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


SHORTER = (1.0, 0.5, 0.2, 0.05, 0.01)
"""How much shorter a step may be made."""


@kernel
def relative(worst: float, speed: float) -> float:
    """The relative residual of a largest breach [m/s]; inf where that is no number."""
    return worst / speed if math.isfinite(worst) else math.inf


@kernel
def newton_step(
    w: Floats, q: Floats, friction: Floats, x: Floats, weight: float, proximal: float, matrix: Floats, step: Floats
) -> bool:
    """Write what one step changes into `step` (3k,). Args: w, q, x: scaled. Returns: whether the system was regular."""
    k, added, y = len(x), weight * proximal - 1.0, after(w, q, x)
    for i in range(k):
        tau = axpy(-weight, load3(y, i, 0), load3(x, i, 0))
        normal, size = max(tau[0], 0.0), hypot(tau[1], tau[2])
        rubs, slips, t1, t2 = friction[i] > 0.0, size > normal, tau[1] / max(size, 1e-300), tau[2] / max(size, 1e-300)
        share = 0.0
        if rubs:
            share = normal / max(size, 1e-300) if slips else 1.0
        slope, drag1, drag2 = (share, share, 0.0), 0.0, 0.0  # of the tangent: its matrix (11, 22, 12), and its columns by tau_N
        if rubs and slips and tau[0] > 0.0:
            slope, drag1, drag2 = (share - share * t1 * t1, share - share * t2 * t2, -share * t1 * t2), t1, t2
        bears = 1.0 if tau[0] > 0.0 else 0.0
        for j in range(3 * k):
            w0, w1, w2 = weight * w[3 * i, j], weight * w[3 * i + 1, j], weight * w[3 * i + 2, j]
            if j // 3 == i:
                w0 += added if j == 3 * i else 0.0
                w1 += added if j == 3 * i + 1 else 0.0
                w2 += added if j == 3 * i + 2 else 0.0
            matrix[3 * i, j] = bears * w0
            matrix[3 * i + 1, j] = drag1 * w0 + slope[0] * w1 + slope[2] * w2
            matrix[3 * i + 2, j] = drag2 * w0 + slope[2] * w1 + slope[1] * w2
        for c in range(3):
            matrix[3 * i + c, 3 * i + c] += 1.0
        step[3 * i], step[3 * i + 1], step[3 * i + 2] = normal - x[i, 0], share * tau[1] - x[i, 1], share * tau[2] - x[i, 2]
    return eliminate(matrix, step)


@entry
def finish_from(
    problem: tuple[Floats, Floats, Floats, float],
    r: Floats,
    weights: tuple[float, float],
    aims: tuple[float, float, float],
    most: int,
) -> tuple[float, int, bool]:
    """A few steps from impulses r (k, 3) N s, which become the best that were met.

    Args:
        problem: W, q, friction and speed, as of `Problem`; weights: of velocities against impulses, and of the distance to the
        last impulses; aims: residuals: the tolerance, what is aimed at while steps help, and the one below which steps are
        tried; most: steps.
    Returns: the residual, how many matrices were factorised, and whether one more was wanted.
    """
    w, q, friction, speed = problem
    (weight, proximal), (tolerance, aim, near), k = weights, aims, len(r)
    for i in range(k):
        if not friction[i] > 0.0:
            r[i, 1], r[i, 2] = 0.0, 0.0
    lowest, idle = relative(breach(w, q, friction, r), speed), 0
    if not aim < lowest < near:
        return lowest, 0, False
    scaled_w, scaled_q, scale, x = np.empty((3 * k, 3 * k)), np.empty((k, 3)), np.empty((k, 3)), np.empty((k, 3))
    unit = write_scale(w, q, friction, scaled_w, scaled_q, scale)
    for i in range(k):
        for c in range(3):
            x[i, c] = r[i, c] * scale[i, c] / unit
    tried, matrix, step = np.empty((k, 3)), np.empty((3 * k, 3 * k)), np.empty(3 * k)
    for used in range(most):
        if not newton_step(scaled_w, scaled_q, friction, x, weight, proximal, matrix, step):
            return lowest, used + 1, False
        size, now = 1.0, math.inf
        for shorter in SHORTER:
            for i in range(k):
                for c in range(3):
                    tried[i, c] = (x[i, c] + shorter * step[3 * i + c]) * unit / scale[i, c]
            now = relative(breach(w, q, friction, tried), speed)
            if now < lowest:
                size = shorter
                break
        # Where none helps the whole step is taken, from whose end the next ones may.
        for i in range(k):
            for c in range(3):
                x[i, c] += size * step[3 * i + c]
        idle = 0 if now < 0.9 * lowest else idle + 1
        if now < lowest:
            for i in range(k):
                for c in range(3):
                    r[i, c] = tried[i, c]
            lowest = now
        if lowest <= aim or idle > (0 if lowest <= tolerance else 2):
            return lowest, used + 1, False
    return lowest, most, True
