"""Balls on the edge: the closed form against quadrature of Newton's law, and what an engine adds, planted and found."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from plumbline.cases.system_predictability import BUMP, CASE, EXPONENT, JUDGED, RADIUS, REACH, P, expected, scene, tilts
from plumbline.harness.metric import NotMeasurable
from plumbline.harness.metrics.chaos import (
    exit_time_error_rms,
    growth_exponent_error,
    lost_start_share,
    smallest_followed_start,
)
from plumbline.harness.scene import Scene
from plumbline.harness.trajectory import Floats, Trajectory

METRICS = (growth_exponent_error, lost_start_share, smallest_followed_start, exit_time_error_rms)

TIME = np.arange(196) / 60
G = 9.81


def test_the_tilt_obeys_the_law_of_a_ball_that_rolls_on_a_ball() -> None:
    """Newton for the centre and Euler for the spin, with friction as the force that keeps the slip at nought."""
    start = np.array([1e-9, 1e-6, 1e-3, 1e-2])
    found = tilts(TIME, start)

    def change(_t: float, y: Floats) -> Floats:
        theta, rate = np.split(y, 2)
        # m R theta'' = m g sin - F, I w' = F r with I = 2/5 m r^2 and r w = R theta': F = 2/7 m g sin.
        return np.concatenate([rate, (G * np.sin(theta) - 2 / 7 * G * np.sin(theta)) / (BUMP + RADIUS)])

    for k, tilt in enumerate(start):
        end = TIME[found[:, k] < JUDGED * (1 - 1e-9)]
        exact = solve_ivp(change, (0.0, end[-1]), [tilt, 0.0], "DOP853", end, rtol=1e-12, atol=1e-22).y[0]
        # The expansion leaves 1e-8, and the integration 1e-12 a step.
        np.testing.assert_allclose(found[: len(end), k], exact, rtol=1e-7)
    assert (found <= JUDGED * (1 + 1e-12)).all()
    assert (np.diff(found, axis=0) >= 0).all()


def test_the_smallest_start_is_out_when_its_exponent_says_and_before_a_tenfold_delay_ends() -> None:
    truth = expected(TIME, P())
    assert exit_time_error_rms(scene(P()), truth, truth) == 0.0
    out = TIME[np.argmax(tilts(TIME, np.array([1e-9]))[:, 0] >= 0.1)]
    assert out == pytest.approx(np.log(2 * 0.1 / 1e-9) / EXPONENT, abs=1 / 60)
    assert out + np.log(10.0) / EXPONENT < CASE.duration


def _verdicts(run: Trajectory) -> dict[str, bool]:
    truth = expected(run.time, P())
    return {c.metric.name: c.passes(c.metric(scene(P()), run, truth), run.dt, CASE.parameters) for c in CASE.checks}


def _at(theta: Floats, truth: Trajectory) -> Trajectory:
    """Balls at tilts (t, n) on the sides that the truth has."""
    run = replace(truth, p_WB=truth.p_WB.copy(), dt=1 / 240)
    line = truth.p_WB[:, 1::2] - truth.p_WB[:, ::2]
    side = line[..., :2] / np.linalg.norm(line[..., :2], axis=-1, keepdims=True)
    run.p_WB[:, 1::2, :2] = truth.p_WB[:, ::2, :2] + REACH * np.sin(theta)[..., None] * side
    run.p_WB[:, 1::2, 2] = REACH * np.cos(theta)
    return run


def test_the_truth_passes_and_each_fault_fails_its_check() -> None:
    truth = expected(TIME, P())
    start = np.geomspace(1e-9, 1e-3, 100)
    assert all(_verdicts(_at(tilts(TIME, start), truth)).values())
    assert not _verdicts(_at(tilts(0.95 * TIME, start), truth))["growth_exponent_error"]
    # Noise of 1e-7 stands in for starts below it.
    noisy = _at(tilts(TIME, np.maximum(start, 1e-7)), truth)
    assert not _verdicts(noisy)["lost_start_share"]
    # Starts from 1e-8 on are within a tenfold of the noise; a hundredth of six decades each.
    smallest = smallest_followed_start(scene(P()), noisy, truth)
    assert smallest == pytest.approx(1e-8, rel=0.2)
    assert lost_start_share(scene(P()), noisy, truth) == pytest.approx(1 / 6, abs=0.02)
    astray = _at(tilts(TIME, start), truth)
    astray.p_WB[:, 1, :2] = 2 * astray.p_WB[:, 0, :2] - astray.p_WB[:, 1, :2]
    assert lost_start_share(scene(P()), astray, truth) == pytest.approx(0.01)


def test_balls_that_stay_up_or_are_not_numbers_are_never_good() -> None:
    truth = expected(TIME, P())
    still = _at(np.broadcast_to(np.geomspace(1e-9, 1e-3, 100), (len(TIME), 100)), truth)
    assert lost_start_share(scene(P()), still, truth) == 1.0
    assert growth_exponent_error(scene(P()), still, truth) == 1.0
    assert smallest_followed_start(scene(P()), still, truth) == np.inf
    assert exit_time_error_rms(scene(P()), still, truth) == np.inf
    broken = replace(truth, p_WB=truth.p_WB.copy())
    broken.p_WB[9, 5] = np.nan
    with np.errstate(invalid="ignore"):
        for metric in METRICS:
            assert not np.isfinite(metric(scene(P()), broken, truth)), metric.name
    with pytest.raises(NotMeasurable, match="balls"):
        lost_start_share(Scene(bodies=scene(P()).bodies[:1]), truth, truth)


def test_bumps_stand_apart_and_every_ball_touches_its_own_from_the_first_step() -> None:
    stage = scene(P())
    bumps, balls = (np.array([b.p_WB for b in stage.bodies[k::2]]) for k in (0, 1))
    np.testing.assert_allclose(np.linalg.norm(balls - bumps, axis=1), REACH - 1e-6, atol=1e-12)
    apart = np.linalg.norm(bumps[:, None] - bumps[None], axis=2) + 9 * np.eye(100)
    assert apart.min() > 2 * (BUMP + 2 * RADIUS)
