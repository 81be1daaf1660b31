"""The truth of friction_stop against integration with a stopping event, work and energy, and its own checks."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from plumbline.cases.friction_stop import CASE, HALF, P, expected, scene
from plumbline.harness.trajectory import Floats, Trajectory

G = 9.81


@pytest.mark.parametrize("speed", [0.5, 2.0, 3.0])
@pytest.mark.parametrize("mu", [0.1, 0.2, 0.4, 0.7])
def test_the_way_agrees_with_integration_up_to_the_stop(mu: float, speed: float) -> None:
    def stop(t: float, y: Floats) -> float:
        return float(y[1])

    stop.terminal = True  # type: ignore[attr-defined]
    found = solve_ivp(
        lambda _, y: [y[1], -mu * G * np.sign(y[1])], (0, 10), [0, speed], events=stop, rtol=1e-11, atol=1e-13, max_step=0.01
    )
    times = np.append(found.t, found.t[-1] + np.array([0.1, 1.0]))
    truth = expected(times, P(frictions=(mu,), speed=speed))
    np.testing.assert_allclose(truth.p_WB[:-2, 1, 0], found.y[0], atol=1e-9)
    np.testing.assert_allclose(truth.v_WB[:-2, 1, 0], found.y[1], atol=1e-9)
    np.testing.assert_allclose(truth.p_WB[-2:, 1, 0], found.y[0, -1], atol=1e-9)
    assert not truth.v_WB[-2:].any()


@pytest.mark.parametrize("mu", [0.2, 0.4, 0.7])
def test_friction_does_the_work_of_the_kinetic_energy(mu: float) -> None:
    way = expected(np.array([5.0]), P(frictions=(mu,), speed=2.0)).p_WB[0, 1, 0]
    assert mu * 1.0 * G * way == pytest.approx(0.5 * 1.0 * 2.0**2, rel=1e-14)


def test_no_friction_never_stops() -> None:
    assert expected(np.array([7.0]), P(frictions=(0.0,), speed=2.0)).p_WB[0, 1, 0] == 14.0


def test_the_truth_starts_where_the_scene_does() -> None:
    bodies, truth = scene(P()).bodies, expected(np.array([0.0]), P())
    np.testing.assert_array_equal(truth.p_WB[0], [b.p_WB for b in bodies])
    np.testing.assert_array_equal(truth.v_WB[0], [b.v_WB for b in bodies])


def test_no_box_can_tip_and_all_stop_before_the_last_check_begins() -> None:
    assert max(CASE.parameters["frictions"]) * HALF[2] < HALF[0]
    stop = CASE.parameters["speed"] / (min(CASE.parameters["frictions"]) * G)
    assert stop < min(c.start for c in CASE.checks if c.start > 0)


def euler(dt: float, scale: float = 1.0, lift: float = 0.0, buzz: float = 0.0) -> Trajectory:
    """Semi-implicit Euler with Coulomb impulses; `scale` on mu, `lift` [m] of all boxes at first, `buzz` [m/s] at the end."""
    stage, steps = scene(P()), round(CASE.duration / dt)
    run = replace(Trajectory.of(np.arange(steps + 1) * dt, len(stage.bodies)), dt=dt)
    run.p_WB[:] = [b.p_WB for b in stage.bodies]
    run.v_WB[0] = [b.v_WB for b in stage.bodies]
    for place, body in enumerate(stage.bodies[1:], start=1):
        mu = scale * stage.surface(body, stage.bodies[0]).kinetic_friction
        x, v = 0.0, body.v_WB[0]
        for k in range(1, steps + 1):
            v = max(v - mu * G * dt, 0.0)
            x += v * dt
            run.p_WB[k, place, 0], run.v_WB[k, place, 0] = x, v
    run.p_WB[: steps // 10, 1:, 2] += lift
    run.v_WB[-steps // 20 :, 1:, 1] += buzz
    return run


def verdicts(run: Trajectory) -> dict[str, bool]:
    truth = expected(run.time, P())
    return {
        c.metric.name: c.passes(
            c.metric(scene(P()), run.between(c.start, 99.0), truth.between(c.start, 99.0)), run.dt, CASE.parameters
        )
        for c in CASE.checks
        # Made by hand, a run has no contact forces: the laws of these have tests of their own.
        if not c.metric.name.endswith("_residual")
    }


@pytest.mark.parametrize("dt", CASE.ladder)
def test_a_plain_engine_passes_every_check_at_every_step(dt: float) -> None:
    assert all(verdicts(euler(dt)).values())


def test_friction_that_is_a_twentieth_too_strong_fails() -> None:
    found = verdicts(euler(1 / 960, scale=1.05))
    assert not found["stop_distance_error"]
    assert not found["stop_time_error"]


def test_a_box_that_lifts_off_fails() -> None:
    assert not verdicts(euler(1 / 960, lift=1.1e-3))["centre_rise"]


def test_a_box_that_goes_on_buzzing_after_its_stop_fails() -> None:
    assert not verdicts(euler(1 / 960, buzz=0.1))["rms_speed"]
