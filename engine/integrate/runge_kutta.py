"""Explicit Runge-Kutta methods by their tables: Euler's, the classical one of order four, and Dormand and Prince's pair.

    k_i = f(y + h sum_j a_ij k_j),  y <- y + h sum_i b_i k_i

*Explicit Euler* and *Dormand-Prince* know a body that nothing touches by y = (p, v, q, m), m the angular momentum in the body's
principal frame. Euler's method is of first order, and a free top gains energy. The pair of orders 5 and 4 adapts its steps,

    e = h sum_i e_i k_i,  accept if |e| <= tolerance,  h <- h clip(0.9 (tolerance / |e|)^(1/5), 0.2, 5)

with an error relative to |v|, |q| and |m|; that of p is the integral of that of v. Each body has its own step, kept from one dt
to the next, and lands on the end of dt exactly. The step depends on the state alone: the same input gives the same bits.

*RK4* knows it by (p, q, v, L): p' = v,  q' = w q / 2,  v' = g + f/m - c v,  L' = tau - c L,  w = I(q)^-1 L.

Source: Euler, Institutionum calculi integralis I (1768), section 650; Hairer, Norsett, Wanner, Solving Ordinary Differential
Equations I, sections I.7 (Euler) and II.1 with table 1.2 (1901, Kutta), table II.5.2 and equation (II.4.13); Dormand, Prince,
J. Comput. Appl. Math. 6 (1980) 19.
"""

import math
from collections.abc import Callable
from typing import Any, Final, NamedTuple

import numpy as np

from plumbline.engine.compile.jit import entry, kernel
from plumbline.engine.integrate.free_body import Law, from_principal, is_pushed, law_of, spin_rates, to_principal
from plumbline.engine.integrate.free_steps import advance_free
from plumbline.engine.integrate.semi_implicit_euler import angular_momentum, turn_inertia
from plumbline.engine.maths.elementary import fifth_root
from plumbline.engine.maths.rows import Floats, Ints, Quat, Sym, Vec, load3, load4, load6, store3, store4
from plumbline.engine.maths.vec import add, axpy, mat_vec, quat_mat, quat_mul, quat_turn, quat_unit, scale, sym_vec, tmat_vec
from plumbline.engine.memory import arena as at
from plumbline.engine.memory.tables import Bodies

RK4: Final = np.array(
    [[0, 0, 0, 0, 0], [1 / 2, 0, 0, 0, 1 / 2], [0, 1 / 2, 0, 0, 1 / 2], [0, 0, 1, 0, 1], [1 / 6, 1 / 3, 1 / 3, 1 / 6, 1]]
)
"""Of each stage a_ij, and where in a step it is; the weights of the end last."""
DORMAND_PRINCE: Final = np.array(
    [
        [0, 0, 0, 0, 0, 0, 0],
        [1 / 5, 0, 0, 0, 0, 0, 1 / 5],
        [3 / 40, 9 / 40, 0, 0, 0, 0, 3 / 10],
        [44 / 45, -56 / 15, 32 / 9, 0, 0, 0, 4 / 5],
        [19372 / 6561, -25360 / 2187, 64448 / 6561, -212 / 729, 0, 0, 8 / 9],
        [9017 / 3168, -355 / 33, 46732 / 5247, 49 / 176, -5103 / 18656, 0, 1],
        [35 / 384, 0, 500 / 1113, 125 / 192, -2187 / 6784, 11 / 84, 1],
    ]
)
"""As `RK4`: of its last stage, which lies at the end, the next step's first slope."""
E: Final = np.array([71 / 57600, 0, -71 / 16695, 71 / 1920, -17253 / 339200, 22 / 525, -1 / 40])
"""The difference of the weights of orders five and four."""
RK4_STAGES: Final = 4
STAGES: Final = 7
MOST_TRIALS = 100_000

Y_V: Final = 3
Y_Q: Final = 6
Y_M: Final = 10
LENGTH: Final = 13


class Trial(NamedTuple):
    """What a trial step works on: y (2 rows: at its start, and where it comes to) and the slopes k (a row for each stage)."""

    y: Floats
    k: Floats


@kernel
def go_to_stage(trial: Trial, method: Floats, i: int, h: float) -> None:
    """Write y of stage i of a step h, or of its end, from the slopes of the stages before it. Args: method: as `RK4`."""
    y, k = trial.y, trial.k
    for j in range(k.shape[1]):
        y[1, j] = y[0, j]
    for s in range(i):
        if method[i, s] != 0.0:
            for j in range(k.shape[1]):
                y[1, j] += h * method[i, s] * k[s, j]


