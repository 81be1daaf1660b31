"""Truths and checks of the impacts against the differential law of impact, linear algebra, event-driven rows and random aim."""

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from plumbline.cases import impact_cradle, impact_gas, impact_momentum, impact_oblique, impact_pairs
from plumbline.harness.case import Case
from plumbline.harness.scene import Scene, sphere_inertia
from plumbline.harness.trajectory import Floats, Trajectory
from plumbline.harness.trajectory.kinematics import cross
from plumbline.harness.truths.friction import coulomb_impact

DOWN = np.array([0.0, 0.0, -1.0])


def clock(steps: int, dt: float) -> Floats:
    """The ends of `steps` steps, from 0 on, (steps + 1,) s."""
    time: Floats = np.arange(steps + 1, dtype=np.float64) * dt
    return time


def verdicts(case: Case, run: Trajectory) -> dict[str, bool]:
    """Which checks a run passes at the case's own parameters."""
    truth = case.truth_at(run.time, case.parameters)
    assert truth is None or isinstance(truth, Trajectory)
    scene = case.scene(case.parameters)
    # Made by hand, a run has no contacts: what is read off these has tests of its own.
    judged = [c for c in case.checks if not c.metric.name.endswith(("_residual", "pairs_met"))]
    return {c.metric.name: c.passes(c.metric(scene, run, truth), run.dt, case.parameters) for c in judged}


def flight(case: Case, dt: float, velocities: Callable[[Trajectory, int], None] | None = None) -> Trajectory:
    """Room for a run of a case with every step sampled, in its initial state throughout."""
    scene = case.scene(case.parameters)
    run = replace(Trajectory.of(clock(round(case.duration / dt), dt), len(scene.bodies)), dt=dt)
    run.p_WB[:] = [b.p_WB for b in scene.bodies]
    run.q_WB[:] = [b.q_WB for b in scene.bodies]
    run.v_WB[:] = [b.v_WB for b in scene.bodies]
    run.w_WB[:] = [b.w_WB for b in scene.bodies]
    return run


# --- impact_oblique -------------------------------------------------------------------------------


def by_impulse(v: Floats, w: Floats, mass: float, moment: float, arm: float, e: float, mu: float) -> tuple[Floats, Floats]:
    """The impact as a motion in which the normal impulse takes the place of time: slip until it stops, then grip.

    Source: Keller, J. Appl. Mech. 53 (1986) 1; Stronge, Impact Mechanics, section 3.3.
    """
    total = (1 + e) * mass * abs(v[2])
    down = arm * DOWN

    def slip(y: Floats) -> Floats:
        s: Floats = (y[:3] + cross(y[3:], down)) * np.array([1.0, 1.0, 0.0])
        return s

    def change(_p: float, y: Floats) -> Floats:
        s = slip(y)
        force = np.array([0.0, 0.0, 1.0]) - mu * s / max(float(np.linalg.norm(s)), 1e-300)
        return np.concatenate([force / mass, cross(down, force) / moment])

    def grips(_p: float, y: Floats) -> float:
        return float(np.linalg.norm(slip(y)) - 1e-10)

    grips.terminal = True  # type: ignore[attr-defined]
    start = np.concatenate([v, w])
    if np.linalg.norm(slip(start)) < 1e-9:
        found, used = start, 0.0
    else:
        run = solve_ivp(change, (0.0, total), start, "DOP853", events=grips, rtol=1e-12, atol=1e-13, max_step=total / 10)
        found, used = run.y[:, -1], float(run.t[-1])
    return found[:3] + np.array([0.0, 0.0, (total - used) / mass]), found[3:]


@pytest.mark.parametrize("friction", [0.0, 0.1, 0.3, 1.0])
@pytest.mark.parametrize("restitution", [0.0, 0.6, 1.0])
def test_one_impulse_is_what_the_differential_law_of_impact_ends_with(restitution: float, friction: float) -> None:
    draw = np.random.default_rng(5)
    for _ in range(3):
        v, w = draw.uniform(-5, 5, 3), draw.uniform(-20, 20, 3)
        v[2] = -abs(v[2]) - 0.1
        law = (2.0, 0.4 * 2.0 * 0.2**2, 0.2, restitution, friction)
        for found, right in zip(coulomb_impact(v, w, *law), by_impulse(v, w, *law), strict=True):
            # The integration takes a slip under 1e-10 m/s for grip; 1e-10/arm in the spin.
            np.testing.assert_allclose(found, right, atol=1e-8)


