"""Blows that give no energy: Newton's restitution, less of it where Newton's law itself would give some.

Points that strike at the same instant are one problem, u_N -> max(u_N, -e u_N) with Coulomb's law beside it. What all impulses
r give is

    dE = r . (u + u') / 2,    u' = u + W r,

for relative velocities u before and u' after. Without friction and with one e it is (1 - e) r . u / 2 <= 0. With friction off
the centre of mass, or beside a point that is about to open, it may be positive (Kane, Levinson). At e = 0 it never is, since r
. u' <= 0 and r . (u' - u) = r W r >= 0. Each group of points that bodies connect therefore takes the largest share of its e,
from 0 to 1, at which it gains nothing.

Source: Newton's law and its gain: Kane, Levinson, Dynamics, 1985; Stronge, Impact Mechanics, 2000, chapters 3 and 8.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.sparse.csgraph import connected_components

from plumbline.engine.maths.types import Floats
from plumbline.engine.respond.exact.law import Problem
from plumbline.engine.respond.exact.solver import Solution

ROUND_OFF = 1e-10
"""What a group may gain, as a share of the energies that its impulses exchange: ten times the tolerance of a solve."""
MOST, CLOSE = 30, 1e-12
"""Trials of a share, and how close it is enclosed."""


@dataclass(frozen=True, slots=True)
class Blow:
    """A blow as it was solved: impulses and residual, and how many groups of points had less than their e."""

    solution: Solution
    lessened: int


def energy_given(problem: Problem, lift: Floats, impulse: Floats) -> Floats:
    """r . (u + u') / 2 [J] of each contact (k,). Args: lift (k,) m/s: what the problem adds to normal velocities."""
    twice = problem.velocity + problem.after(impulse)
    twice[:, 0] -= 2.0 * lift
    return np.asarray(0.5 * (impulse * twice).sum(axis=1))


def without_gain(problem: Problem, lift: Floats, solution: Solution, solve: Callable[[Problem], Solution]) -> Blow:
    """A blow in which no group of points gains energy.

    Args: problem: with `lift` (k,) m/s on its normal velocities, negative where a point rebounds; solution: of it; solve: for
        the impulses of another problem.
    """
    if energy_given(problem, lift, solution.impulse).max(initial=0.0) <= 0.0:
        return Blow(solution, 0)
    k = problem.size
    coupled = (problem.inverse_mass.reshape(k, 3, k, 3) != 0.0).any(axis=(1, 3))
    number, group = connected_components(coupled, directed=False)
    impulse, residual, matrices, lessened = solution.impulse.copy(), solution.residual, solution.matrices, 0
    for g in range(number):
        own = np.flatnonzero(group == g)
        part = restricted(problem, own)
        rise = gain(part, lift[own], impulse[own])
        if rise > 0.0:
            found = lessen(part, lift[own], rise, solve)
            impulse[own], residual = found.impulse, max(residual, found.residual)
            matrices, lessened = matrices + found.matrices, lessened + 1
    return Blow(Solution(impulse, residual, matrices), lessened)


def restricted(problem: Problem, own: NDArray[np.intp]) -> Problem:
    """The problem of some of its contacts, by their numbers."""
    flat = (3 * own[:, None] + np.arange(3)).ravel()
    return Problem(problem.inverse_mass[np.ix_(flat, flat)], problem.velocity[own], problem.friction[own], problem.speed)


def gain(problem: Problem, lift: Floats, impulse: Floats) -> float:
    """What all contacts gain beyond round-off [J]."""
    before = problem.velocity.copy()
    before[:, 0] -= lift
    exchanged = float(np.abs(impulse * before).sum())
    return float(energy_given(problem, lift, impulse).sum()) - ROUND_OFF * exchanged


def shared(problem: Problem, lift: Floats, share: float) -> tuple[Problem, Floats]:
    """The problem with a share of the rebounds, and its lift."""
    less = np.where(lift < 0.0, share * lift, lift)
    velocity = problem.velocity.copy()
    velocity[:, 0] += less - lift
    return Problem(problem.inverse_mass, velocity, problem.friction, problem.speed), less


def lessen(problem: Problem, lift: Floats, rise: float, solve: Callable[[Problem], Solution]) -> Solution:
    """The solution at the largest share of the rebounds that is found to gain nothing, by regula falsi and bisection in turns.

    Args: rise [J]: the gain at all of the rebounds.
    """
    low, high = 0.0, 1.0
    tried, less = shared(problem, lift, low)
    best = solve(tried)
    fall = gain(tried, less, best.impulse)
    for count in range(MOST):
        if high - low <= CLOSE or fall >= 0.0:
            break
        share = 0.5 * (low + high) if count % 3 == 2 else (low * rise - high * fall) / (rise - fall)
        tried, less = shared(problem, lift, share)
        found = solve(tried)
        now = gain(tried, less, found.impulse)
        if now <= 0.0:
            low, fall, best = share, now, found
        else:
            high, rise = share, now
    return best
