"""The exact contact solver on problems by hand and at random: its certificate, and an independent route."""

import math

import numpy as np
import pytest

from plumbline.engine.respond.exact.cone import compose, frame_of, root, spectral
from plumbline.engine.respond.exact.law import Problem, relative_residual, scale_problem
from plumbline.engine.respond.exact.solver import solve
from plumbline.engine.respond.exact.trace import Local, look
from tests.exact_worlds import EXACT


def _point(velocity: tuple[float, float, float], friction: float, mass: float = 2.0) -> Problem:
    """One mass point on the ground."""
    q = np.array([velocity])
    return Problem(np.eye(3) / mass, q, np.array([friction]), float(np.linalg.norm(q)))


def _random_problem(seed: int, bodies: int = 4, contacts: int = 6, ratio: float = 1e4) -> Problem:
    """Random contacts between random bodies and the ground, approaching; rest satisfies the law, so a solution exists."""
    rng = np.random.default_rng(seed)
    reach = np.zeros((3 * contacts, 6 * bodies))
    inverse = np.repeat(ratio ** rng.uniform(-1.0, 0.0, bodies), 6)
    for c in range(contacts):
        frame = np.linalg.qr(rng.normal(size=(3, 3)))[0]
        pair = rng.permutation(bodies)[:2] if c % 2 else [c % bodies]
        for sign, b in zip((1.0, -1.0), pair, strict=False):
            arm = rng.normal(size=3)
            reach[3 * c : 3 * c + 3, 6 * b : 6 * b + 3] = sign * frame
            reach[3 * c : 3 * c + 3, 6 * b + 3 : 6 * b + 6] = sign * np.cross(arm, frame)
    q = (reach @ rng.normal(size=6 * bodies)).reshape(-1, 3)
    half = reach * np.sqrt(inverse)
    return Problem(half @ half.T, q, rng.uniform(0.1, 0.8, contacts), float(np.linalg.norm(q, axis=1).max()))


def project_coulomb(impulse: np.ndarray, friction: np.ndarray) -> np.ndarray:
    """The points of Coulomb's cones |r_T| <= mu r_N nearest to impulses (k, 3)."""
    normal, size = impulse[:, 0], np.hypot(impulse[:, 1], impulse[:, 2])
    on_cone = np.maximum((normal + friction * size) / (1.0 + friction * friction), 0.0)
    # Without friction 0 <= 0 would hold for a pull as well.
    inside = (size <= friction * normal) & (normal >= 0.0)
    share = np.where(inside, 1.0, friction * on_cone / np.maximum(size, 1e-300))
    projected = np.empty_like(impulse)
    projected[:, 0] = np.where(inside, normal, on_cone)
    projected[:, 1:] = share[:, None] * impulse[:, 1:]
    return projected


def _gauss_seidel(problem: Problem, sweeps: int) -> np.ndarray:
    """Projected block relaxation, one contact after the other: slow, and nothing in common with the solver but the law."""
    r, w = np.zeros((problem.size, 3)), problem.inverse_mass
    owns = [slice(3 * c, 3 * c + 3) for c in range(problem.size)]
    steps = [1.0 / np.linalg.eigvalsh(w[own, own])[-1] for own in owns]
    for _ in range(sweeps):
        for c, (own, step) in enumerate(zip(owns, steps, strict=True)):
            for _ in range(5):
                u = problem.velocity[c] + w[own] @ r.ravel()
                u[0] += problem.friction[c] * math.hypot(u[1], u[2])
                r[c] = project_coulomb((r[c] - step * u)[None], problem.friction[c : c + 1])[0]
    return r


@pytest.mark.parametrize("seed", range(4))
def test_the_certificate_is_the_natural_map_of_arrays(seed: int) -> None:
    """|F| / m of each contact from whole arrays, on impulses in and out of the cones; round-off, 1e-16, times a thousand."""
    problem, rng = _random_problem(seed), np.random.default_rng(seed)
    r = rng.normal(size=(problem.size, 3))
    u = problem.velocity + (problem.inverse_mass @ r.ravel()).reshape(-1, 3)
    m = 3.0 / np.diagonal(problem.inverse_mass).reshape(-1, 3).sum(axis=1)
    u[:, 0] += problem.friction * np.hypot(u[:, 1], u[:, 2])
    off = np.linalg.norm(r - project_coulomb(r - m[:, None] * u, problem.friction), axis=1) / m
    assert relative_residual(problem, r) == pytest.approx(float(off.max()) / problem.speed, rel=1e-13)


def test_the_certificate_accepts_the_impulses_that_stop_slide_and_free_a_point() -> None:
    """m = 2, mu = .5: it sticks under (m, m .4), slides with (m, m .5) and leaves without impulse; all by Coulomb's law."""
    assert relative_residual(_point((-1.0, -0.4, 0.0), 0.5), np.array([[2.0, 0.8, 0.0]])) < 1e-15
    assert relative_residual(_point((-1.0, 0.0, -3.0), 0.5), np.array([[2.0, 0.0, 1.0]])) < 1e-15
    assert relative_residual(_point((1.0, 2.0, 0.0), 0.5), np.zeros((1, 3))) == 0.0