def test_the_balls_of_the_case_grip_and_slip_as_their_table_says() -> None:
    moment = sphere_inertia(1.0, impact_oblique.RADIUS)[0][0]
    gripped = []
    for v, w in impact_oblique._motions(impact_oblique.VELOCITIES, impact_oblique.SPINS, impact_oblique.APPROACH):
        after, spin = coulomb_impact(v, w, 1.0, moment, impact_oblique.RADIUS, 0.6, 0.3)
        gripped.append(bool(np.linalg.norm((after + np.cross(spin, impact_oblique.RADIUS * DOWN))[:2]) < 1e-12))
    assert gripped == [True, True, False, False, True, False, True]


def test_the_oblique_truth_starts_where_the_scene_does_and_moves_as_its_velocity_says() -> None:
    time = np.linspace(0.0, 0.5, 5001)
    truth = impact_oblique.expected(time, impact_oblique.P())
    np.testing.assert_allclose(truth.p_WB[0], [b.p_WB for b in impact_oblique.scene(impact_oblique.P()).bodies])
    moved = np.diff(truth.p_WB, axis=0) / np.diff(time)[:, None, None]
    same = np.all(truth.v_WB[1:] == truth.v_WB[:-1], axis=(2,))
    np.testing.assert_allclose(moved[same], truth.v_WB[1:][same], atol=1e-9)
    assert (truth.p_WB[:, 1:, 2] >= impact_oblique.RADIUS - 1e-12).all()


def oblique(dt: float, law: Callable[[Floats, Floats], tuple[Floats, Floats]]) -> Trajectory:
    """The case by a plain engine: what is found under the ground is given its velocity after the impact."""
    run = flight(impact_oblique.CASE, dt)
    for place in range(1, run.p_WB.shape[1]):
        p, v, w = run.p_WB[0, place].copy(), run.v_WB[0, place].copy(), run.w_WB[0, place].copy()
        for k in range(1, len(run)):
            if p[2] < impact_oblique.RADIUS and v[2] < 0:
                v, w = law(v, w)
            p = p + dt * v
            run.p_WB[k, place], run.v_WB[k, place], run.w_WB[k, place] = p, v, w
    return run


def coulomb(**other: float) -> Callable[[Floats, Floats], tuple[Floats, Floats]]:
    """The law of the case, with some of its numbers changed."""
    radius = impact_oblique.RADIUS
    numbers = {"mass": 1.0, "moment": 0.4 * radius**2, "arm": radius, "restitution": 0.6, "friction": 0.3} | other
    return lambda v, w: coulomb_impact(v, w, **numbers)


def pyramid(v: Floats, w: Floats) -> tuple[Floats, Floats]:
    """Friction bounded along each of two axes on its own."""
    radius, moment = impact_oblique.RADIUS, 0.4 * impact_oblique.RADIUS**2
    normal = 1.6 * abs(v[2])
    slip = v + np.cross(w, radius * DOWN)
    wanted = -slip / (1 + radius**2 / moment)
    impulse = np.array([*np.clip(wanted[:2], -0.3 * normal, 0.3 * normal), normal])
    return v + impulse, w + np.cross(radius * DOWN, impulse) / moment


@pytest.mark.parametrize("dt", impact_oblique.CASE.ladder)
def test_a_plain_engine_with_coulombs_impulse_passes_at_every_step(dt: float) -> None:
    assert all(verdicts(impact_oblique.CASE, oblique(dt, coulomb())).values())