@kernel
def error_of(trial: Trial, h: float, first: int, last: int) -> tuple[float, float]:
    """Of the columns from first to last: |h sum e_i k_i|, and the larger of |y| before and after the step."""
    y, k, error, before, after = trial.y, trial.k, 0.0, 0.0, 0.0
    for j in range(first, last):
        e = 0.0
        for i in range(STAGES):
            e += E[i] * k[i, j]
        error += e * e
        before += y[0, j] * y[0, j]
        after += y[1, j] * y[1, j]
    return abs(h) * math.sqrt(error), math.sqrt(max(before, after))


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
def adapt(
    stride: float, end: float, tolerance: float, attempt: Callable[..., float], finish: Callable[..., bool], *system: Any
) -> float:
    """Advance a system by `end` seconds in as many steps as the tolerance asks for.

    Args: stride [s]: of the first step, 0 if none is known; attempt: (h, *system) -> the error of a step; finish: (h, taken,
        *system) -> whether it could be taken, or, where it is not, taken back.
    Returns: the stride of the step after them; -1 if they did not suffice.
    """
    stride, done, rejected = stride if stride > 0.0 else end, 0.0, False
    for _ in range(MOST_TRIALS):
        left = end - done
        cut = stride >= left
        h = left if cut else min(stride, 0.5 * left)
        taken, stride = next_stride(attempt(h, *system), tolerance, h, stride, cut, rejected)
        rejected = not taken
        if not finish(h, taken, *system):
            return -1.0
        if taken:
            done += h
            if cut:
                return stride
    return -1.0


@kernel
def write_rates(trial: Trial, row: int, i: int, law: Law) -> None:
    """Write f of a row of y as the slope of stage i: p' = v, v' = a - c v, and the rates of the spin."""
    y, k = trial.y, trial.k
    v = load3(y, row, Y_V)
    q1, m1 = spin_rates(load4(y, row, Y_Q), load3(y, row, Y_M), law)
    store3(k, i, 0, v)
    store3(k, i, Y_V, axpy(-law.c, v, law.a))
    store4(k, i, Y_Q, q1)
    store3(k, i, Y_M, m1)


@kernel
def attempt_free(h: float, trial: Trial, law: Law) -> float:
    """A trial step of a body. Returns: its error."""
    for i in range(1, STAGES):
        go_to_stage(trial, DORMAND_PRINCE, i, h)
        write_rates(trial, 1, i, law)
    worst = total = 0.0
    for first, last in ((Y_V, Y_Q), (Y_Q, Y_M), (Y_M, LENGTH)):
        error, size = error_of(trial, h, first, last)
        error = error / size if size > 0.0 else 0.0
        worst, total = max(worst, error), total + error
    # A sum is not finite if any part is not, while a maximum may pass it over.
    return worst if math.isfinite(total) else math.inf


@kernel
def finish_free(_h: float, taken: bool, trial: Trial, _law: Law) -> bool:
    """Begin the next step where this one came to, if it is taken. Returns: True."""
    if taken:
        for j in range(LENGTH):
            trial.y[0, j], trial.k[0, j] = trial.y[1, j], trial.k[STAGES - 1, j]
    return True


@kernel
def dormand_prince(
    bodies: Bodies, principal: Floats, setting: Floats, b: int, end: float, gyroscopic: int, trial: Trial
) -> bool:
    """Advance body b by `end` seconds in as many steps as its tolerance asks for. Returns: whether they sufficed."""
    state, y = bodies.state, trial.y
    if not is_pushed(state, bodies.kind, b, end):
        return True
    law = law_of(bodies, principal, setting, b, gyroscopic)
    q, m = to_principal(state, principal, b)
    store3(y, 0, 0, load3(state, b, at.P))
    store3(y, 0, Y_V, load3(state, b, at.V))
    store4(y, 0, Y_Q, q)
    store3(y, 0, Y_M, m)
    write_rates(trial, 0, 0, law)
    stride = adapt(principal[b, at.STRIDE], end, setting[0, at.STEP_TOLERANCE], attempt_free, finish_free, trial, law)
    if stride < 0.0:
        return False
    principal[b, at.STRIDE] = stride
    store3(state, b, at.P, load3(y, 0, 0))
    store3(state, b, at.V, load3(y, 0, Y_V))
    from_principal(state, principal, b, load4(y, 0, Y_Q), load3(y, 0, Y_M))
    return True


@kernel
def room_for_trials(length: int, stages: int) -> Trial:
    """Room for a step of so many numbers in so many stages."""
    return Trial(np.zeros((2, length)), np.zeros((stages, length)))


@entry
def step_dormand_prince(floats: Floats, ints: Ints, steps: int) -> tuple[int, int]:
    """Advance bodies that nothing touches. Returns: as `advance_free`."""
    return advance_free(floats, ints, steps, dormand_prince, room_for_trials(LENGTH, STAGES))


@kernel
def explicit_euler(bodies: Bodies, principal: Floats, setting: Floats, b: int, h: float, gyroscopic: int) -> bool:
    """Advance body b by h. Returns: True."""
    state = bodies.state
    if not is_pushed(state, bodies.kind, b, h):
        return True
    law, v = law_of(bodies, principal, setting, b, gyroscopic), load3(state, b, at.V)
    store3(state, b, at.P, axpy(h, v, load3(state, b, at.P)))
    store3(state, b, at.V, axpy(h, axpy(-law.c, v, law.a), v))
    q, m = to_principal(state, principal, b)
    q1, m1 = spin_rates(q, m, law)
    from_principal(state, principal, b, quat_axpy(h, q1, q), axpy(h, m1, m))
    return True


