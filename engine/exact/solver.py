"""The exact solve: four methods from the quickest to the most patient, each judged by the certificate alone.

1. Newton on Coulomb's law from the impulses that the contacts bring along (`finish`);
2. path following on Coulomb's law from the middle of the cones (`follow`), and 1 from its narrow part;
3. the path traced by arc length, around its turns (`trace`), and 1 and 2 from ever smaller widths of it;
4. De Saxce's fixed point around convex problems (`fixed_point`), and 1 after each round.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from engine.exact.finish import finishing_step
from engine.exact.fixed_point import rounds
from engine.exact.follow import follow_path
from engine.exact.law import Problem
from engine.exact.residual import relative_residual
from engine.exact.scaled import Scaled, scale_problem
from engine.exact.trace import trace_path

__all__ = ["Solution", "solve"]

FloatArray = NDArray[np.float64]

NEAR = 0.1
"""Residual below which Newton on Coulomb's law is tried."""
PROXIMAL = 1e-8
"""Weight of the distance to the last impulses in a step of that Newton, which vanishes with the step."""
MOST_STEPS, SHORTER = 12, (1.0, 0.5, 0.2, 0.05, 0.01)
"""How many steps it is given, and how much shorter they may be made."""
WIDTHS, SHARPEST, SHARP = (0.1, 1e-2), 1e-13, 3e-6
"""First widths of the paths, their last one, and that from which on 1 is tried, in units of the largest free velocity."""
NARROW, CLOSER, MOST_TRACED = 1e-3, 0.1, 800
"""Width of a traced path below which Newton is tried, how much narrower each time, and the matrices it may take."""
PATIENCE = 12
"""Rounds of the fixed point without halving the residual, after which it is given up."""


@dataclass(frozen=True, slots=True)
class Solution:
    """Impulses with their certificate.

    Terms:
        impulse (k, 3) N s in the frames of the contacts; residual: see `relative_residual`; rounds: of the fixed point; steps:
        of Newton, all methods together.
    """

    impulse: FloatArray
    residual: float
    rounds: int
    steps: int


@np.errstate(over="ignore", divide="ignore", invalid="ignore")  # a method that fails is seen by its residual
def solve(problem: Problem, tolerance: float = 1e-11, most: int = 40, guess: FloatArray | None = None) -> Solution:
    """Impulses under Signorini's and Coulomb's law.

    Args: tolerance: relative residual to stop at; most: rounds of the fixed point; guess: impulses (k, 3) N s to start from.
    Returns: the best impulses found, whether or not they meet the tolerance: their residual says.
    """
    best = np.zeros((problem.size, 3))
    lowest, steps = relative_residual(problem, best), 0
    if lowest <= tolerance or problem.speed == 0.0:
        return Solution(best, lowest, 0, 0)
    scaled = scale_problem(problem)
    if guess is not None:
        best, lowest, steps = finish(scaled, guess * scaled.scale / scaled.unit, tolerance)
    for width in WIDTHS:
        if lowest <= tolerance:
            break
        x = np.zeros((problem.size, 3))
        x[:, 0] = width
        x, residual, more = follow(scaled, x, width, tolerance)
        steps += more
        if residual < lowest:
            best, lowest = x, residual
    if lowest > tolerance:
        narrow = NARROW
        for x, width, more in trace_path(scaled.w, scaled.q, scaled.rubs, MOST_TRACED):
            steps += more
            if width < narrow:
                narrow = CLOSER * width
                for tried, residual, more in (finish(scaled, x, tolerance), follow(scaled, x, width, tolerance)):
                    steps += more
                    if residual < lowest:
                        best, lowest = tried, residual
                if lowest <= tolerance:
                    break
    count, idle = 0, 0
    if lowest > tolerance:
        for x, more in rounds(scaled, best if lowest < NEAR else np.zeros_like(best)):
            x, residual, last = finish(scaled, x, tolerance)
            count, steps = count + 1, steps + more + last
            idle = 0 if residual < 0.5 * lowest else idle + 1
            if residual < lowest:
                best, lowest = x, residual
            if lowest <= tolerance or idle > PATIENCE or count >= most:
                break
    return Solution(scaled.impulse(best), lowest, count, steps)


def follow(scaled: Scaled, x: FloatArray, width: float, tolerance: float) -> tuple[FloatArray, float, int]:
    """The best scaled impulses (k, 3) along the path from x and a width on, with residual and number of steps."""
    best, lowest, steps = x, np.inf, 0
    for point, sharp, more in follow_path(scaled.w, scaled.q, scaled.rubs, x, width, SHARPEST):
        x, steps = np.where(scaled.kept, point, 0.0), steps + more
        residual = scaled.residual(x)
        if residual < lowest:
            best, lowest = x, residual
        if sharp <= SHARP and lowest > tolerance:
            tried, residual, last = finish(scaled, x, tolerance)
            steps += last
            if residual < lowest:
                best, lowest = tried, residual
        if lowest <= tolerance:
            break
    return best, lowest, steps


def finish(scaled: Scaled, x: FloatArray, tolerance: float) -> tuple[FloatArray, float, int]:
    """The best scaled impulses (k, 3) of a few Newton steps on Coulomb's law from x, with residual and number of steps."""
    x = np.where(scaled.kept, x, 0.0)
    best, lowest, idle = x, scaled.residual(x), 0
    if not tolerance < lowest < NEAR:
        return best, lowest, 0
    regular = scaled.w + PROXIMAL * np.eye(scaled.w.shape[0])
    for count in range(MOST_STEPS):
        made = finishing_step(regular, scaled.q - PROXIMAL * x, scaled.rubs, x)
        if made is None:
            return best, lowest, count + 1
        size, now = 1.0, np.inf
        for shorter in SHORTER:
            now = scaled.residual(x + shorter * (made - x))
            if now < lowest:
                size = shorter
                break
        x = x + size * (made - x)
        idle = 0 if now < 0.9 * lowest else idle + 1
        if now < lowest:
            best, lowest = x, now
        if lowest <= tolerance or idle > 2:
            return best, lowest, count + 1
    return best, lowest, MOST_STEPS