@pytest.mark.parametrize(
    "wrong",
    [
        (2.0 + 2e-8, 0.0, 1.0),  # too hard by a part in 1e8: it would lift off
        (2.0 - 2e-8, 0.0, 1.0),  # too soft: it would sink
        (2.0, 0.0, 1.0 + 2e-8),  # outside the cone
        (2.0, 0.0, 1.0 - 2e-8),  # sliding with less than full friction
        (2.0, 2e-8, 1.0),  # friction not against the motion
        (-1e-8, 0.0, 0.0),  # a contact that pulls
        (0.0, 0.0, 0.0),
    ],
)
def test_the_certificate_sees_a_planted_wrong_impulse(wrong: tuple[float, float, float]) -> None:
    """An error of 1e-8 of the impulse is a velocity of 1e-8, a few parts in 1e9 of 3.2 m/s: far above round-off."""
    assert relative_residual(_point((-1.0, 0.0, -3.0), 0.5), np.array([wrong])) > 1e-9


def test_the_certificate_of_a_contact_without_friction_sees_a_pull_and_accepts_a_departure() -> None:
    """At rest a pull leaves |r| / m = .5 m/s of 1 m/s; a contact that separates needs no impulse."""
    held = Problem(np.eye(3) / 2.0, np.array([[0.5, 0.0, 0.0]]), np.zeros(1), 1.0)
    assert relative_residual(held, np.array([[-1.0, 0.0, 0.0]])) == pytest.approx(0.5)
    assert relative_residual(held, np.zeros((1, 3))) == 0.0
    assert relative_residual(held, np.array([[-1e-15, 0.0, 0.0]])) < 1e-14


def test_the_certificate_sees_an_error_on_the_light_one_of_two_bodies() -> None:
    """1e-7 of the light body's impulse is 1e-11 of the heavy one's, and is not hidden by it."""
    masses = np.array([1e4, 1.0])
    problem = Problem(np.diag(np.repeat(1 / masses, 3)), np.array([[-1.0, 0, 0]] * 2), np.full(2, 0.5), 1.0)
    right = np.stack([masses, [0, 0], [0, 0]], axis=1)
    assert relative_residual(problem, right) < 1e-15
    assert relative_residual(problem, right + np.array([[0, 0, 0], [1e-7, 0, 0]])) > 1e-8


def test_the_certificate_calls_impulses_that_are_not_numbers_infinitely_wrong() -> None:
    assert relative_residual(_point((-1.0, 0.0, 0.0), 0.5), np.full((1, 3), math.nan)) == math.inf


@pytest.mark.parametrize("seed", [0, pytest.param(1, marks=pytest.mark.slow)])
def test_relaxation_to_convergence_finds_the_same_velocities(seed: int) -> None:
    """Six contacts with twelve or more degrees of freedom: W is regular, so velocities agree as far as relaxation got."""
    problem = _random_problem(seed, ratio=10.0)
    slow, exact = _gauss_seidel(problem, 200), solve(problem)
    reached = relative_residual(problem, slow)
    assert exact.residual <= EXACT
    assert reached < 1e-6
    assert np.abs(problem.after(slow) - problem.after(exact.impulse)).max() < 1e3 * reached + 1e-9


@pytest.mark.parametrize("seed", range(20))
def test_random_problems_with_mass_ratios_of_1e4_are_solved_to_round_off(seed: int) -> None:
    assert solve(_random_problem(100 + seed, bodies=8, contacts=20)).residual <= EXACT


@pytest.mark.parametrize("effort", [20.0, 50.0])
def test_an_effort_bounds_the_matrices_and_its_end_keeps_the_best_answer(effort: float) -> None:
    """Of 18 unknowns a matrix costs .12 to .62 ms. What more effort adds follows on the same matrices: it can only be
    better."""
    problem = _random_problem(3, ratio=1e4)
    bounded, longer = (solve(problem, tolerance=0.0, effort=most) for most in (effort, 2.0 * effort))
    assert effort / 0.62 - 1.0 < bounded.matrices <= effort / 0.12
    assert bounded.matrices < longer.matrices
    assert longer.residual <= bounded.residual == relative_residual(problem, bounded.impulse)


def test_an_effort_that_suffices_changes_no_bit() -> None:
    problem = _random_problem(103, bodies=8, contacts=20)
    bounded, free = solve(problem, effort=400.0), solve(problem)
    assert bounded.residual <= EXACT
    assert np.array_equal(bounded.impulse, free.impulse)


