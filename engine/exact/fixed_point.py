"""De Saxce's correction as a fixed point around convex cone problems, with Anderson acceleration.

For given s = mu |u_T| Coulomb's law is the optimality of a convex problem with s added to the normal velocities; the s that its
solution returns is fed back.

Source: Acary, Cadoux, Lemarechal, Malick, A formulation of the linear discrete Coulomb friction problem via convex
optimization, ZAMM 91, 2011 (fixed point);
Walker, Ni, Anderson acceleration for fixed-point iterations, SIAM J. Numer. Anal. 49, 2011.
"""

from collections.abc import Iterator
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from engine.exact.blocks import Blocks
from engine.exact.interior import central_point
from engine.exact.newton import minimise
from engine.exact.scaled import Scaled

__all__ = ["rounds"]

FloatArray = NDArray[np.float64]

DEPTH = 10
"""Earlier iterates that the acceleration looks at."""
PROXIMAL = 1e-8
"""Weight of the distance to the last round's impulses, in units of a contact's own inverse mass. Where forces are not unique,
as in a jammed pile, it keeps them bounded; it vanishes with the change from round to round."""
WIDEST, NARROWEST = 1e-2, 1e-13
"""Widths of the smoothing, in units of the largest free velocity, between which Newton starts near by."""
CENTRED = 1e-7
"""Width at which the interior-point method hands over to Newton."""


def rounds(scaled: Scaled, x: FloatArray) -> Iterator[tuple[FloatArray, int]]:
    """Scaled impulses (k, 3) after each round, and its Newton steps; ends when they are not finite. Args: x: where to start."""
    blocks = Blocks(scaled.w + PROXIMAL * np.eye(scaled.w.shape[0]))
    width, goal = WIDEST, 1e-4
    tried: list[FloatArray] = []
    missed: list[FloatArray] = []
    s = sliding(scaled, x)
    while True:
        q = scaled.q - PROXIMAL * x
        q[:, 0] += s
        x, steps = convex(blocks, q, scaled.kept, x, width, goal)
        if not np.isfinite(x).all():
            return
        yield x, steps
        tried, missed = [*tried, s][-DEPTH - 1 :], [*missed, sliding(scaled, x) - s][-DEPTH - 1 :]
        s = np.maximum(accelerate(tried, missed), 0.0)
        miss = float(np.abs(missed[-1]).max())
        width = min(max(miss, 1e-9), WIDEST)
        goal = min(max(1e-4 * miss, NARROWEST), goal)


def sliding(scaled: Scaled, x: FloatArray) -> FloatArray:
    """|u_T| (k,) of scaled impulses, where friction is one."""
    u = scaled.q + (scaled.w @ x.ravel()).reshape(-1, 3)
    return np.where(scaled.rubs, np.hypot(u[:, 1], u[:, 2]), 0.0)


def convex(
    blocks: Blocks, q: FloatArray, kept: NDArray[np.bool_], x: FloatArray, width: float, goal: float
) -> tuple[FloatArray, int]:
    """One convex problem by Newton from near by or, where that fails, through the interior. Returns: impulses, steps."""
    near, error, steps = minimise(blocks, q, kept, x, width, goal, 40)
    if error <= 10.0 * goal:
        return near, steps
    middle, reached, more = central_point(blocks, q, max(goal, CENTRED), 60)
    far, missed, last = minimise(blocks, q, kept, middle, reached, goal, 40)
    return (far if missed < error else near), steps + more + last


def accelerate(tried: list[FloatArray], missed: list[FloatArray]) -> FloatArray:
    """The next iterate of a fixed point from earlier ones and their residuals (Anderson's type II)."""
    if len(tried) == 1:
        return tried[0] + missed[0]
    dx = np.stack([b - a for a, b in pairwise(tried)], axis=1)
    df = np.stack([b - a for a, b in pairwise(missed)], axis=1)
    gamma = np.linalg.lstsq(df, missed[-1], rcond=1e-10)[0]
    return np.asarray(tried[-1] + missed[-1] - (dx + df) @ gamma)
