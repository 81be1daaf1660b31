"""The exact solve: four methods from the quickest to the most patient, each judged by the certificate alone.

1. Newton on Coulomb's law from the impulses that the contacts bring along (`finish`);
2. paths traced by arc length, around their turns (`trace`), and from ever smaller widths 1, 1 with velocities weighed higher,
   for contacts that slip slowly under large impulses, and Newton with the modes of the contacts that the path shows (`settle`);
3. De Saxce's fixed point around convex problems (`fixed_point`), solved in extended precision and begun from the sliding of
   the best so far, from none and from that of free motion; and after each round 1 and Newton with its modes;
4. 3 again, longer and from random sliding, the same in every run.

A method runs where those before it missed, and the answer with the least residual is returned: one method more can only help.
All together may cost what the `effort` says, counted in matrices and not by a clock; what is then best is the answer.

What is certified is the residual of the answer, whoever found it. A solve may miss its tolerance after all methods, which takes
10 s or more: a converged truth waits for that, and is refused on it. A world has 50 ms a solve, unless told otherwise; misses
are counted in `World.certificate`. Of 2988 solves of twenty piles of four boxes with masses from 1 to 1e4 kg between walls, 24
need more than paths, and end within 9.2e-12; one misses. Within 50 ms 340 miss, the worst by .27. Of 1341 solves of further
piles one ends at 3.7e-11.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np

from plumbline.engine.maths.types import Floats, Ints
from plumbline.engine.respond.exact.effort import UNBOUNDED, Effort
from plumbline.engine.respond.exact.finish import finish_from
from plumbline.engine.respond.exact.fixed_point import rounds, sliding
from plumbline.engine.respond.exact.law import Problem, relative_residual
from plumbline.engine.respond.exact.scaled import Scaled, scale_problem
from plumbline.engine.respond.exact.settle import OPEN, modes_between, modes_of, settling_step
from plumbline.engine.respond.exact.trace import trace_path

Answer: TypeAlias = tuple[Floats, float]
"""The best scaled impulses (k, 3) that a method found, and their residual."""

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
POWERS = (2.0, 1.0, 1.5)
"""Powers of w in the width of sliding, of the paths: where one is lost, another may lead on."""
HELD, MOST_SETTLED = (1e-8, 1e-12), 8
"""Weights of the distance to the last impulses in Newton with given modes, and how many steps it is given."""
EARLY, LATE = 4, 8
"""Rounds of the fixed point from each start, and from each random one; most that converge do so in the first few."""
GUESSES, SEED, SLOWEST = 8, 1, 1e-5
"""Random starts of the fixed point at the end, of four kinds each, what they are drawn with, and their slowest sliding."""
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


def solve(
    problem: Problem, tolerance: float = 1e-11, most: int = 40, guess: Floats | None = None, effort: float = UNBOUNDED
) -> Solution:
    """Impulses under Signorini's and Coulomb's law.

    Args: tolerance: relative residual to stop at; most: rounds of the fixed point; guess: impulses (k, 3) N s to start from;
        effort [ms]: what may be spent, counted as `Effort` does.
    Returns: the best impulses found, whether or not they meet the tolerance: their residual says.
    """
    spent, near, brought = Effort(effort, 3 * problem.size), np.zeros((problem.size, 3)), np.inf
    if guess is not None and problem.speed > 0.0:
        near, aims = np.array(guess), (tolerance, SETTLED * tolerance, NEAR)
        brought, used, wanted = finish_from(problem.tables, near, PLAIN, aims, spent.most(MOST_STEPS))
        spent.took(used, wanted)
        if brought <= tolerance:
            return Solution(near, brought, spent.matrices)
    return by_all_methods(problem, tolerance, most, (near, brought), spent)


@np.errstate(over="ignore", divide="ignore", invalid="ignore")  # a method that fails is seen by its residual
def by_all_methods(problem: Problem, tolerance: float, most: int, near: tuple[Floats, float], spent: Effort) -> Solution:
    """By one method after the other. Args: near: impulses (k, 3) N s, and their residual; the others as of `solve`."""
    best = np.zeros((problem.size, 3))
    lowest = relative_residual(problem, best)
    if lowest <= tolerance or problem.speed == 0.0:
        return Solution(best, lowest, spent.matrices)
    scaled = scale_problem(problem)
    begun: Answer = (np.where(scaled.kept, near[0] * scaled.scale / scaled.unit, 0.0), near[1])
    if begun[1] < lowest:
        best, lowest = begun
    for x, residual in () if spent.over else answers(Search(scaled, tolerance, spent), most, begun):
        if residual < lowest:
            best, lowest = x, residual
        if lowest <= tolerance or spent.over:
            break
    impulse = scaled.impulse(best)
    return Solution(impulse, relative_residual(problem, impulse), spent.matrices)


@dataclass(frozen=True, slots=True)
class Search:
    """What every method works on: the problem, the residual to stop at, and the effort that is left for all."""

    scaled: Scaled
    tolerance: float
    effort: Effort


def answers(search: Search, most: int, near: Answer) -> Iterator[Answer]:
    """The answer of each method in turn. Args: most: as `solve`; near: what the impulses of the last solve led to."""
    scaled = search.scaled
    for power in POWERS:
        found = trace(search, power)
        yield found
        near = min(near, found, key=residual_of)
    yield sharpen(search, near[0])
    begun, free = sliding_of(scaled, near[0]), sliding_of(scaled, np.zeros_like(scaled.q))
    for start in (begun, np.zeros_like(free), free):
        yield relax(search, start, min(EARLY, most))
    yield relax(search, begun, most)
    draw = np.random.default_rng(SEED)
    for _ in range(GUESSES):
        share = draw.uniform(size=len(free))
        for start in (
            share * free,
            SLOWEST**share * free,
            np.where(share < 0.5, free, 0.0),
            np.full_like(free, SLOWEST ** share[0]),
        ):
            yield relax(search, start, min(LATE, most))


def residual_of(answer: Answer) -> float:
    """What answers are judged by."""
    return answer[1]


def sliding_of(scaled: Scaled, x: Floats) -> Floats:
    """|u_T| (k,) of scaled impulses."""
    return sliding(scaled.rubs, scaled.q + (scaled.w @ x.ravel()).reshape(-1, 3))


def trace(search: Search, power: float) -> Answer:
    """From ever narrower points of the traced path, and where it is lost, its last one. Args: as `trace_path`."""
    scaled, tolerance = search.scaled, search.tolerance
    best, lowest, narrow, last = np.zeros_like(scaled.q), np.inf, NARROW, np.zeros_like(scaled.q)
    for point in trace_path(scaled.w, scaled.q, scaled.rubs, power, search.effort):
        last = point.x
        if point.width < narrow:
            narrow = CLOSER * point.width
            mode = modes_of(scaled.rubs, point.x, point.drift)
            for x, residual in (finish(search, point.x), *settle(search, point.x, mode)):
                if residual > tolerance:
                    x, residual = sharpen(search, x)
                if residual < lowest:
                    best, lowest = x, residual
                if lowest <= tolerance:
                    return best, lowest
    return min((best, lowest), finish(search, last), key=residual_of)


def relax(search: Search, s: Floats, most: int) -> Answer:
    """By rounds of the fixed point from sliding s (k,)."""
    scaled, tolerance = search.scaled, search.tolerance
    best, lowest, idle = np.zeros_like(scaled.q), np.inf, 0
    for count, found in enumerate(rounds(scaled, s, search.effort)):
        before, mode = lowest, modes_between(scaled.rubs, found.x, found.y)
        for x, residual in (finish(search, found.x), *settle(search, found.x, mode)):
            if residual < lowest:
                best, lowest = x, residual
            if lowest <= tolerance:
                return best, lowest
        idle = 0 if lowest < 0.5 * before else idle + 1
        if idle > PATIENCE or count + 1 >= most:
            break
    return best, lowest


def sharpen(search: Search, x: Floats) -> Answer:
    """By Newton from x with velocities weighed higher."""
    best, lowest = x, search.scaled.residual(x)
    for weights in SHARPER:
        tried, residual = finish(search, x, weights)
        if residual < lowest:
            best, lowest = tried, residual
        if lowest <= search.tolerance:
            break
    return best, lowest


def settle(search: Search, near: Floats, mode: Ints) -> Iterator[Answer]:
    """By Newton from impulses near by with the modes (k,) of the contacts."""
    scaled = search.scaled
    for held in HELD:
        regular = scaled.w + held * np.eye(scaled.w.shape[0])
        x = np.where(scaled.kept & (mode != OPEN)[:, None], near, 0.0)
        best, lowest, idle, count = x, scaled.residual(x), 0, 0
        while lowest > search.tolerance and idle <= 3 and count < MOST_SETTLED and search.effort.take():
            made = settling_step(regular, scaled.q - held * x, scaled.rubs, mode, x)
            count += 1
            if made is None:
                break
            x, now = made, scaled.residual(made)
            idle = 0 if now < 0.5 * lowest else idle + 1
            if now < lowest:
                best, lowest = x, now
        yield best, lowest


def finish(search: Search, x: Floats, weights: tuple[float, float] = PLAIN) -> Answer:
    """By a few Newton steps on Coulomb's law from x."""
    scaled, r = search.scaled, search.scaled.impulse(x)
    aims = (search.tolerance, search.tolerance, NEAR)
    lowest, used, wanted = finish_from(scaled.problem.tables, r, weights, aims, search.effort.most(MOST_STEPS))
    search.effort.took(used, wanted)
    return r * scaled.scale / scaled.unit, lowest