def look_at_arrays(w: np.ndarray, q: np.ndarray, rubs: np.ndarray, x: np.ndarray, width: float, power: float) -> Local:
    """As `look`, all contacts at once."""
    k, soft, dim = len(x), width * width, width**power
    y = q + (w @ x.ravel()).reshape(-1, 3) + soft * x
    y[~rubs, 1:] = 0.0
    square = y[:, 1] ** 2 + y[:, 2] ** 2
    size = np.sqrt(square + dim * dim)
    blur = (dim / size) ** 2
    lift = y[:, 1:] / size[:, None] * (1.0 + blur)[:, None]
    y[:, 0] += np.where(rubs, square / size, 0.0)
    z = x - y
    low, high, tangent = spectral(z)
    (p_low, c_low), (p_high, c_high) = root(low, width), root(high, width)
    open_ = (x[:, 0] < y[:, 0])[:, None]
    miss = np.where(open_, compose(p_low, p_high, tangent) - x, compose(c_low, c_high, tangent) - y)

    p = np.stack([p_low, p_high, p_low + p_high], axis=1)
    c = np.stack([c_low, c_high, c_low + c_high], axis=1)
    frame = frame_of(tangent)
    turned = np.swapaxes(frame, 1, 2)
    bears, opens = (frame * (p / (p + c))[:, None, :]) @ turned, (frame * (c / (p + c))[:, None, :]) @ turned
    rows = (w + soft * np.eye(3 * k)).reshape(k, 3, 3 * k)
    rows[:, 0] += lift[:, 0, None] * rows[:, 1] + lift[:, 1, None] * rows[:, 2]
    slope = (bears @ rows).reshape(3 * k, 3 * k)
    each = np.arange(k)
    slope.reshape(k, 3, k, 3)[each, :, each, :] += opens

    pushed = 2.0 * soft * x
    pushed[:, 0] += np.where(rubs, (lift * pushed[:, 1:]).sum(axis=1) - (power * square / size * blur), 0.0)
    rate = compose(2.0 * soft / np.hypot(low, 2.0 * width), 2.0 * soft / np.hypot(high, 2.0 * width), tangent)
    rate -= (bears @ pushed[:, :, None])[:, :, 0]
    along, across = (miss[:, 1:] * tangent).sum(axis=1), miss[:, 2] * tangent[:, 0] - miss[:, 1] * tangent[:, 1]
    ends = np.stack([miss[:, 0] - along, miss[:, 0] + along, across], axis=1)
    room = np.minimum(p, c) + 2.0 * float(np.finfo(float).eps) * (0.2 + float(np.abs(z).max()))
    return Local(miss, slope, rate, float(np.abs(ends / room).max()), p[:, 1])


@pytest.mark.parametrize("width", [10.0, 1.0, 1e-3, 1e-7])
def test_the_compiled_look_at_a_path_is_that_of_arrays(width: float) -> None:
    """The same formulas, summed in another order: round-off, 1e-16, times a hundred."""
    scaled, rng = scale_problem(_random_problem(3)), np.random.default_rng(0)
    rubs = scaled.rubs.copy()
    rubs[1] = False
    x = 0.3 * rng.normal(size=scaled.q.shape)
    x[:, 0] += 0.5
    x[1, 1:] = 0.0
    compiled, arrays = (seen(scaled.w, scaled.q, rubs, x, width, 1.5) for seen in (look, look_at_arrays))
    for name in ("miss", "slope", "rate", "size", "off"):
        due = np.asarray(getattr(arrays, name))
        assert np.abs(getattr(compiled, name) - due).max() <= 1e-14 * np.abs(due).max()


def test_a_frictionless_contact_beside_a_rough_one_gets_no_tangential_impulse() -> None:
    problem = _random_problem(7)
    friction = problem.friction.copy()
    friction[::2] = 0.0
    smooth = Problem(problem.inverse_mass, problem.velocity, friction, problem.speed)
    solution = solve(smooth)
    assert solution.residual <= EXACT
    assert not solution.impulse[::2, 1:].any()


# --- motions far below the others -------------------------------------------------------------------


def _held(misfit: float) -> Problem:
    """A body on two points 1 m apart that falls at 1 m/s, where no rigid motion keeps both points by `misfit` m/s.

    Normals up, tangents along the line (x) and across it; mass and inertia one, centre between the points. Their velocities
    along the line are one and the same for a rigid body, and q asks for two.
    """
    rows = [([0, 0, 1, 0, -x, 0], [1, 0, 0, 0, 0, 0], [0, 1, 0, 0, 0, x]) for x in (-0.5, 0.5)]
    reach = np.array(rows, float).reshape(6, 6)
    q = np.array([[-1.0, -0.5 * misfit, 0.0], [-1.0, 0.5 * misfit, 0.0]])
    return Problem(reach @ reach.T, q, np.full(2, 0.5), 1.0)


@pytest.mark.parametrize("misfit", [1e-3, 1e-6, 1e-8, 1e-9])
def test_points_that_cannot_both_stick_slip_however_slowly(misfit: float) -> None:
    """Were both stuck, misfit / 2 would remain as a residual. Each carries half of m v; friction is full where it slips."""
    problem = _held(misfit)
    solution = solve(problem)
    slip = np.abs(problem.after(solution.impulse)[:, 1])
    assert solution.residual <= 1e-11
    assert solution.impulse[:, 0] == pytest.approx(0.5, rel=1e-9)
    assert slip.sum() == pytest.approx(misfit, rel=1e-2)
    assert np.abs(solution.impulse[slip > 0.1 * misfit, 1]) == pytest.approx(0.25, rel=1e-9)
