"""The truth of friction_isotropy against integration of Coulomb's vector law, and its checks against a pyramid."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from plumbline.cases.friction_isotropy import CASE, P, expected, scene
from plumbline.harness.trajectory import Floats, Trajectory

G = 9.81


@pytest.mark.parametrize("speed", [1.0, 2.5])
@pytest.mark.parametrize("mu", [0.3, 0.5, 0.8])
def test_every_azimuth_agrees_with_integration_of_the_vector_law(mu: float, speed: float) -> None:
    def slow(t: float, y: Floats) -> float:
        return float(np.hypot(y[2], y[3]) - 1e-6)

    slow.terminal = True  # type: ignore[attr-defined]
    bodies = scene(P(directions=5, friction=mu, speed=speed)).bodies
    for place, body in enumerate(bodies[1:], start=1):
        start = [*body.p_WB[:2], *body.v_WB[:2]]
        assert np.hypot(*body.v_WB[:2]) == pytest.approx(speed, rel=1e-14)
        run = solve_ivp(
            lambda _, y: np.concatenate((y[2:], -mu * G * y[2:] / np.hypot(*y[2:]))),
            (0, 5),
            start,
            events=slow,
            rtol=1e-10,
            atol=1e-12,
            max_step=0.01,
        )
        truth = expected(run.t, P(directions=5, friction=mu, speed=speed))
        # The integration ends at 1 um/s, which leaves less than 1e-12 m of way.
        np.testing.assert_allclose(truth.p_WB[:, place, :2], run.y[:2].T, atol=1e-8)
        np.testing.assert_allclose(truth.v_WB[:, place, :2], run.y[2:].T, atol=1e-8)


@pytest.mark.parametrize("directions", [2, 13, 31])
def test_boxes_never_come_near_each_other(directions: int) -> None:
    truth = expected(np.linspace(0, 2, 50), P(directions=directions))
    gaps = np.linalg.norm(np.diff(truth.p_WB[:, 1:, :2], axis=1), axis=2)
    assert gaps.min() > 2 * 0.1 * np.sqrt(2)


def test_the_truth_starts_where_the_scene_does_and_rests_at_its_end() -> None:
    bodies, truth = scene(P()).bodies, expected(np.array([0.0, CASE.duration]), P())
    np.testing.assert_array_equal(truth.p_WB[0], [b.p_WB for b in bodies])
    np.testing.assert_allclose(truth.v_WB[0], [b.v_WB for b in bodies], atol=1e-15)
    assert not truth.v_WB[1].any()


def slide(dt: float, law: str) -> Trajectory:
    """Semi-implicit Euler, friction as a round cone, a pyramid (box of tangential forces), or a cone with 5 % more along y."""
    stage, steps, limit = scene(P()), round(CASE.duration / dt), 0.5 * G * dt
    run = replace(Trajectory.of(np.arange(steps + 1) * dt, len(stage.bodies)), dt=dt)
    run.p_WB[:] = [b.p_WB for b in stage.bodies]
    p, v = run.p_WB[0, :, :2].copy(), np.array([b.v_WB[:2] for b in stage.bodies])
    for k in range(1, steps + 1):
        if law == "pyramid":
            v = np.sign(v) * np.maximum(np.abs(v) - limit, 0.0)
        else:
            speed = np.linalg.norm(v, axis=1, keepdims=True)
            stretch = np.array([1.0, 1.05]) if law == "ellipse" else 1.0
            v = np.where(speed > limit, v - limit * stretch * v / np.maximum(speed, 1e-30), 0.0)
        p = p + v * dt
        run.p_WB[k, :, :2], run.v_WB[k, :, :2] = p, v
    return run


def verdicts(run: Trajectory) -> dict[str, bool]:
    # The first, that every state is finite, is every case's. Made by hand, a run has no contact forces.
    judged = [c for c in CASE.checks[1:] if not c.metric.name.endswith("_residual")]
    return {c.metric.name: c.passes(c.metric(scene(P()), run, expected(run.time, P())), run.dt, P()) for c in judged}


@pytest.mark.parametrize("dt", CASE.ladder)
def test_a_round_cone_passes_at_every_step(dt: float) -> None:
    assert all(verdicts(slide(dt, "cone")).values())


@pytest.mark.parametrize("dt", CASE.ladder)
def test_a_pyramid_fails_every_check_at_every_step(dt: float) -> None:
    assert not any(verdicts(slide(dt, "pyramid")).values())


def test_a_twentieth_more_friction_along_one_axis_fails() -> None:
    found = verdicts(slide(1 / 960, "ellipse"))
    assert not found["polar_spread"]
    assert not found["heading_error"]
