"""Which point of a moving body stays where it is."""

import numpy as np
import pytest

from plumbline.harness.trajectory.kinematics import rotate
from plumbline.reports.recordings.bodies import ROUNDING, pivot_of
from plumbline.reports.recordings.layout import Floats

TIME = np.linspace(0.0, 2.0, 241)
P, ARM = np.array([1.0, -2.0, 0.5]), np.array([0.3, 0.1, -0.4])


def wobbling() -> Floats:
    """Attitudes (t, 4) that turn about all axes."""
    q = np.stack([np.cos(3 * TIME), np.sin(5 * TIME), np.sin(2 * TIME + 1), np.cos(7 * TIME)], axis=1)
    return np.asarray(q / np.linalg.norm(q, axis=1, keepdims=True))


def about_z() -> Floats:
    """Attitudes (t, 4) of a hinge."""
    none = np.zeros_like(TIME)
    return np.stack([np.cos(TIME), none, none, np.sin(TIME)], axis=1)


def test_a_body_on_a_ball_joint_turns_about_it() -> None:
    q_WB = wobbling()
    pivot = pivot_of(P - rotate(q_WB, ARM), q_WB)
    assert pivot is not None
    assert pivot.p_WP == pytest.approx(P, abs=1e-12)
    assert pivot.p_BP == pytest.approx(ARM, abs=1e-12)


def test_of_a_hinge_it_is_the_point_of_the_axis_next_to_the_centre() -> None:
    q_WB = about_z()
    pivot = pivot_of(P - rotate(q_WB, ARM), q_WB)
    assert pivot is not None
    assert pivot.p_BP == pytest.approx([*ARM[:2], 0.0], abs=1e-12)
    assert pivot.p_WP == pytest.approx([*P[:2], P[2] - ARM[2]], abs=1e-12)


@pytest.mark.parametrize(("share", "holds"), [(0.5, True), (40.0, False)])
@pytest.mark.parametrize("when", [0, 121, 240])
def test_a_joint_that_gives_by_more_than_roundings_is_no_pivot(share: float, holds: bool, when: int) -> None:
    """Off by so many roundings of the distance of the joint at one instant, be it one that the pivot is sought at or not."""
    q_WB = wobbling()
    p_WB = P - rotate(q_WB, ARM)
    p_WB[when, 1] += share * ROUNDING * np.linalg.norm(P)
    assert (pivot_of(p_WB, q_WB) is not None) == holds


def test_what_rolls_flies_or_slides_has_none() -> None:
    still = np.broadcast_to([1.0, 0.0, 0.0, 0.0], (len(TIME), 4))
    line = np.stack([TIME, 0 * TIME, 0 * TIME], axis=1)
    assert pivot_of(line, about_z()) is None
    assert pivot_of(line, still) is None
    assert pivot_of(np.stack([TIME, 0 * TIME, -TIME * TIME], axis=1), wobbling()) is None


@pytest.mark.parametrize("angle", [1e-3, 0.1, 3.0])
def test_an_arm_almost_as_long_as_is_allowed_that_hardly_turns_has_its_pivot(angle: float) -> None:
    """The farthest that a body goes by a turn is the chord of the longest arm: what it is held against must not be less."""
    half, none = angle * TIME / TIME[-1] / 2, np.zeros_like(TIME)
    q_WB = np.stack([np.cos(half), none, np.sin(half), none], axis=1)
    arm = np.array([1.0, 0.0, 0.0])
    p_WB = 0.45 * arm - rotate(q_WB, arm)
    pivot = pivot_of(p_WB, q_WB)
    assert pivot is not None
    assert np.linalg.norm(arm) > 1.5 * np.linalg.norm(p_WB[0])
    assert p_WB == pytest.approx(pivot.p_WP - rotate(q_WB, pivot.p_BP), abs=1e-6)


def test_one_that_is_too_far_for_single_precision_is_none() -> None:
    """A body close to the origin on an arm of a kilometre: what rounds the arm would shake the body."""
    small = np.stack([np.ones_like(TIME), 0 * TIME, 0 * TIME, 1e-4 * np.sin(9 * TIME)], axis=1)
    q_WB = small / np.linalg.norm(small, axis=1, keepdims=True)
    arm = np.array([1e3, 0.0, 0.0])
    assert pivot_of(arm - rotate(q_WB, arm), q_WB) is None


def test_a_single_instant_tells_of_no_turn() -> None:
    pivot = pivot_of(P[None], wobbling()[:1])
    assert pivot is None or pivot.p_BP == pytest.approx(np.zeros(3))