@entry
def step_explicit_euler(floats: Floats, ints: Ints, steps: int) -> tuple[int, int]:
    """Advance bodies that nothing touches. Returns: as `advance_free`."""
    return advance_free(floats, ints, steps, explicit_euler)


@kernel
def quat_rate(q: Quat, w: Vec) -> Quat:
    """q' = (0, w) q / 2."""
    return quat_mul((0.0, 0.5 * w[0], 0.5 * w[1], 0.5 * w[2]), q)


@kernel
def quat_axpy(s: float, a: Quat, b: Quat) -> Quat:
    """s a + b."""
    return s * a[0] + b[0], s * a[1] + b[1], s * a[2] + b[2], s * a[3] + b[3]


@kernel
def weighted(a: Quat, b: Quat, c: Quat, d: Quat) -> Quat:
    """a + 2 b + 2 c + d."""
    return quat_axpy(1.0, quat_axpy(1.0, a, d), quat_axpy(2.0, b, quat_axpy(1.0, c, c)))


@kernel
def spin_rate(q: Quat, inverse: Sym, momentum: Vec) -> Vec:
    """w = R I_B^-1 R^T L."""
    m = quat_mat(q)
    return mat_vec(m, sym_vec(inverse, tmat_vec(m, momentum)))


@kernel
def spin_slopes(q: Quat, m: Vec, inverse: Sym, tau: Vec, d: float, gyroscopic: int) -> tuple[Quat, Vec]:
    """q' and m', m being L; without the gyroscopic effect it is w, which then stays where nothing turns the body."""
    if gyroscopic == 1:
        return quat_rate(q, spin_rate(q, inverse, m)), axpy(-d, m, tau)
    return quat_rate(q, m), axpy(-d, m, spin_rate(q, inverse, tau))


@kernel
def runge_kutta_free(bodies: Bodies, setting: Floats, b: int, dt: float, gyroscopic: int) -> None:
    """Advance body b by dt."""
    state, body, kind, load = bodies.state, bodies.body, bodies.kind, bodies.load
    p, q = load3(state, b, at.P), load4(state, b, at.Q)
    v, w = load3(state, b, at.V), load3(state, b, at.W)
    if kind[b, at.MOTION] == at.KINEMATIC:
        store3(state, b, at.P, axpy(dt, v, p))
        store4(state, b, at.Q, quat_turn(q, w, dt))
    if kind[b, at.MOTION] != at.DYNAMIC:
        return
    a = axpy(body[b, at.INV_MASS], load3(load, b, 0), load3(setting, 0, at.GRAVITY))
    c = body[b, at.LINEAR_DAMPING]
    if c == 0.0:
        store3(state, b, at.P, add(p, add(scale(dt, v), scale(0.5 * dt * dt, a))))
        store3(state, b, at.V, axpy(dt, a, v))
    else:
        v1 = axpy(-c, v, a)
        v2 = axpy(-c, axpy(0.5 * dt, v1, v), a)
        v3 = axpy(-c, axpy(0.5 * dt, v2, v), a)
        v4 = axpy(-c, axpy(dt, v3, v), a)
        store3(state, b, at.P, add(p, add(scale(dt, v), scale(dt * dt / 6.0, add(v1, add(v2, v3))))))
        store3(state, b, at.V, axpy(dt / 6.0, add(add(v1, v4), scale(2.0, add(v2, v3))), v))
    tau, d = load3(load, b, 3), body[b, at.ANGULAR_DAMPING]
    if tau == (0.0, 0.0, 0.0) and d == 0.0 and (body[b, at.ROUND] == 1.0 or w == (0.0, 0.0, 0.0)):
        store4(state, b, at.Q, quat_turn(q, w, dt))
    else:
        inverse = load6(body, b, at.INV_INERTIA)
        m = angular_momentum(state, body, b) if gyroscopic == 1 else w
        q1, (_, m1) = quat_rate(q, w), spin_slopes(q, m, inverse, tau, d, gyroscopic)
        q2, m2 = spin_slopes(quat_axpy(0.5 * dt, q1, q), axpy(0.5 * dt, m1, m), inverse, tau, d, gyroscopic)
        q3, m3 = spin_slopes(quat_axpy(0.5 * dt, q2, q), axpy(0.5 * dt, m2, m), inverse, tau, d, gyroscopic)
        q4, m4 = spin_slopes(quat_axpy(dt, q3, q), axpy(dt, m3, m), inverse, tau, d, gyroscopic)
        m = axpy(dt / 6.0, add(add(m1, m4), scale(2.0, add(m2, m3))), m)
        q = quat_unit(quat_axpy(dt / 6.0, weighted(q1, q2, q3, q4), q))
        store4(state, b, at.Q, q)
        store3(state, b, at.W, spin_rate(q, inverse, m) if gyroscopic == 1 else m)
    turn_inertia(state, body, bodies.turned, b)
