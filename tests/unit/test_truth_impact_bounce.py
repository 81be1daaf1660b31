"""The truth of impact_bounce against event-driven integration, textbook sums and its own checks."""

import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from plumbline.cases.impact_bounce import CASE, P, expected, scene
from plumbline.harness.trajectory import Floats, Trajectory

G = 9.81


def integrate(restitution: float, drop: float, times: Floats) -> tuple[Floats, Floats]:
    """Gap and speed at `times` by event-driven integration: fall until contact, reverse, go on."""

    def contact(t: float, y: Floats) -> float:
        return float(y[0])

    contact.terminal = True  # type: ignore[attr-defined]
    contact.direction = -1  # type: ignore[attr-defined]
    gap, speed = np.zeros_like(times), np.zeros_like(times)
    t, y = 0.0, np.array([drop, 0.0])
    while t < times[-1] and (y[0] > 1e-8 or y[1] > 1e-3):
        run = solve_ivp(
            lambda _, s: [s[1], -G], (t, times[-1]), y, events=contact, rtol=1e-11, atol=1e-13, dense_output=True, max_step=0.1
        )
        inside = (times >= t) & (times <= run.t[-1])
        if inside.any():
            gap[inside], speed[inside] = run.sol(times[inside])
        t, y = float(run.t[-1]), np.array([1e-9, -restitution * run.y[1, -1]])
    return gap, speed


@pytest.mark.parametrize("drop", [0.2, 1.0, 3.0])
@pytest.mark.parametrize("restitution", [0.0, 0.3, 0.5, 0.8, 0.95, 1.0])
def test_heights_and_speeds_agree_with_event_driven_integration(restitution: float, drop: float) -> None:
    times = np.linspace(0.0, 3.0, 997)
    truth = expected(times, P(restitutions=(restitution,), drop=drop, radius=0.1))
    gap, speed = integrate(restitution, drop, times)
    # The integrator starts each hop 1 nm high and stops at 1 mm/s, whose hops rise 0.05 um. Speeds jump at impacts, so they are
    # compared away from them.
    np.testing.assert_allclose(truth.p_WB[:, 1, 2] - 0.1, gap, atol=2e-7)
    away = gap > 1e-3
    np.testing.assert_allclose(truth.v_WB[away, 1, 2], speed[away], atol=1e-6)


@pytest.mark.parametrize(("restitution", "total"), [(0.5, 1.35457), (0.8, 4.06371), (0.9, 8.57895)])
def test_all_bouncing_ends_at_the_sum_of_the_geometric_series(restitution: float, total: float) -> None:
    assert math.sqrt(2 / G) * (1 + restitution) / (1 - restitution) == pytest.approx(total, abs=6e-6)
    truth = expected(np.array([total - 1e-3, total + 1e-5]), P(restitutions=(restitution,)))
    assert truth.p_WB[0, 1, 2] > 0.1
    assert truth.p_WB[1, 1, 2] == 0.1
    assert truth.v_WB[1, 1, 2] == 0.0


@pytest.mark.parametrize("restitution", [0.3, 0.8, 1.0])
def test_energy_is_kept_in_flight_and_falls_by_the_square_of_the_restitution(restitution: float) -> None:
    times = np.linspace(0.0, 2.0, 4001)
    truth = expected(times, P(restitutions=(restitution,)))
    energy = G * (truth.p_WB[:, 1, 2] - 0.1) + truth.v_WB[:, 1, 2] ** 2 / 2
    levels = {restitution ** (2 * n) for n in range(60)} | {0.0}
    assert all(min(abs(e / G - level) for level in levels) < 1e-9 for e in energy)
    assert np.all(np.diff(energy) < 1e-9)


def test_the_truth_starts_where_the_scene_does() -> None:
    bodies, truth = scene(P()).bodies, expected(np.array([0.0]), P())
    np.testing.assert_array_equal(truth.p_WB[0], [b.p_WB for b in bodies])


