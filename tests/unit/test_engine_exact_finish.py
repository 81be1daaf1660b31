"""The compiled steps of Newton that finish an exact solve, and the elimination in them, against NumPy's."""

import numpy as np
import pytest
from numpy.typing import NDArray

from plumbline.engine.compile.jit import entry
from plumbline.engine.respond.exact.finish import eliminate, finish_from
from plumbline.engine.respond.exact.law import Problem, relative_residual, scale_problem
from plumbline.engine.respond.exact.solver import NEAR, PLAIN, solve

Floats = NDArray[np.float64]


@entry
def _solved(a: Floats, x: Floats) -> bool:
    """Solve in place."""
    return eliminate(a, x)


def _banded(n: int, band: int, seed: int) -> Floats:
    """A random matrix with nothing farther than `band` from its diagonal, and rows that have to change places."""
    a = np.random.default_rng(seed).normal(size=(n, n))
    a[np.abs(np.subtract.outer(np.arange(n), np.arange(n))) > band] = 0.0
    a[np.arange(0, n, 3), np.arange(0, n, 3)] = 0.0
    return a


@pytest.mark.parametrize(("n", "band"), [(1, 1), (3, 3), (24, 24), (60, 7), (60, 1)])
def test_elimination_solves_what_numpy_solves(n: int, band: int) -> None:
    """Backward error: round-off times the size of the matrix and the growth of its pivots, which are partial."""
    a = _banded(n, band, n) if n > 1 else np.array([[2.0]])
    asked = np.random.default_rng(1).normal(size=n)
    x = asked.copy()
    assert _solved(a.copy(), x)
    assert np.abs(a @ x - asked).max() <= 1e-13 * n * np.abs(a).max() * np.abs(x).max()
    assert x == pytest.approx(np.linalg.solve(a, asked), rel=1e-15 * n * np.linalg.cond(a), abs=1e-15 * n * np.abs(x).max())


@pytest.mark.parametrize("wrong", [0.0, np.nan])
def test_elimination_says_where_there_is_no_solution(wrong: float) -> None:
    a = np.eye(4)
    a[2, 2] = wrong
    assert not _solved(a, np.ones(4))
    assert not _solved(np.eye(2), np.array([1.0, np.inf]))


def _pile(seed: int, k: int = 5) -> Problem:
    """A contact problem with friction, one contact of it without."""
    rng = np.random.default_rng(seed)
    rows = rng.normal(size=(3 * k, 3 * k + 2))
    friction = rng.uniform(0.2, 0.9, size=k)
    friction[0] = 0.0
    velocity = rng.normal(size=(k, 3))
    return Problem(rows @ rows.T, velocity, friction, float(np.linalg.norm(velocity, axis=1).max()))


@pytest.mark.parametrize("seed", range(6))
def test_from_near_a_solution_a_few_steps_lead_to_it(seed: int) -> None:
    """A thousandth away from it, and by the steps of Newton, whose misses are squared; the residual told is that of arrays."""
    problem = _pile(seed)
    exact = solve(problem)
    assert exact.residual <= 1e-11
    begun = exact.impulse * (1.0 + 1e-3 * np.random.default_rng(seed).normal(size=exact.impulse.shape))
    r = begun.copy()
    residual, used, wanted = finish_from(problem.tables, r, PLAIN, (1e-11, 1e-11, NEAR), 12)
    assert residual == relative_residual(problem, r) <= 1e-11 < relative_residual(problem, begun)
    assert 0 < used <= 6
    assert not wanted
    assert r == pytest.approx(exact.impulse, abs=1e-8 * np.abs(exact.impulse).max())


def test_what_is_too_far_or_good_enough_is_left_as_it_is() -> None:
    problem = _pile(2)
    exact = solve(problem).impulse
    for begun in (np.full_like(exact, 100.0), exact):
        r = begun.copy()
        residual, used, wanted = finish_from(problem.tables, r, PLAIN, (1e-11, 1e-11, NEAR), 12)
        assert (used, wanted) == (0, False)
        assert residual == pytest.approx(relative_residual(problem, begun), rel=1e-6, abs=1e-13)
    r = exact * 1.001
    assert finish_from(problem.tables, r, PLAIN, (1e-300, 1e-300, NEAR), 1)[1:] == (1, True)


def test_the_compiled_scaling_is_that_of_its_definition() -> None:
    """Blocks of W with a mean diagonal of one, free velocities of at most one, and x = scale r / unit."""
    problem = _pile(3)
    scaled = scale_problem(problem)
    diagonal = np.diagonal(scaled.w).reshape(-1, 3)
    assert diagonal[0] == pytest.approx([1.0, 0.0, 0.0], abs=1e-14)
    assert diagonal[1:].mean(axis=1) == pytest.approx(np.ones(4), abs=1e-14)
    assert np.abs(scaled.q).max() == 1.0
    x = np.random.default_rng(0).normal(size=(5, 3))
    x[0, 1:] = 0.0
    u = problem.after(scaled.impulse(x)) * np.where(scaled.kept, 1.0 / scaled.scale, 0.0) / scaled.unit
    assert u == pytest.approx(scaled.q + (scaled.w @ x.ravel()).reshape(-1, 3), abs=1e-13)