@pytest.mark.parametrize("dt", [1 / 240, 1 / 1920])
@pytest.mark.parametrize(
    "law",
    [
        coulomb(friction=0.0),
        coulomb(friction=0.3 / 1.6),  # bounded by mu m v_n, without the rebound's share
        coulomb(moment=2 / 3 * impact_oblique.RADIUS**2),  # a shell's inertia
        coulomb(restitution=0.5),
        pyramid,
    ],
    ids=["no friction", "no rebound in the bound", "wrong inertia", "wrong restitution", "pyramid"],
)
def test_each_broken_law_of_impact_fails(law: Callable[[Floats, Floats], tuple[Floats, Floats]], dt: float) -> None:
    found = verdicts(impact_oblique.CASE, oblique(dt, law))
    assert not found["velocity_error_final"]


# --- impact_pairs ---------------------------------------------------------------------------------


@pytest.mark.parametrize("restitution", [0.0, 0.3, 1.0])
@pytest.mark.parametrize(("left", "right"), [(1.0, 1.0), (1e3, 1.0), (1.0, 1e6)])
def test_parting_velocities_solve_the_two_laws(left: float, right: float, restitution: float) -> None:
    u = np.array(impact_pairs.CLOSING)
    law = np.array([[left, right], [-1.0, 1.0]])
    solved = np.linalg.solve(law, [left * u[0] + right * u[1], restitution * (u[0] - u[1])])
    # The condition of the matrix, the ratio of the masses, times rounding.
    np.testing.assert_allclose(impact_pairs.parted(left, right, restitution), solved, rtol=1e-9, atol=1e-9)
    kinetic = 0.5 * np.array([left, right]) @ solved**2 - 0.5 * np.array([left, right]) @ u**2
    lost = -0.5 * left * right / (left + right) * (1 - restitution**2) * (u[0] - u[1]) ** 2
    assert kinetic == pytest.approx(lost, rel=1e-6, abs=1e-8 * max(left, right))


def pairs(dt: float, error: float = 0.0, recoil: float = 1.0) -> Trajectory:
    """The case by a plain engine; restitution is off by `error`, and the right one gets `recoil` times the impulse."""
    run = flight(impact_pairs.CASE, dt)
    stage = impact_pairs.scene(impact_pairs.P())
    for a in range(0, len(stage.bodies), 2):
        e = stage.surface(stage.bodies[a], stage.bodies[a + 1]).restitution + error
        m = np.array([stage.bodies[a].mass, stage.bodies[a + 1].mass])
        x, v = run.p_WB[0, a : a + 2, 0].copy(), run.v_WB[0, a : a + 2, 0].copy()
        for k in range(1, len(run)):
            if x[1] - x[0] < 2 * impact_pairs.RADIUS and v[1] < v[0]:
                impulse = (1 + e) * (v[0] - v[1]) / np.sum(1 / m)
                v = v + np.array([-1.0, recoil]) * impulse / m
            x = x + dt * v
            run.p_WB[k, a : a + 2, 0], run.v_WB[k, a : a + 2, 0] = x, v
    return run


@pytest.mark.parametrize("dt", impact_pairs.CASE.ladder)
def test_a_plain_engine_parts_the_pairs_right_at_every_step(dt: float) -> None:
    assert all(verdicts(impact_pairs.CASE, pairs(dt)).values())


def test_pairs_with_a_wrong_restitution_or_an_unequal_recoil_fail() -> None:
    assert not verdicts(impact_pairs.CASE, pairs(1 / 240, error=0.01))["velocity_error_final"]
    assert not verdicts(impact_pairs.CASE, pairs(1 / 240, recoil=1.01))["momentum_drift_max"]


def test_other_ratios_and_restitutions_are_taken_as_well() -> None:
    time = np.linspace(0.0, 0.5, 50)
    truth = impact_pairs.expected(time, impact_pairs.P(ratio=7.0, restitutions=(0.25,)))
    assert truth.p_WB.shape == (50, 6, 3)
    np.testing.assert_allclose(truth.v_WB[-1, 2:4, 0], impact_pairs.parted(1.0, 1.0, 0.25))


# --- impact_cradle --------------------------------------------------------------------------------


