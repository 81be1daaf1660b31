"""De Saxce's correction as a fixed point around convex cone problems, with Anderson acceleration.

For given s = mu |u_T| Coulomb's law is the optimality of a convex problem with s added to the normal velocities; the s that its
solution returns is fed back. Velocities of a convex problem are unique, and it has no turns and no bad starts: through the
interior and then by smoothed Newton it is solved to 1e-13 of the largest free velocity, which shows who sticks, slips and opens
among motions of 1e-9.

Source: Acary, Cadoux, Lemarechal, Malick, A formulation of the linear discrete Coulomb friction problem via convex
optimization, ZAMM 91, 2011 (fixed point);
Walker, Ni, Anderson acceleration for fixed-point iterations, SIAM J. Numer. Anal. 49, 2011.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from plumbline.engine.maths.types import Floats
from plumbline.engine.respond.exact.blocks import FINE, Blocks
from plumbline.engine.respond.exact.convex import central_point, minimise
from plumbline.engine.respond.exact.effort import Effort
from plumbline.engine.respond.exact.scaled import Scaled

DEPTH = 10
"""Earlier iterates that the acceleration looks at."""
CENTRED, NARROWEST, MOST_CENTRED = 1e-7, 1e-13, 60
"""Widths, in units of the largest free velocity, at which the interior-point method hands over to Newton, and Newton ends;
and the rounds of the former."""


@dataclass(frozen=True, slots=True)
class Round:
    """The solution of one convex problem.

    Terms:
        x, y (k, 3): scaled impulses, and velocities with s on the normal.
    """

    x: Floats
    y: Floats


def rounds(scaled: Scaled, s: Floats, effort: Effort) -> Iterator[Round]:
    """The convex problems one after the other; ends when they are not finite or the effort is over.

    Args: s (k,): what |u_T| is at first.
    """
    blocks = Blocks(scaled.fine)
    tried: list[Floats] = []
    missed: list[Floats] = []
    while True:
        q = scaled.q.astype(FINE)
        q[:, 0] += s
        middle, width = central_point(blocks, q, CENTRED, MOST_CENTRED, effort)
        x = minimise(blocks, q, scaled.kept, middle, width, NARROWEST, effort)
        if not np.isfinite(x).all():
            return
        y = q + blocks.times(x)
        yield Round(x.astype(np.float64), y.astype(np.float64))
        if effort.over:
            return
        tried, missed = [*tried, s][-DEPTH - 1 :], [*missed, sliding(scaled.rubs, y) - s][-DEPTH - 1 :]
        s = np.maximum(accelerate(tried, missed), 0.0)


def sliding(rubs: NDArray[np.bool_], y: NDArray[np.floating]) -> Floats:
    """|u_T| (k,) of scaled velocities (k, 3), where friction is one."""
    return np.where(rubs, np.hypot(y[:, 1], y[:, 2]), 0.0).astype(np.float64)


def accelerate(tried: list[Floats], missed: list[Floats]) -> Floats:
    """The next iterate of a fixed point from earlier ones and their residuals (Anderson's type II)."""
    if len(tried) == 1:
        return tried[0] + missed[0]
    dx = np.stack([b - a for a, b in pairwise(tried)], axis=1)
    df = np.stack([b - a for a, b in pairwise(missed)], axis=1)
    gamma = np.linalg.lstsq(df, missed[-1], rcond=1e-10)[0]
    return np.asarray(tried[-1] + missed[-1] - (dx + df) @ gamma)
