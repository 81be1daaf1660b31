"""What the textbook's first-order methods make of a mechanical system q'' = a(q, q'), for bounds on errors that shrink with dt.

A first-order method follows, to second order in dt, the exact equations with a defect added (backward error analysis: Hairer,
Lubich, Wanner, Geometric Numerical Integration, chapter IX): -/+ (dt/2) da/dt in the rates, for forces taken at the start or at
the end of the step, and +/- (dt/2) a in the coordinates, moved by new or by old rates.
"""

from collections.abc import Callable, Iterator, Sequence
from functools import partial

import numpy as np

from plumbline.harness.trajectory import Floats

FIRST_ORDER = (
    "twice the error, to first order in dt, of the worst of the four textbook first-order methods (forces of the start or of "
    "the end of a step, moved by new or old rates) in this very motion; the factor 2 leaves room for terms of second order"
)

Acceleration = Callable[[Floats, Floats], Floats]
"""(q (n,), q' (n,)) to q'' (n,)."""


def true_motion(acceleration: Acceleration, q: Sequence[float], rate: Sequence[float], times: Floats, rtol: float) -> Floats:
    """Coordinates and rates at ascending times from 0 on, (t, 2 n), by Dormand and Prince's method of order 8.

    Raises: RuntimeError where the integration stops.
    """
    return _solve(lambda q, v: (v, acceleration(q, v)), q, rate, times, rtol)


def first_order_motions(
    acceleration: Acceleration, q: Sequence[float], rate: Sequence[float], times: Floats, small: float = 1e-5
) -> Iterator[Floats]:
    """Coordinates and rates, (t, 2 n), of the four methods at the step `small` [s], to first order in it."""
    step = 1e-5

    def defective(q: Floats, v: Floats, forces: float, moving: float) -> tuple[Floats, Floats]:
        a = acceleration(q, v)
        ahead, behind = (acceleration(q + s * v, v + s * a) for s in (step, -step))
        return v + moving * small / 2 * a, a + forces * small / 2 * (ahead - behind) / (2 * step)

    for forces in (-1.0, 1.0):
        for moving in (-1.0, 1.0):
            yield _solve(partial(defective, forces=forces, moving=moving), q, rate, times, 1e-11)


def _solve(
    change: Callable[[Floats, Floats], tuple[Floats, Floats]],
    q: Sequence[float],
    rate: Sequence[float],
    times: Floats,
    rtol: float,
) -> Floats:
    from scipy.integrate import solve_ivp  # late: a listing must not pay for it

    if len(times) == 0:
        return np.zeros((0, 2 * len(q)))
    n = len(q)
    solution = solve_ivp(
        lambda _t, y: np.concatenate(change(y[:n], y[n:])),
        (0.0, max(float(times[-1]), 1e-9)),
        [*q, *rate],
        "DOP853",
        t_eval=times,
        rtol=rtol,
        atol=rtol * 1e-1,
    )
    if not solution.success:
        raise RuntimeError(f"the reference integration stopped: {solution.message}")
    y: Floats = solution.y.T
    return y
