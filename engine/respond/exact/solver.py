"""The exact solve: three methods from the quickest to the most patient, each judged by the certificate alone.

1. Newton on Coulomb's law from the impulses that the contacts bring along (`finish`);
2. paths traced by arc length, around their turns (`trace`), and from ever smaller widths 1, 1 with velocities weighed higher,
   for contacts that slip slowly under large impulses, and Newton with the modes of the contacts that the path shows (`settle`);
3. De Saxce's fixed point around convex problems (`convex`), solved in extended precision and begun from the sliding of
   the best so far, from none and from that of free motion; and after each round 1 and Newton with its modes.

A method runs where those before it missed, and the answer with the least residual is returned: one method more can only help.
All together may cost what the `effort` says, counted in matrices and not by a clock; what is then best is the answer.

What is certified is the residual of the answer, whoever found it. A solve may miss its tolerance after all methods, which takes
seconds: a converged truth waits for that, and is refused on it. A world has 50 ms a solve, unless told otherwise; misses are
counted in `World.certificate`. Of 2988 solves of twenty piles of four boxes with masses from 1 to 1e4 kg between walls, 14
need more than paths; two of these end above 1e-11, at 2.3e-11 and 1.1e-11. Within 50 ms 169 do, the worst at .3.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np

from plumbline.engine.maths.types import Floats, Ints
from plumbline.engine.respond.exact.convex import rounds, sliding
from plumbline.engine.respond.exact.effort import UNBOUNDED, Effort
from plumbline.engine.respond.exact.finish import finish_from
from plumbline.engine.respond.exact.law import Problem, Scaled, relative_residual, scale_problem
from plumbline.engine.respond.exact.settle import OPEN, modes_between, modes_of, settling_step
from plumbline.engine.respond.exact.trace import trace_path

Answer: TypeAlias = tuple[Floats, float]
"""Impulses (k, 3) N s that a method found, and their residual."""

NEAR = 0.1
"""Residual below which Newton on Coulomb's law is tried."""
PLAIN = (1.0, 1e-8)
"""What it weighs velocities with against impulses, and the distance to the last impulses, which vanishes with the step."""
SHARPER = ((1e4, 1e-8), (1e6, 1e-11), (1e2, 1e-8), (1e6, 1e-8), (1e4, 1e-11))
"""The same where contacts slip so slowly beside their impulses that they are taken for sticking."""
MOST_STEPS = 12
"""How many steps it is given."""
SETTLED = 0.1
"""Share of the tolerance down to which impulses that are brought along are made better. What velocities err by is made up for
by the impulses of the next step, which then are wrong for the one after: accepted, they would have to be solved for in
turns."""
NARROW, CLOSER = 1e-2, 0.3
"""Width of a traced path below which Newton is tried, and how much narrower each time."""
POWERS = (2.0, 0.5, 0.75)
"""Powers of w in the width of sliding, of the paths: where one is lost, another may lead on."""
HELD, MOST_SETTLED = 1e-12, 8
"""Weight of the distance to the last impulses in Newton with given modes, and how many steps it is given."""
EARLY = 4
"""Rounds of the fixed point from each start; most that converge do so in the first few."""
PATIENCE = 12
"""Rounds of the fixed point without halving the residual, after which it is given up."""


@dataclass(frozen=True, slots=True)
class Solution:
    """Impulses with their certificate.

    Terms:
        impulse (k, 3) N s in the frames of the contacts; residual: see `relative_residual`; matrices: factorised
        by all methods together.
    """

    impulse: Floats
    residual: float
    matrices: int


@dataclass(slots=True)
class Search:
    """What every method works on: the problem, the residual to stop at, and the effort that is left; and the best so far."""

    scaled: Scaled
    tolerance: float
    effort: Effort
    best: Floats
    lowest: float


