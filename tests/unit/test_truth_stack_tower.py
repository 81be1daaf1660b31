"""The truth of stack_tower: geometry and statics by hand, and each planted fault fails its own check."""

from dataclasses import replace

import numpy as np
import pytest

from plumbline.cases.stack_tower import CASE, HALF, P, expected, scene
from plumbline.harness.scene import axis_angle
from plumbline.harness.trajectory import Contacts, Trajectory

G = 9.81


@pytest.mark.parametrize("n", [1, 2, 10, 30, 3.0])
def test_the_tower_touches_throughout_and_is_n_edges_high(n: float) -> None:
    boxes = [b for b in scene(P(n=n)).bodies if b.movable]
    assert len(boxes) == n
    heights = [b.p_WB[2] for b in boxes]
    np.testing.assert_allclose(np.diff([-HALF, *heights]), 2 * HALF, atol=1e-14)
    assert heights[-1] + HALF == pytest.approx(n * 2 * HALF)
    np.testing.assert_array_equal(expected(np.array([0.0, 9.0]), P(n=n)).p_WB[1, 1:, 2], heights)


def stand(dt: float = 1 / 240) -> Trajectory:
    """The truth at 60 Hz with one contact a box that bears all above it."""
    stage, time = scene(P()), np.arange(301) / 60
    n = len(stage.bodies) - 1
    contacts = Contacts.of(
        list(range(n)),
        list(range(1, n + 1)),
        [[0.0, 0.0, 2 * HALF * i] for i in range(n)],
        [[0.0, 0.0, 1.0]] * n,
        [0.0] * n,
        [[0.0, 0.0, (n - i) * G] for i in range(n)],
    )
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
    assert all(verdicts(stand(dt)).values())


def test_a_tower_that_falls_fails_as_collapsed() -> None:
    run = stand()
    run.p_WB[200:, 10] = (1.2, 0.0, HALF)
    found = verdicts(run)
    assert not found["standing_height"]
    assert not found["stack_height_error"]


def test_boxes_that_sink_two_millimetres_into_each_other_fail() -> None:
    run = stand()
    run.p_WB[30:, 1:, 2] -= 2e-3 * np.arange(1, 11)
    found = verdicts(run)
    assert found["standing_height"]
    assert not found["stack_height_error"]


def test_a_tower_that_sways_fails() -> None:
    run = stand()
    run.v_WB[:, 1:, 0] = 0.1 * np.sin(3 * run.time)[:, None]
    assert not verdicts(run)["residual_kinetic_energy"]


def test_a_box_that_spins_in_place_fails() -> None:
    run = stand()
    run.w_WB[:, 5, 2] = 6.0
    run.q_WB[:, 5] = axis_angle((0, 0, 1), 0.3)
    assert not verdicts(run)["residual_kinetic_energy"]


def test_a_ground_that_bears_one_box_less_fails() -> None:
    run = stand()
    full = run.contacts[0]  # type: ignore[index]
    light = replace(full, force_W=full.force_W - np.array([0.0, 0.0, G]))
    assert not verdicts(replace(run, contacts=(light,) * len(run)))["support_force_error"]
