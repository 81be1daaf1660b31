"""Dormand and Prince's embedded pair of orders 5 and 4 with adaptive steps, for bodies that nothing touches.

    k_i = f(y + h sum_j a_ij k_j),  y <- y + h sum_i a_7i k_i,  e = h sum_i e_i k_i
    accept if |e| <= tolerance,  h <- h clip(0.9 (tolerance / |e|)^(1/5), 0.2, 5)

State y = (p, v, q, m), m the angular momentum in the body's principal frame. The error is relative to |v|, |q| and |m|; that of
p is the integral of that of v. Each body has its own step, kept from one dt to the next, and lands on the end of dt exactly.
The step depends on the state alone, so that the same input gives the same bits.

Source: Dormand, Prince, J. Comput. Appl. Math. 6 (1980) 19; Hairer, Norsett, Wanner, Solving Ordinary Differential Equations I,
table II.5.2 and equation (II.4.13).
"""

import math
from typing import Final, NamedTuple

import numpy as np

from plumbline.engine.compile.jit import entry, kernel
from plumbline.engine.integrate.free_body import Law, from_principal, is_pushed, law_of, spin_rates, to_principal
from plumbline.engine.integrate.free_steps import advance_free
from plumbline.engine.maths.elementary import fifth_root
from plumbline.engine.maths.rows import Floats, Ints, load3, load4, store3, store4
from plumbline.engine.maths.vec import axpy
from plumbline.engine.memory import arena as at
from plumbline.engine.memory.tables import Bodies

STAGES: Final = 7
A: Final = np.array(
    [
        [0, 0, 0, 0, 0, 0],
        [1 / 5, 0, 0, 0, 0, 0],
        [3 / 40, 9 / 40, 0, 0, 0, 0],
        [44 / 45, -56 / 15, 32 / 9, 0, 0, 0],
        [19372 / 6561, -25360 / 2187, 64448 / 6561, -212 / 729, 0, 0],
        [9017 / 3168, -355 / 33, 46732 / 5247, 49 / 176, -5103 / 18656, 0],
        [35 / 384, 0, 500 / 1113, 125 / 192, -2187 / 6784, 11 / 84],
    ]
)
E: Final = np.array([71 / 57600, 0, -71 / 16695, 71 / 1920, -17253 / 339200, 22 / 525, -1 / 40])
"""The difference of the weights of orders five and four."""

Y_P: Final = 0
Y_V: Final = 3
Y_Q: Final = 6
Y_M: Final = 10
LENGTH: Final = 13
MOST_TRIALS = 100_000


class Trial(NamedTuple):
    """What a trial step works on, LENGTH columns each: y (1 row), the new y (1 row), and the rates k (STAGES rows)."""

    y: Floats
    new: Floats
    k: Floats


@kernel
def rates(y: Floats, k: Floats, i: int, law: Law) -> None:
    """Write f(y) into row i of k: p' = v, v' = a - c v, and the rates of the spin."""
    v = load3(y, 0, Y_V)
    q1, m1 = spin_rates(load4(y, 0, Y_Q), load3(y, 0, Y_M), law)
    store3(k, i, Y_P, v)
    store3(k, i, Y_V, axpy(-law.c, v, law.a))
    store4(k, i, Y_Q, q1)
    store3(k, i, Y_M, m1)


@kernel
def largest_error(trial: Trial, h: float, first: int, last: int) -> float:
    """|h sum e_i k_i| over the larger of |y| before and after the step, of the columns from first to last; 0 if all vanish."""
    y, new, k = trial.y, trial.new, trial.k
    error = before = after = 0.0
    for j in range(first, last):
        e = 0.0
        for i in range(STAGES):
            e += E[i] * k[i, j]
        error += e * e
        before += y[0, j] * y[0, j]
        after += new[0, j] * new[0, j]
    size = max(before, after)
    return abs(h) * math.sqrt(error / size) if size > 0.0 else 0.0


@kernel
def next_stride(error: float, tolerance: float, h: float, stride: float, cut: bool, rejected: bool) -> tuple[bool, float]:
    """Whether a step h is accepted, and how long the next one should be.

    Args: stride: how long this one should have been; cut: whether the end of dt cut it short; rejected: whether the last was.
    """
    finite = math.isfinite(error)
    factor = 0.2
    if finite:
        factor = min(5.0, 0.9 * fifth_root(tolerance / error)) if error > 0.0 else 5.0
    if not finite or error > tolerance:
        return False, h * max(0.2, factor)
    # A step cut short by the end of dt says nothing against the longer one that was meant.
    return True, max(stride, h * factor) if cut else h * (min(factor, 1.0) if rejected else factor)


@kernel
def dormand_prince(
    bodies: Bodies, principal: Floats, setting: Floats, b: int, end: float, gyroscopic: int, trial: Trial
) -> bool:
    """Advance body b by `end` seconds in as many steps as its tolerance asks for. Returns: whether they sufficed."""
    state = bodies.state
    if not is_pushed(state, bodies.kind, b, end):
        return True
    law = law_of(bodies, principal, setting, b, gyroscopic)
    y, new, k = trial.y, trial.new, trial.k
    q, m = to_principal(state, principal, b)
    store3(y, 0, Y_P, load3(state, b, at.P))
    store3(y, 0, Y_V, load3(state, b, at.V))
    store4(y, 0, Y_Q, q)
    store3(y, 0, Y_M, m)
    rates(y, k, 0, law)
    stride = principal[b, at.STRIDE] if principal[b, at.STRIDE] > 0.0 else end
    done, rejected = 0.0, False
    for _ in range(MOST_TRIALS):
        left = end - done
        cut = stride >= left
        h = left if cut else min(stride, 0.5 * left)
        for i in range(1, STAGES):
            for j in range(LENGTH):
                total = 0.0
                for s in range(i):
                    total += A[i, s] * k[s, j]
                new[0, j] = y[0, j] + h * total
            rates(new, k, i, law)
        error_v, error_q = largest_error(trial, h, Y_V, Y_Q), largest_error(trial, h, Y_Q, Y_M)
        error_m = largest_error(trial, h, Y_M, LENGTH)
        error = max(error_v, error_q, error_m)
        # A sum is not finite if any part is not, while a maximum may pass it over.
        error = error if math.isfinite(error_v + error_q + error_m) else math.inf
        accepted, stride = next_stride(error, setting[0, at.STEP_TOLERANCE], h, stride, cut, rejected)
        rejected = not accepted
        if accepted:
            done += h
            for j in range(LENGTH):
                y[0, j], k[0, j] = new[0, j], k[STAGES - 1, j]
            if cut:
                principal[b, at.STRIDE] = stride
                store3(state, b, at.P, load3(y, 0, Y_P))
                store3(state, b, at.V, load3(y, 0, Y_V))
                from_principal(state, principal, b, load4(y, 0, Y_Q), load3(y, 0, Y_M))
                return True
    return False


@entry
def step_dormand_prince(floats: Floats, ints: Ints, steps: int) -> tuple[int, int]:
    """Advance bodies that nothing touches. Returns: as `advance_free`."""
    trial = Trial(np.zeros((1, LENGTH)), np.zeros((1, LENGTH)), np.zeros((STAGES, LENGTH)))
    return advance_free(floats, ints, steps, dormand_prince, trial)
