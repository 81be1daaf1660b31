"""Path tracing on Coulomb's law by arc length, around the turns where following by width alone has to stop.

Where sliding feeds back into the normal velocities a path may turn: no solution near by exists for a smaller width; the path
goes back to larger ones before it comes down again. Traced by its arc length in (x, log w) it passes such turns. The smoothing

    y = (W + w^2) x + q + (|y_T|^2 / sqrt(|y_T|^2 + b^2), 0, 0),    F = p(x - y) - x = 0

is convex for large widths, where it has one solution, so that the path from there leads down. On the path x o y = w^2: impulses
of order one go with velocities of order w^2, so that w^2 is the natural width b of sliding, and the weight that keeps jammed
impulses bounded; with them the limit is inside the cones wherever they have room. Another b = w^power is another path. A change
counts relative to a contact's own impulse, since a bearing one is of order one and an open one of order w^2.

With c = p(z) - z, F is p - x where a contact is open and c - y where it bears, and 1 - dp/dz comes from c alone: differences of
large numbers would cost the digits that decide who slips.

Source: Allgower, Georg, Introduction to Numerical Continuation Methods, SIAM 2003, chapters 2 and 6; Fukushima, Luo, Tseng,
SIAM J. Optim. 12, 2002 (smoothing).
"""

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import get_lapack_funcs

from plumbline.engine.compile.jit import entry, kernel
from plumbline.engine.maths.elementary import exp, hypot, log
from plumbline.engine.maths.rows import Floats, Ints, Sym, load3, store3
from plumbline.engine.maths.vec import axpy, scale, sub, sym_vec
from plumbline.engine.respond.exact.effort import TRACED, Effort

MISS, RATE, SIZE, ENDS, ROOM, COLUMNS = 0, 3, 6, 7, 10, 13
"""Of what is said of a contact: F (3), dF / d log w (3), the size of its impulse, F on the ends of its frame (3), and what room
each has to the boundary of the cone (3)."""
ROUND_OFF = 2.0 * 2.0**-52


@kernel
def root_of(value: float, width: float) -> tuple[float, float]:
    """As `cone.root`, of one number."""
    length = 0.5 * (abs(value) + math.sqrt(value * value + 4.0 * width * width))
    other = width * width / max(length, 1e-300)
    return (length, other) if value >= 0.0 else (other, length)


@kernel
def on_frame(low: float, high: float, across: float, t1: float, t2: float) -> Sym:
    """The matrix with these eigenvalues on the ends (1, -t), (1, t) of a frame and across it."""
    mean, half = 0.5 * (low + high), 0.5 * (high - low)
    one, two = mean * t1 * t1 + across * t2 * t2, mean * t2 * t2 + across * t1 * t1
    return mean, one, two, half * t1, half * t2, (mean - across) * t1 * t2