def semi_implicit(dt: float, gain: float = 0.0) -> Trajectory:
    """The scene by semi-implicit Euler with Newton's law at the ground; `gain` is added to each e."""
    stage = scene(P())
    steps = round(CASE.duration / dt)
    run = replace(Trajectory.of(np.arange(steps + 1) * dt, len(stage.bodies)), dt=dt)
    run.p_WB[0] = [b.p_WB for b in stage.bodies]
    for place, body in enumerate(stage.bodies[1:], start=1):
        e = stage.surface(body, stage.bodies[0]).restitution + gain
        z, v = body.p_WB[2] - 0.1, 0.0
        for k in range(1, steps + 1):
            v -= G * dt
            if z + v * dt < 0 and v < 0:
                v = -e * v if -v > 2 * G * dt else 0.0
            z = max(z + v * dt, 0.0)
            run.p_WB[k, place] = (0.0, body.p_WB[1], z + 0.1)
            run.v_WB[k, place, 2] = v
    return run


def verdicts(run: Trajectory) -> dict[str, bool]:
    truth = expected(run.time, P())
    # Made by hand, a run has no contact forces: the laws of these have tests of their own.
    judged = [c for c in CASE.checks if not c.metric.name.endswith("_residual")]
    return {c.metric.name: c.passes(c.metric(scene(P()), run, truth), run.dt, CASE.parameters) for c in judged}


def test_the_truth_passes_every_check() -> None:
    times = np.arange(1081) / 240
    assert all(verdicts(replace(expected(times, P()), dt=1 / 240)).values())


@pytest.mark.parametrize("dt", [1 / 240, 1 / 960])
def test_a_plain_engine_with_the_right_restitution_passes_every_check(dt: float) -> None:
    # A ball turned above the ground at e = 1 gains up to v dt of height, which is no property of the law.
    assert all(verdicts(semi_implicit(dt)).values())


def test_one_bounce_may_gain_what_it_may_err_by() -> None:
    bounds = {check.metric.name: check.bound(1 / 240, CASE.parameters) for check in CASE.checks}
    assert bounds["bounce_gain"] == bounds["bounce_height_error"]


@pytest.mark.parametrize("e", [0.3, 0.5, 0.8, 0.94])
@pytest.mark.parametrize("weight", [0.005, 0.05])
def test_gravity_takes_no_more_of_a_spring_s_rebound_than_is_granted(e: float, weight: float) -> None:
    """A spring and damper that cannot pull, of half period T = 1 at v = 1, under gravity `weight` = g T/v, 4000 steps a T."""

    def rebound(z: float, g: float) -> tuple[float, float]:
        p = math.asin(z)
        w, h, x, v, t = (math.pi - 2 * p) / math.cos(p), 1 / 4000, 0.0, -1.0, 0.0
        while (push := -w * w * x - 2 * z * w * v) > 0 or v < 0:
            v, t = v + h * (max(push, 0.0) - g), t + h
            x += h * v
        speed = math.sqrt(v * v + 2 * g * x)
        return speed, t + ((v - speed) / g if g > 0 else -x / v)

    low, high = 0.0, 0.6
    for _ in range(30):
        middle = (low + high) / 2
        low, high = (middle, high) if rebound(middle, 0.0)[0] > e else (low, middle)
    free, _ = rebound(low, 0.0)
    heavy, left = rebound(low, weight)
    # A step of T/4000 leaves as much; the terms of second order are the square of the weight.
    assert abs(heavy**2 - free**2) <= weight / 3 + weight**2 + 1 / 4000
    # The flight that follows is shorter by 2 (e - e') v/g; with the way through the contact that is at most T late.
    assert left - 2 * (free - heavy) / weight <= 1 + weight + 2 / 4000 / weight


def test_a_restitution_that_is_off_by_a_twentieth_fails() -> None:
    found = verdicts(semi_implicit(1 / 960, gain=0.05))
    assert not found["bounce_height_error"]
    assert not found["bounce_gain"]


def test_a_ball_that_never_bounces_fails() -> None:
    found = verdicts(semi_implicit(1 / 960, gain=-1.0))
    assert not found["bounce_height_error"]
    assert not found["impact_time_error"]