def solve(
    problem: Problem, tolerance: float = 1e-11, most: int = 40, guess: Floats | None = None, effort: float = UNBOUNDED
) -> Solution:
    """Impulses under Signorini's and Coulomb's law.

    Args: tolerance: relative residual to stop at; most: rounds of the fixed point; guess: impulses (k, 3) N s to start from;
        effort [ms]: what may be spent, counted as `Effort` does.
    Returns: the best impulses found, whether or not they meet the tolerance: their residual says.
    """
    spent, best = Effort(effort, 3 * problem.size), np.zeros((problem.size, 3))
    if guess is not None and problem.speed > 0.0:
        near, aims = np.array(guess), (tolerance, SETTLED * tolerance, NEAR)
        lowest, used, wanted = finish_from(problem.tables, near, PLAIN, aims, spent.most(MOST_STEPS))
        spent.took(used, wanted)
        if lowest <= tolerance:
            return Solution(near, lowest, spent.matrices)
    none = relative_residual(problem, best)
    if none <= tolerance or problem.speed == 0.0:
        return Solution(best, none, spent.matrices)
    search = Search(scale_problem(problem), tolerance, spent, best, none)
    if guess is not None and lowest < none:
        search.best, search.lowest = near, lowest
    with np.errstate(over="ignore", divide="ignore", invalid="ignore"):  # a method that fails is seen by its residual
        for impulse, residual in () if spent.over else answers(search, most):
            if residual < search.lowest:
                search.best, search.lowest = impulse, residual
            if search.lowest <= tolerance or spent.over:
                break
    return Solution(search.best, search.lowest, spent.matrices)


def answers(search: Search, most: int) -> Iterator[Answer]:
    """What the methods find, one after the other. Args: most: as `solve`."""
    for power in POWERS:
        yield from trace(search, power)
    scaled = search.scaled
    begun = sliding(scaled.rubs, scaled.q + (scaled.w @ (search.best * scaled.scale / scaled.unit).ravel()).reshape(-1, 3))
    free = sliding(scaled.rubs, scaled.q)
    for start, rounds_of_it in ((begun, EARLY), (np.zeros_like(free), EARLY), (free, EARLY), (begun, most)):
        yield from relax(search, start, min(rounds_of_it, most))


def trace(search: Search, power: float) -> Iterator[Answer]:
    """From ever narrower points of the traced path, and where it is lost, its last one. Args: as `trace_path`."""
    scaled, narrow, last = search.scaled, NARROW, np.zeros_like(search.best)
    for point in trace_path(scaled.w, scaled.q, scaled.rubs, power, search.effort):
        last = point.x
        if point.width < narrow:
            narrow = CLOSER * point.width
            for answer in nearby(search, point.x, modes_of(scaled.rubs, point.x, point.drift)):
                yield answer
                for weights in SHARPER:
                    yield finish(search, answer[0], weights)
    yield finish(search, scaled.impulse(last))


def relax(search: Search, s: Floats, most: int) -> Iterator[Answer]:
    """By rounds of the fixed point from sliding s (k,)."""
    lowest, idle = np.inf, 0
    for count, (x, y) in enumerate(rounds(search.scaled, s, search.effort)):
        before = lowest
        for answer in nearby(search, x, modes_between(search.scaled.rubs, x, y)):
            lowest = min(lowest, answer[1])
            yield answer
        idle = 0 if lowest < 0.5 * before else idle + 1
        if idle > PATIENCE or count + 1 >= most:
            break


def nearby(search: Search, near: Floats, mode: Ints) -> Iterator[Answer]:
    """By Newton on Coulomb's law from scaled impulses near by, and with the modes (k,) of the contacts."""
    scaled = search.scaled
    yield finish(search, scaled.impulse(near))
    regular = scaled.w + HELD * np.eye(scaled.w.shape[0])
    x = np.where(scaled.kept & (mode != OPEN)[:, None], near, 0.0)
    best, lowest, idle, count = x, scaled.residual(x), 0, 0
    while lowest > search.tolerance and idle <= 3 and count < MOST_SETTLED and search.effort.take():
        made = settling_step(regular, scaled.q - HELD * x, scaled.rubs, mode, x)
        count += 1
        if made is None:
            break
        x, now = made, scaled.residual(made)
        idle = 0 if now < 0.5 * lowest else idle + 1
        if now < lowest:
            best, lowest = x, now
    yield scaled.impulse(best), lowest


def finish(search: Search, impulse: Floats, weights: tuple[float, float] = PLAIN) -> Answer:
    """By a few Newton steps on Coulomb's law from impulses (k, 3) N s."""
    found, aims = impulse.copy(), (search.tolerance, search.tolerance, NEAR)
    lowest, used, wanted = finish_from(search.scaled.problem.tables, found, weights, aims, search.effort.most(MOST_STEPS))
    search.effort.took(used, wanted)
    return found, lowest
