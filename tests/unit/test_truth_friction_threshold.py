"""The truth of friction_threshold against Newton's law in world coordinates, and its checks against wrong friction."""

import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from plumbline.cases.friction_threshold import CASE, HALF, STEEPNESS, P, expected, scene
from plumbline.harness.scene import Box, rotation_matrix
from plumbline.harness.trajectory import Trajectory

G = np.array([0.0, 0.0, -9.81])


@pytest.mark.parametrize("mu", [0.2, 0.5, 0.9])
def test_each_box_moves_as_newtons_law_in_the_world_frame_says(mu: float) -> None:
    stage = scene(P(friction=mu))
    times = np.linspace(0.0, 1.0, 11)
    truth = expected(times, P(friction=mu))
    for place, body in enumerate(stage.bodies):
        if not body.movable:
            continue
        normal = np.array(rotation_matrix(body.q_WB))[:, 2]
        support = -(G @ normal)
        pull = G + support * normal
        # At rest, friction must balance the pull along the incline; it can up to mu times the support.
        excess = np.linalg.norm(pull) - mu * support
        if excess <= 0:
            np.testing.assert_array_equal(truth.p_WB[:, place] - truth.p_WB[0, place], 0.0)
            continue
        start = np.concatenate((body.p_WB, 1e-9 * pull / np.linalg.norm(pull)))
        run = solve_ivp(
            lambda _, y, n=normal, s=support: np.concatenate((y[3:], G + s * n - mu * s * y[3:] / np.linalg.norm(y[3:]))),
            (0, 1),
            start,
            t_eval=times,
            rtol=1e-9,
            atol=1e-12,
        )
        np.testing.assert_allclose(truth.p_WB[:, place], run.y[:3].T, atol=1e-7)
        np.testing.assert_allclose(truth.v_WB[:, place], run.y[3:].T, atol=1e-7)


def test_boxes_start_touching_their_inclines_and_stay_on_them() -> None:
    stage = scene(P())
    truth = expected(np.array([0.0, CASE.duration]), P())
    for place, box in enumerate(stage.bodies):
        if box.movable:
            incline = stage.bodies[place - 1]
            shape = incline.collision[0].shape
            assert isinstance(shape, Box)
            frame = np.array(rotation_matrix(incline.q_WB))
            for k in (0, 1):
                local = frame.T @ (truth.p_WB[k, place] - np.array(incline.p_WB))
                assert local[2] == pytest.approx(shape.half_extents[2] + HALF[2], abs=1e-12)
                assert abs(local[0]) + HALF[0] < shape.half_extents[0]


def test_no_box_tips_before_it_slides() -> None:
    assert max(STEEPNESS) * 0.5 * HALF[2] < HALF[0]


def engine(dt: float, mu: float = 0.5, creep: float = 0.0) -> Trajectory:
    """Semi-implicit Euler along each incline with friction mu; boxes that hold move at `creep` [m/s]."""
    stage, steps = scene(P()), round(CASE.duration / dt)
    run = replace(Trajectory.of(np.arange(steps + 1) * dt, len(stage.bodies)), dt=dt)
    for place, body in enumerate(stage.bodies):
        run.p_WB[:, place], run.q_WB[:, place] = body.p_WB, body.q_WB
        if body.movable:
            frame = np.array(rotation_matrix(body.q_WB))
            angle = math.atan2(-frame[2, 0], frame[2, 2])
            a = 9.81 * (math.sin(angle) - mu * math.cos(angle))
            k = np.arange(steps + 1)
            way = a * dt**2 * k * (k + 1) / 2 if a > 0 else creep * run.time
            run.p_WB[:, place] += np.outer(way, frame[:, 0])
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
    assert all(verdicts(engine(dt)).values())


@pytest.mark.parametrize("mu", [0.475, 0.525])
def test_friction_a_twentieth_off_moves_the_threshold_and_the_acceleration(mu: float) -> None:
    found = verdicts(engine(1 / 240, mu=mu))
    assert not found["threshold_angle_error"]
    assert not found["incline_acceleration_error"]


def test_boxes_that_creep_five_millimetres_a_second_fail() -> None:
    found = verdicts(engine(1 / 240, creep=5e-3))
    assert found["threshold_angle_error"]
    assert not found["creep_speed"]
