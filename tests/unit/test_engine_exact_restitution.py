"""Blows under the exact solver: by enumeration of all active sets, and that none gives energy."""

from itertools import product

import numpy as np
import pytest

from plumbline import engine
from plumbline.engine.respond.exact.law import Problem
from plumbline.engine.respond.exact.passive import energy_given, without_gain
from plumbline.engine.respond.exact.solver import Solution, solve
from tests.exact_worlds import EXACT, ball, cube, surface, world_of


def _blow(seed: int, contacts: int, bodies: int, friction: float, restitution: float) -> tuple[Problem, np.ndarray]:
    """Points that strike at once, off the centres of mass, of bodies between 1 and 10 kg; and the rebounds asked for."""
    rng = np.random.default_rng(seed)
    reach = np.zeros((3 * contacts, 6 * bodies))
    for c in range(contacts):
        frame = np.linalg.qr(rng.normal(size=(3, 3)))[0]
        for sign, b in zip((1.0, -1.0), rng.permutation(bodies)[:2], strict=False):
            arm = rng.normal(size=3)
            reach[3 * c : 3 * c + 3, 6 * b : 6 * b + 3] = sign * frame
            reach[3 * c : 3 * c + 3, 6 * b + 3 : 6 * b + 6] = sign * np.cross(arm, frame)
    half = reach * np.sqrt(np.repeat(10.0 ** rng.uniform(-1.0, 0.0, bodies), 6))
    u = (reach @ rng.normal(size=6 * bodies)).reshape(-1, 3)
    lift = restitution * np.minimum(u[:, 0], 0.0)
    q = u.copy()
    q[:, 0] += lift
    return Problem(half @ half.T, q, np.full(contacts, friction), float(np.linalg.norm(u, axis=1).max())), lift


def _enumerated(problem: Problem) -> np.ndarray:
    """The normal impulses (k,) of a blow without friction: every set of points that bear is tried until all signs are right."""
    w, q = problem.inverse_mass[::3, ::3], problem.velocity[:, 0]
    for bears in product((False, True), repeat=len(q)):
        on, r = np.array(bears), np.zeros(len(q))
        r[on] = np.linalg.solve(w[np.ix_(on, on)], -q[on]) if on.any() else 0.0
        if (r >= 0.0).all() and (q + w @ r >= -1e-12).all():
            return r
    raise AssertionError("a positive definite matrix has one solution")


@pytest.mark.parametrize("seed", range(6))
@pytest.mark.parametrize("restitution", [0.5, 1.0])
def test_blows_without_friction_are_those_of_the_one_active_set_that_fits(seed: int, restitution: float) -> None:
    """W of four points of four bodies is regular: one solution, here by a route with nothing in common with the solver."""
    problem, lift = _blow(seed, 4, 4, 0.0, restitution)
    found, due = solve(problem), _enumerated(problem)
    assert found.residual <= EXACT
    assert found.impulse[:, 0] == pytest.approx(due, rel=1e-8, abs=1e-9)
    exchanged = np.abs(found.impulse[:, 0] * (problem.velocity[:, 0] - lift)).sum()
    # One e for all points: (1 - e) r . u / 2, nothing at e = 1 beside points that do not approach and bear nothing.
    if not (found.impulse[:, 0] * (lift >= 0.0)).any():
        given = energy_given(problem, lift, found.impulse).sum()
        due_energy = 0.5 * (1.0 - restitution) * (found.impulse[:, 0] * (problem.velocity[:, 0] - lift)).sum()
        assert given == pytest.approx(due_energy, abs=1e-9 * exchanged)


