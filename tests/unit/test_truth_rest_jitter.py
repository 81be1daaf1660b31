"""The truth of rest_jitter: the scene is in equilibrium, its truth passes every check, and each planted fault fails its own."""

from dataclasses import replace

import numpy as np
import pytest

from plumbline.cases.rest_jitter import CASE, HALF, P, expected, scene
from plumbline.harness.trajectory import Contacts, Trajectory

G = 9.81
DT = 1 / 240


def corners(height: float) -> np.ndarray:
    """The four corners (4, 3) m of a box's base."""
    return np.array([[x, y, height] for x in (-HALF, HALF) for y in (-HALF, HALF)])


@pytest.mark.parametrize("n", [1, 3, 5, 8])
def test_forces_at_the_corners_hold_every_box_in_equilibrium(n: int) -> None:
    """Statics by linear algebra: unknown normal forces at the corners of each base, three equations a box, least squares."""
    column = [b for b in scene(P(n=n)).bodies if b.movable and b.p_WB[0] == 0.0]
    assert len(column) == n
    rows, weights = np.zeros((3 * n, 4 * n)), np.zeros(3 * n)
    for k, box in enumerate(column):
        assert box.p_WB[2] - HALF == pytest.approx(0.0 if k == 0 else column[k - 1].p_WB[2] + HALF, abs=1e-15)
        arms = corners(0.0)
        for upper, sign in ((k, 1.0), (k + 1, -1.0)):
            if upper < n:
                rows[3 * k, 4 * upper : 4 * upper + 4] = sign
                rows[3 * k + 1, 4 * upper : 4 * upper + 4] = sign * arms[:, 1]
                rows[3 * k + 2, 4 * upper : 4 * upper + 4] = -sign * arms[:, 0]
        weights[3 * k] = box.mass * G
    forces, *_ = np.linalg.lstsq(rows, weights, rcond=None)
    np.testing.assert_allclose(rows @ forces, weights, atol=1e-9)
    assert forces.min() > 0
    assert forces[:4].sum() == pytest.approx(n * G)


def test_boxes_of_the_column_and_the_single_one_do_not_touch() -> None:
    single, column = scene(P()).bodies[1], scene(P()).bodies[2]
    assert abs(single.p_WB[0] - column.p_WB[0]) > 4 * HALF


def rest(dt: float = DT) -> Trajectory:
    """The truth with the contacts of statics, from 5 s on, every step."""
    time = 5.0 + np.arange(round(1 / dt) + 1) * dt
    stage = scene(P())
    body_A, body_B, points, forces = [], [], [], []
    for place, box in enumerate(stage.bodies):
        if box.movable:
            below = 0 if box.p_WB[2] < 2 * HALF else place - 1
            above = 1 if place == 1 else len(stage.bodies) - place
            body_A += [below] * 4
            body_B += [place] * 4
            points += (corners(-HALF) + box.p_WB).tolist()
            forces += [[0.0, 0.0, above * G / 4]] * 4
    contacts = Contacts.of(body_A, body_B, points, [[0.0, 0.0, 1.0]] * len(points), [0.0] * len(points), forces)
    return replace(expected(time, P()), dt=dt, contacts=(contacts,) * len(time))


def verdicts(run: Trajectory) -> dict[str, bool]:
    return {
        c.metric.name: c.passes(
            c.metric(scene(P()), run.between(c.start, 99.0), expected(run.time, P())), run.dt, CASE.parameters
        )
        for c in CASE.checks
    }


@pytest.mark.parametrize("dt", CASE.ladder)
def test_the_truth_passes_every_check(dt: float) -> None:
    assert all(verdicts(rest(dt)).values())


def test_a_box_that_is_dropped_and_caught_every_step_fails() -> None:
    """Alternating by the way of half a step of gravity: the classic buzz."""
    run = rest()
    sign = (-1.0) ** np.arange(len(run))
    run.p_WB[:, 3, 2] += sign * G * DT**2 / 2
    run.v_WB[:, 3, 2] += sign * G * DT
    found = verdicts(run)
    assert not found["rms_speed"]
    assert not found["rms_second_difference"]
    assert not found["height_spread"]
    assert found["rms_spin"]


def test_a_slow_drift_fails() -> None:
    run = rest()
    run.p_WB[:, 1, 0] += 1e-3 * (run.time - 5.0)
    assert not verdicts(run)["rest_drift"]


def test_a_wobble_fails() -> None:
    run = rest()
    run.w_WB[:, 2, 1] = 0.01 * np.sin(40 * run.time)
    assert not verdicts(run)["rms_spin"]


def test_a_single_flicker_of_one_contact_fails() -> None:
    run = rest()
    full = run.contacts[0]  # type: ignore[index]
    fewer = Contacts.of(full.body_A[1:], full.body_B[1:], full.point_W[1:], full.normal_W[1:], full.gap[1:], full.force_W[1:])
    found = verdicts(replace(run, contacts=(full,) * 100 + (fewer,) + (full,) * (len(run) - 101)))
    assert not found["contact_flips"]


def test_a_ground_that_bears_a_thousandth_too_much_fails() -> None:
    run = rest()
    full = run.contacts[0]  # type: ignore[index]
    heavy = replace(full, force_W=full.force_W * 1.001)
    assert not verdicts(replace(run, contacts=(heavy,) * len(run)))["support_force_error"]