def cradle(sweeps: int = 1000, restitution: float = 1.0, shared: bool = False) -> Trajectory:
    """The case event by event: fly to the next touch, then settle all contacts that close there by Gauss and Seidel's sweeps.

    `shared` hits the row with gaps as if it touched.
    """
    run = flight(impact_cradle.CASE, 1 / 960)
    n, r = impact_cradle.BALLS, impact_cradle.RADIUS
    for row in range(2):
        places = slice(row * n, (row + 1) * n)
        x, v, t = run.p_WB[0, places, 0].copy(), run.v_WB[0, places, 0].copy(), 0.0
        reach = 1.1e-3 if shared else 1e-12
        for _ in range(100):
            gap, closing = np.diff(x) - 2 * r, v[:-1] - v[1:]
            waits = np.where(closing > 1e-9, np.maximum(gap, 0.0) / np.maximum(closing, 1e-300), np.inf)
            wait = float(waits.min())
            inside = (run.time >= t) & (run.time < t + wait)
            run.p_WB[inside, places, 0] = x + np.outer(run.time[inside] - t, v)
            run.v_WB[inside, places, 0] = v
            if not np.isfinite(wait):
                break
            x, t = x + wait * v, t + wait
            struck = np.flatnonzero(np.diff(x) - 2 * r < reach)
            asked = np.where(v[struck] > v[struck + 1], -restitution * (v[struck] - v[struck + 1]), 0.0)
            impulse = np.zeros(len(struck))
            for _ in range(sweeps):
                for k, i in enumerate(struck):
                    after = max(impulse[k] + (v[i] - v[i + 1] - asked[k]) / 2, 0.0)
                    v[i] -= after - impulse[k]
                    v[i + 1] += after - impulse[k]
                    impulse[k] = after
    return run


def test_a_row_with_gaps_sends_one_ball_out_and_a_touching_row_keeps_its_sums() -> None:
    run = cradle()
    assert all(verdicts(impact_cradle.CASE, run).values())
    n = impact_cradle.BALLS
    np.testing.assert_allclose(run.v_WB[-1, :n, 0], [0.0] * (n - 1) + [impact_cradle.SPEED], atol=1e-9)
    # Newton's law on all contacts together: the first comes back with 3/5, the others go on as one.
    np.testing.assert_allclose(run.v_WB[-1, n:, 0] / impact_cradle.SPEED, [-0.6, 0.4, 0.4, 0.4, 0.4], atol=1e-9)


def test_ten_sweeps_keep_the_energy_well_enough_and_one_does_not() -> None:
    assert verdicts(impact_cradle.CASE, cradle(sweeps=impact_cradle.SWEEPS))["energy_drift_final"]
    assert not verdicts(impact_cradle.CASE, cradle(sweeps=1))["energy_drift_final"]


def test_a_row_struck_as_one_or_without_full_restitution_fails() -> None:
    assert not verdicts(impact_cradle.CASE, cradle(shared=True))["last_share_error"]
    assert not verdicts(impact_cradle.CASE, cradle(restitution=0.99))["last_share_error"]


# --- impact_gas -----------------------------------------------------------------------------------


def test_the_gas_starts_apart_at_rest_as_a_whole_and_with_the_asked_speed() -> None:
    stage = impact_gas.scene(impact_gas.P(edge=4, speed=3.0, seed=2))
    p = np.array([b.p_WB for b in stage.bodies[1:]])
    v = np.array([b.v_WB for b in stage.bodies[1:]])
    apart = np.linalg.norm(p[:, None] - p[None], axis=-1) + np.eye(len(p))
    assert apart.min() > 2 * impact_gas.RADIUS
    assert np.abs(p).max() + impact_gas.RADIUS < 4 * impact_gas.CELL / 2
    np.testing.assert_allclose(v.sum(axis=0), 0.0, atol=1e-12)
    assert np.sqrt(np.mean(np.sum(v**2, axis=1))) == pytest.approx(3.0)
    assert impact_gas.scene(impact_gas.P(seed=1)) != impact_gas.scene(impact_gas.P(seed=2))