@entry
def look_at(w: Floats, q: Floats, rubs: Ints, x: Floats, widths: tuple[float, float], slope: Floats, out: Floats) -> float:
    """Write -dF/dx into `slope` (3k, 3k), and what there is of each contact into `out` (k, COLUMNS).

    Args: w (3k, 3k), q (k, 3), x (k, 3): as `look`; rubs (k,): 1 with friction; widths: w, and the power of it that is
        the width of sliding.
    Returns: how far the point is from the path.
    """
    k = len(x)
    n, width, power = 3 * k, widths[0], widths[1]
    soft, dim = width * width, exp(power * log(width))
    largest = 0.0
    for i in range(k):
        impulse = load3(x, i, 0)
        y = axpy(soft, impulse, load3(q, i, 0))
        for j in range(k):
            for c in range(3):
                y = axpy(x[j, c], load3(w, 3 * j + c, 3 * i), y)
        if rubs[i] == 0:
            y = (y[0], 0.0, 0.0)
        square = y[1] * y[1] + y[2] * y[2]
        size = math.sqrt(square + dim * dim)
        blur = (dim / size) ** 2
        lift1, lift2 = y[1] / size * (1.0 + blur), y[2] / size * (1.0 + blur)
        if rubs[i] == 1:
            y = (y[0] + square / size, y[1], y[2])
        z = sub(impulse, y)
        largest = max(largest, abs(z[0]), abs(z[1]), abs(z[2]))
        length = hypot(z[1], z[2])
        t1, t2 = (z[1] / length, z[2] / length) if length > 0.0 else (1.0, 0.0)
        low, high = z[0] - length, z[0] + length
        p_low, c_low = root_of(low, width)
        p_high, c_high = root_of(high, width)
        if impulse[0] < y[0]:
            half = 0.5 * (p_high - p_low)
            miss = sub((0.5 * (p_low + p_high), half * t1, half * t2), impulse)
        else:
            half = 0.5 * (c_high - c_low)
            miss = sub((0.5 * (c_low + c_high), half * t1, half * t2), y)
        # dp/dz, and 1 - dp/dz from its own eigenvalues, which would cancel in the difference.
        p_across, c_across = p_low + p_high, c_low + c_high
        all_low, all_high, all_across = p_low + c_low, p_high + c_high, p_across + c_across
        bears = on_frame(p_low / all_low, p_high / all_high, p_across / all_across, t1, t2)
        opens = on_frame(c_low / all_low, c_high / all_high, c_across / all_across, t1, t2)
        for c in range(n):
            r0, r1, r2 = w[3 * i, c], w[3 * i + 1, c], w[3 * i + 2, c]
            if c // 3 == i:
                r0 += soft if c == 3 * i else 0.0
                r1 += soft if c == 3 * i + 1 else 0.0
                r2 += soft if c == 3 * i + 2 else 0.0
            column = sym_vec(bears, (r0 + lift1 * r1 + lift2 * r2, r1, r2))
            slope[3 * i, c], slope[3 * i + 1, c], slope[3 * i + 2, c] = column
        for c in range(3):
            column = sym_vec(opens, (1.0 if c == 0 else 0.0, 1.0 if c == 1 else 0.0, 1.0 if c == 2 else 0.0))
            for d in range(3):
                slope[3 * i + d, 3 * i + c] += column[d]
        s0, s1, s2 = scale(2.0 * soft, impulse)
        if rubs[i] == 1:
            s0 += lift1 * s1 + lift2 * s2 - power * square / size * blur
        r_low, r_high = 2.0 * soft / hypot(low, 2.0 * width), 2.0 * soft / hypot(high, 2.0 * width)
        half = 0.5 * (r_high - r_low)
        store3(out, i, RATE, sub((0.5 * (r_low + r_high), half * t1, half * t2), sym_vec(bears, (s0, s1, s2))))
        store3(out, i, MISS, miss)
        out[i, SIZE] = p_high
        along = miss[1] * t1 + miss[2] * t2
        store3(out, i, ENDS, (miss[0] - along, miss[0] + along, miss[2] * t1 - miss[1] * t2))
        store3(out, i, ROOM, (min(p_low, c_low), min(p_high, c_high), min(p_across, c_across)))
    off = 0.0
    for i in range(k):
        for c in range(3):
            share = abs(out[i, ENDS + c]) / (out[i, ROOM + c] + ROUND_OFF * (0.2 + largest))
            if math.isnan(share):
                return math.nan
            off = max(off, share)
    return off


(gesv,) = get_lapack_funcs(("gesv",), dtype=np.float64)

WIDEST, NARROWEST = 10.0, 1e-8
"""Widths, in units of the largest free velocity, where the path starts and ends."""
CENTRED = 0.1
"""How far, relative to its distance from the boundary of the cone, a contact may be off the path."""
SHORTEST, LONGEST = 1e-7, 3.0
"""Arc length of a step below which the path is given up, and the largest change of log w in one step."""
MOST = 800
"""Matrices of a path."""
TRIES = 8
"""Newton steps allowed to come back to the path, and how the arc length changes after each number of them."""
PACE = (2.0, 2.0, 2.0, 1.3, 1.3, 1.0, 0.7, 0.7, 0.7)


@dataclass(frozen=True, slots=True)
class PathPoint:
    """A point of the path.

    Terms:
        x, drift (k, 3): scaled impulses and their derivative along the path, dx / d log w; width: w.
    """

    x: Floats
    drift: Floats
    width: float


@dataclass(frozen=True, slots=True)
class Local:
    """F (k, 3), -dF/dx (3k, 3k) and dF / d log w (k, 3) at a point; off: how far from the path; size (k,): of the impulses."""

    miss: Floats
    slope: Floats
    rate: Floats
    off: float
    size: Floats