@pytest.mark.parametrize("friction", [0.3, 1.0])
def test_no_blow_gives_energy_and_those_that_would_rebound_by_all_that_gives_none(friction: float) -> None:
    """At e = 1 Newton's law with friction gives energy in some of these blows; then all of it is kept, to what a share of
    1e-12 of the rebound exchanges, and no more given than the tolerance of a solve. The others are left as they are."""
    gained = 0
    for seed in range(24):
        problem, lift = _blow(seed, 2, 2, friction, 1.0)
        plain = solve(problem)
        before = problem.velocity.copy()
        before[:, 0] -= lift
        blow = without_gain(problem, lift, plain, solve)
        exchanged = np.abs(blow.solution.impulse * before).sum()
        given = energy_given(problem, lift, blow.solution.impulse).sum()
        assert given <= 1e-9 * exchanged
        assert blow.solution.residual <= EXACT
        if energy_given(problem, lift, plain.impulse).sum() > 1e-6 * exchanged:
            gained += 1
            assert blow.lessened == 1
            assert given == pytest.approx(0.0, abs=1e-6 * exchanged)
        elif blow.lessened == 0:
            assert blow.solution is plain or np.array_equal(blow.solution.impulse, plain.impulse)
    assert gained > 0


def test_a_group_that_would_gain_leaves_the_rebound_of_another_alone() -> None:
    """Two blows that no body connects, one of which Newton's law lets gain: the other keeps its bits."""
    parts = [_blow(seed, 2, 2, 1.0, 1.0) for seed in range(24)]
    plain = [solve(problem) for problem, _ in parts]
    gains = [energy_given(problem, lift, s.impulse).sum() for (problem, lift), s in zip(parts, plain, strict=True)]
    one, other = int(np.argmax(gains)), int(np.argmin(gains))
    assert gains[one] > 1e-6 > gains[other]
    w = np.zeros((12, 12))
    w[:6, :6], w[6:, 6:] = parts[one][0].inverse_mass, parts[other][0].inverse_mass
    both = Problem(w, np.concatenate([parts[k][0].velocity for k in (one, other)]), np.ones(4), max(p.speed for p, _ in parts))
    together = Solution(np.concatenate([plain[one].impulse, plain[other].impulse]), 0.0, 0)
    blow = without_gain(both, np.concatenate([parts[one][1], parts[other][1]]), together, solve)
    assert blow.lessened == 1
    assert np.array_equal(blow.solution.impulse[2:], plain[other].impulse)
    assert not np.array_equal(blow.solution.impulse[:2], plain[one].impulse)


def _energy(world: engine.World) -> float:
    """Of unit masses without rotation [J]."""
    return float(0.5 * (world.state()[1:, 7:10] ** 2).sum())


def test_a_ball_that_strikes_one_about_to_leave_another_gives_no_energy() -> None:
    """b and c touch and part at 1e-7 m/s as a strikes b at 1 m/s; c has no rebound of its own at the instant of the blow.

    Held as one, b and c would come away with 2 v s / 3 = 3e-8 J more than there was of .5 J.
    """
    balls = [
        ball("a", p_WB=(-0.2005, 0, 1), v_WB=(1, 0, 0)), ball("b", p_WB=(0, 0, 1)),
        ball("c", p_WB=(0.2, 0, 1), v_WB=(1e-7, 0, 0)),
    ]  # fmt: skip
    world = world_of(balls, surface(0.0, 1.0), (0, 0, 0))
    before = _energy(world)
    world.step(8)
    assert _energy(world) <= before * (1.0 + 1e-9)
    assert world.state()[1:, 7].sum() == pytest.approx(1.0 + 1e-7, abs=1e-12)
    assert world.certificate is not None
    assert world.certificate.lessened == 1


def test_a_spinning_box_on_a_rough_floor_never_gains_at_full_restitution() -> None:
    """A cube turns without change of energy between blows, its moments of inertia being one: what changes it is blows alone."""
    rng, lessened = np.random.default_rng(5), 0
    for _ in range(12):
        turn = rng.normal(size=4)
        box = cube(
            p_WB=(0, 0, 0.25), q_WB=tuple(turn / np.linalg.norm(turn)), v_WB=(*rng.normal(size=2), -3.0),
            w_WB=tuple(5.0 * rng.normal(size=3)),
        )  # fmt: skip
        world = world_of([box], surface(0.3, 1.0), (0, 0, 0))
        energy, inertia = [], 0.04 / 6
        for _ in range(20):
            state = world.state()[1]
            energy.append(0.5 * (state[7:10] @ state[7:10] + inertia * state[10:] @ state[10:]))
            world.step()
        assert (np.diff(energy) <= 1e-8 * energy[0]).all()
        assert world.certificate is not None
        lessened += world.certificate.lessened
    assert lessened > 0