def test_the_growth_of_a_late_answer_is_that_of_random_aim() -> None:
    """Pairs drawn from Maxwell's law and aimed at random, each answered with the approach of a step before."""
    draw, count, dt, d = np.random.default_rng(8), 400_000, 1e-4, 2 * impact_gas.RADIUS
    v = draw.standard_normal((count, 2, 3)) * impact_gas.SPEED / np.sqrt(3)
    relative = v[:, 0] - v[:, 1]
    speed = np.linalg.norm(relative, axis=1)
    sine = np.sqrt(draw.uniform(0, 1, count))
    closing, across = speed * np.sqrt(1 - sine**2), speed * sine
    before = closing + across**2 * dt / d
    won = impact_gas.MASS / 2 / 2 * (before**2 - closing**2)
    rate = np.pi * d**2 / impact_gas.CELL**3 / 2
    energy = impact_gas.MASS * impact_gas.SPEED**2 / 2
    # Standard error of the mean of 4e5 draws of a quantity that scatters by about twice its mean: 0.3 %.
    assert rate * float(np.mean(speed * won)) / dt / energy == pytest.approx(impact_gas.growth(1.0, impact_gas.P()), rel=0.02)


def gas(decay: float = 0.0, walls: bool = True) -> Trajectory:
    """Spheres that go to and fro between the walls of their cells, or on and on without them, with a decay [1/s] of speed."""
    run = flight(impact_gas.CASE, 1 / 240)
    bounce = np.where(np.floor(run.time * 8).astype(int) % 2 == 0, 1.0, -1.0) if walls else np.ones(len(run))
    slow = np.exp(-decay * run.time)
    run.v_WB[:, 1:] = run.v_WB[0, 1:] * (bounce * slow)[:, None, None]
    run.p_WB[1:] = run.p_WB[0] + np.cumsum(run.v_WB[1:] / 240, axis=0)
    return run


def test_a_gas_that_is_damped_or_leaves_its_box_fails() -> None:
    steady = verdicts(impact_gas.CASE, gas())
    assert steady["escaped_share"]
    assert steady["energy_growth_rate"]
    assert not verdicts(impact_gas.CASE, gas(decay=0.04 * 2))["energy_growth_rate"]
    assert not verdicts(impact_gas.CASE, gas(walls=False))["escaped_share"]


# --- impact_momentum ------------------------------------------------------------------------------


@pytest.mark.parametrize("dt", impact_momentum.CASE.ladder)
def test_cubes_that_pass_through_each_other_fail_though_all_sums_stay(dt: float) -> None:
    run = flight(impact_momentum.CASE, dt)
    run.p_WB[:] = run.p_WB[0] + run.time[:, None, None] * run.v_WB[0]
    found = verdicts(impact_momentum.CASE, run)
    assert found.pop("inscribed_overlap") is False
    assert all(found.values())


def test_a_shift_of_a_micrometre_across_the_motion_breaks_angular_momentum() -> None:
    run = flight(impact_momentum.CASE, 1 / 240)
    run.p_WB[:] = run.p_WB[0] + run.time[:, None, None] * run.v_WB[0]
    run.p_WB[200:, 0] += 1e-4 * np.cross(run.v_WB[0, 0], [0.0, 0.0, 1.0])
    found = verdicts(impact_momentum.CASE, run)
    assert not found["angular_momentum_drift_max"]
    assert found["momentum_drift_max"]


def test_no_two_cubes_touch_at_the_start_and_every_seed_is_another_scene() -> None:
    for seed in range(20):
        stage = impact_momentum.scene(impact_momentum.P(seed=seed))
        p = np.array([b.p_WB for b in stage.bodies])
        apart = np.linalg.norm(p[:, None] - p[None], axis=-1) + 10 * np.eye(8)
        assert apart.min() > 2 * np.sqrt(3) * impact_momentum.HALF
    assert (
        impact_momentum.scene(impact_momentum.P(seed=1))
        == impact_momentum.scene(impact_momentum.P(seed=1))
        != impact_momentum.scene(impact_momentum.P(seed=2))
    )


@pytest.mark.parametrize(
    ("case", "effects"),
    [
        (impact_oblique, {"contact", "friction", "restitution"}),
        (impact_pairs, {"contact", "restitution"}),
        (impact_cradle, {"contact", "restitution"}),
        (impact_gas, {"contact", "restitution"}),
        (impact_momentum, {"contact", "friction"}),
    ],
)
def test_only_the_effects_in_question_are_called_for(case: Any, effects: set[str]) -> None:
    scene: Scene = case.scene(case.P())
    assert set(scene.effects.names) == effects