def look(w: Floats, q: Floats, rubs: NDArray[np.bool_], x: Floats, width: float, power: float) -> Local:
    """F and its derivatives. Args: as `trace_path`; x (k, 3)."""
    slope, out = np.empty(w.shape), np.empty((len(x), COLUMNS))
    off = look_at(w, q, rubs.astype(np.int64), np.ascontiguousarray(x), (width, power), slope, out)
    return Local(out[:, MISS : MISS + 3], slope, out[:, RATE : RATE + 3], off, out[:, SIZE])


def trace_path(w: Floats, q: Floats, rubs: NDArray[np.bool_], power: float, effort: Effort) -> Iterator[PathPoint]:
    """Points of the path; ends where the path is lost.

    Args: w (3k, 3k) and q (k, 3) scaled to order one and to mu = 1; rubs (k,): contacts with friction; power: of w in the width
        of sliding; effort: what is left.
    """
    n, before = len(w), effort.matrices
    x = start(w, q, rubs, power, effort)
    used = effort.matrices - before
    here = look(w, q, rubs, x, WIDEST, power)
    unit, turn = np.repeat(here.size, 3), np.zeros(n + 1)
    log_width, arc, turn[n], count = math.log(WIDEST), 1.0, -1.0, 0
    matrix, right = np.empty((n + 1, n + 1)), np.empty(n + 1)

    def newton(at: Local, miss: Floats | float, along: float) -> Floats | None:
        """The change of (x / unit, log w) that makes up for a miss with this way along the path."""
        matrix[:n, :n], matrix[:n, n] = at.slope * unit, -at.rate.ravel()
        matrix[n, :n], matrix[n, n] = turn[:n] / n, turn[n]
        right[:n], right[n] = miss, along
        if not effort.take(TRACED):
            return None
        _, _, made, status = gesv(matrix, right)
        return made if status == 0 and np.isfinite(made).all() else None

    while used < MOST:
        made = newton(here, 0.0, 1.0)
        used += 1
        if made is None:
            return
        turn = made / math.sqrt(made[:n] @ made[:n] / n + made[n] ** 2)
        drift = (unit * made[:n]).reshape(-1, 3) / (made[n] or 1e-300)
        if used > count + 1 and log_width < math.log(WIDEST):
            yield PathPoint(x, drift, math.exp(log_width))
            count = used
        while arc > SHORTEST:
            step = min(arc, LONGEST / max(abs(turn[n]), 1e-9))
            # Along the path x is smooth in w^2, not in log w.
            bend = 2.0 * step * turn[n]
            way = step * (math.expm1(bend) / bend if abs(bend) > 1e-8 else 1.0)
            found, log_found, tries = x + way * (unit * turn[:n]).reshape(-1, 3), log_width + step * turn[n], 0
            last = math.inf
            while True:
                there = look(w, q, rubs, found, math.exp(log_found), power)
                lost = not math.isfinite(there.off) or (tries > 1 and there.off > 2.0 * last)
                if there.off <= CENTRED or tries == TRIES or lost:
                    break
                made, last = newton(there, there.miss.ravel(), 0.0), there.off
                used, tries = used + 1, tries + 1
                if made is None or abs(made[n]) > LONGEST:
                    break
                change = (unit * made[:n]).reshape(-1, 3)
                change[~rubs, 1:] = 0.0
                found, log_found = found + change, log_found + float(made[n])
            if there.off <= CENTRED:
                break
            arc *= 0.35
        else:
            return
        x, log_width, arc, here = found, log_found, step * PACE[tries], there
        turn[:n] *= unit / np.repeat(here.size, 3)
        unit = np.repeat(here.size, 3)
        if not math.log(NARROWEST) < log_width < math.log(10.0 * WIDEST):
            return


def start(w: Floats, q: Floats, rubs: NDArray[np.bool_], power: float, effort: Effort) -> Floats:
    """The point of the path (k, 3) at the widest width by Newton with a line search."""
    x = np.zeros(q.shape)
    x[:, 0] = WIDEST
    here = look(w, q, rubs, x, WIDEST, power)
    for _ in range(60):
        if here.off < 1e-2 or not effort.take(TRACED):
            break
        _, _, way, _ = gesv(here.slope, here.miss.ravel())
        way, size, before = way.reshape(-1, 3), 1.0, float((here.miss**2).sum())
        way[~rubs, 1:] = 0.0
        for _ in range(10):
            here = look(w, q, rubs, x + size * way, WIDEST, power)
            if float((here.miss**2).sum()) < (1.0 - 1e-4 * size) * before:
                break
            size *= 0.5
        x = x + size * way
    return x
